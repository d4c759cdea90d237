//! Materials of a model's surfaces. In: what each surface names, the sets of its room, and the
//! global sets. Out: materials named after their modifier or construction.

use std::collections::HashMap;

use crate::formats::building::notes::Notes;
use crate::formats::building::optics::Stated;
use crate::formats::honeybee::document::Model;
use crate::formats::honeybee::kind::{AdjacentSpace, Kind, Surface};
use crate::formats::honeybee::optics::{Layers, find, of_construction, of_modifier, shade_transmittance};
use crate::formats::honeybee::properties::{Construction, Layer, Modifier, Named, Schedule, Set, SubSet};
use crate::geometry::Geometry;
use crate::materials::select::MaterialTable;
use heliotile_core::site::material::{Class, Glass, Material};

const NOT_THERE: &str = "modifiers or constructions are not in the file; the next statement for the surface is used";
const NOTHING_SAID: &str = "surfaces have neither modifier nor construction; the default of honeybee is used";

/// Modifiers, constructions and their parts by identifier; the first of an identifier counts.
pub(super) struct Materials<'d> {
    modifiers: HashMap<&'d str, &'d Modifier>,
    constructions: HashMap<&'d str, &'d Construction>,
    layers: HashMap<&'d str, &'d Layer>,
    schedules: HashMap<&'d str, &'d Schedule>,
    modifier_sets: HashMap<&'d str, &'d Set<Modifier>>,
    construction_sets: HashMap<&'d str, &'d Set<Construction>>,
    global_modifiers: Option<&'d Set<Modifier>>,
    global_constructions: Option<&'d Set<Construction>>,
    stated: Stated,
}

impl<'d> Materials<'d> {
    pub(super) fn new(model: &'d Model) -> Self {
        let (radiance, energy) = (model.properties.radiance.as_ref(), model.properties.energy.as_ref());
        let sets = radiance.and_then(|radiance| radiance.modifier_sets.as_ref());
        let modifier_sets = by_name(sets.into_iter().flatten(), |set| set.identifier.as_deref().unwrap_or_default());
        let sets = energy.and_then(|energy| energy.construction_sets.as_ref());
        let construction_sets =
            by_name(sets.into_iter().flatten(), |set| set.identifier.as_deref().unwrap_or_default());
        let global_modifiers = radiance.and_then(|all| find(all.global_modifier_set.as_ref()?, &modifier_sets));
        let global_constructions =
            energy.and_then(|all| find(all.global_construction_set.as_ref()?, &construction_sets));
        let own = radiance.and_then(|radiance| radiance.modifiers.as_ref());
        let global = global_modifiers.and_then(|set| set.members.as_ref());
        let modifiers = by_name(own.into_iter().chain(global).flatten(), |modifier| &modifier.identifier);
        let own = energy.and_then(|energy| energy.constructions.as_ref());
        let global = global_constructions.and_then(|set| set.members.as_ref());
        let constructions = by_name(own.into_iter().chain(global).flatten(), |construction| &construction.identifier);
        let own = energy.and_then(|energy| energy.materials.as_ref());
        let global = global_constructions.and_then(|set| set.materials.as_ref());
        let schedules = energy.and_then(|energy| energy.schedules.as_ref());
        Materials {
            modifiers,
            constructions,
            layers: by_name(own.into_iter().chain(global).flatten(), |layer| &layer.identifier),
            schedules: by_name(schedules.into_iter().flatten(), |schedule| &schedule.identifier),
            modifier_sets,
            construction_sets,
            global_modifiers,
            global_constructions,
            stated: Stated::default(),
        }
    }

    pub(super) fn into_stated(self) -> MaterialTable {
        self.stated.0
    }

    /// Returns the number of a surface's material.
    pub(super) fn of(&mut self, surface: &Surface<'d>, geometry: &mut Geometry, notes: &mut Notes) -> u32 {
        let material = self.described(surface, notes).unwrap_or_else(|| {
            notes.add(NOTHING_SAID, surface.identifier);
            assumed(surface.kind)
        });
        let class = match surface.kind {
            Kind::Floor(AdjacentSpace::Ground) => Class::Ground,
            _ => Class::Obstruction,
        };
        self.stated.add(Material { class, ..material }, geometry)
    }

    /// Returns the file's material for a surface. The most specific statement counts: the object's,
    /// then its room's, then the model's. Modifiers of Radiance come before constructions, because
    /// they describe light better. In the global sets constructions come first: the global
    /// modifiers are made for indoors (`Generic_Interior_Visible_Modifier_Set`, whose roofs reflect
    /// 0.8), the global constructions for the outside in the sun.
    fn described(&self, surface: &Surface<'d>, notes: &mut Notes) -> Option<Material> {
        let (object, room) = (surface.properties, surface.room.map(|room| &room.properties));
        let radiance = object.radiance.as_ref().and_then(|own| own.modifier.as_ref());
        let energy = object.energy.as_ref();
        if let Kind::Shade { .. } = surface.kind
            && let Some(schedule) = energy.and_then(|own| own.transmittance_schedule.as_ref())
            && let Some(through) = shade_transmittance(find(schedule, &self.schedules), surface.identifier, notes)
        {
            return Some(through);
        }
        let modifiers = room.and_then(|room| find(room.radiance.as_ref()?.modifier_set.as_ref()?, &self.modifier_sets));
        let constructions =
            room.and_then(|room| find(room.energy.as_ref()?.construction_set.as_ref()?, &self.construction_sets));
        let of_kind = |set: &'d Set<Modifier>| pick(set, surface.kind, |part| part.interior.as_ref());
        let built = |set: &'d Set<Construction>| pick(set, surface.kind, |part| part.ground.as_ref());
        self.modifier(radiance, notes)
            .or_else(|| self.construction(energy.and_then(|own| own.construction.as_ref()), notes))
            .or_else(|| self.modifier(modifiers.and_then(of_kind), notes))
            .or_else(|| self.construction(constructions.and_then(built), notes))
            .or_else(|| self.construction(self.global_constructions.and_then(built), notes))
            .or_else(|| self.modifier(self.global_modifiers.and_then(of_kind), notes))
    }

    fn modifier(&self, name: Option<&Named<Modifier>>, notes: &mut Notes) -> Option<Material> {
        let name = name?;
        let Some(modifier) = find(name, &self.modifiers) else {
            notes.add(NOT_THERE, text(name));
            return None;
        };
        of_modifier(modifier, notes)
    }

    fn construction(&self, name: Option<&Named<Construction>>, notes: &mut Notes) -> Option<Material> {
        let name = name?;
        let Some(construction) = find(name, &self.constructions) else {
            notes.add(NOT_THERE, text(name));
            return None;
        };
        of_construction(construction, &Layers(&self.layers), notes)
    }
}

fn text<T>(named: &Named<T>) -> &str {
    match named {
        Named::By(name) => name,
        Named::Itself(_) => "",
    }
}

fn by_name<'d, T>(all: impl Iterator<Item = &'d T>, name: impl Fn(&'d T) -> &'d str) -> HashMap<&'d str, &'d T> {
    let mut found = HashMap::new();
    for one in all {
        found.entry(name(one)).or_insert(one);
    }
    found
}

/// Returns the member of a set for a kind of surface, as honeybee looks it up. `on_ground` returns
/// the member for faces on the ground, which differs between sets.
fn pick<'s, T>(
    set: &'s Set<T>,
    kind: Kind,
    on_ground: impl Fn(&'s SubSet<T>) -> Option<&'s Named<T>>,
) -> Option<&'s Named<T>> {
    let face = |part: &'s Option<SubSet<T>>, behind: AdjacentSpace| {
        let part = part.as_ref()?;
        match behind {
            AdjacentSpace::Outdoors => part.exterior.as_ref(),
            AdjacentSpace::Ground => on_ground(part),
            AdjacentSpace::Adiabatic => part.interior.as_ref(),
        }
    };
    let (windows, doors, shades) = (set.aperture_set.as_ref(), set.door_set.as_ref(), set.shade_set.as_ref());
    match kind {
        Kind::Wall(behind) => face(&set.wall_set, behind),
        Kind::Roof(behind) => face(&set.roof_ceiling_set, behind),
        Kind::Floor(behind) => face(&set.floor_set, behind),
        Kind::Window { operable: true, .. } => windows?.operable.as_ref(),
        Kind::Window { in_wall: true, .. } => windows?.window.as_ref(),
        Kind::Window { .. } => windows?.skylight.as_ref(),
        Kind::Door { glass: true, .. } => doors?.exterior_glass.as_ref(),
        Kind::Door { in_wall: true, .. } => doors?.exterior.as_ref(),
        Kind::Door { .. } => doors?.overhead.as_ref(),
        Kind::Shade { detached: true } => set.context.as_ref(),
        Kind::Shade { .. } => shades.and_then(|shades| shades.exterior.as_ref()).or(set.shade_construction.as_ref()),
    }
}

/// Returns the material of a surface that the file does not describe:
/// `Generic_Exterior_Solar_Modifier_Set` and `generic_context_0.20` of honeybee-standards 2.0.7
/// (`radiance_default.json`), and the two panes of `Generic Double Pane` (`energy_default.json`).
fn assumed(kind: Kind) -> Material {
    let (name, diffuse, glass) = match kind {
        Kind::Wall(_) => ("wall", 0.35, None),
        Kind::Roof(_) => ("roof", 0.35, None),
        Kind::Floor(_) => ("floor", 0.5, None),
        Kind::Window { .. } => ("window", 0.0, Some(Glass::Double)),
        Kind::Door { glass: true, .. } => ("glass door", 0.0, Some(Glass::Double)),
        Kind::Door { .. } => ("door", 0.5, None),
        Kind::Shade { detached: true } => ("context", 0.2, None),
        Kind::Shade { .. } => ("shade", 0.35, None),
    };
    Material { glass, ..Material::matt(name, diffuse, Class::Obstruction) }
}
