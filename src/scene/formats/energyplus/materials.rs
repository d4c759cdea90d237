//! Optical materials of a model. In: constructions, their layers and the properties of shades. Out:
//! materials named after their construction, one for each set of optical properties.

use std::collections::HashMap;
use std::path::Path;

use crate::formats::building::notes::Notes;
use crate::formats::building::optics;
use crate::formats::building::optics::{ABSORPTANCE, LEAF_REFLECTANCE, Stated, glass_of_panes, panes_of_system};
use crate::formats::energyplus::model::{Model, Object, same, share, stated_share};
use crate::formats::energyplus::panes;
use crate::geometry::Geometry;
use crate::materials::select::MaterialTable;
use heliotile_core::error::Result;
use heliotile_core::site::bands::BandOptics;
use heliotile_core::site::material::{Class, Glass, Material};

/// Default reflectance of shades (`ShadingProperty:Reflectance`).
const SHADE_REFLECTANCE: f64 = 0.2;
/// Reflectance of clear glass at normal incidence, one pane and two: n = 1.526 (Duffie and Beckman,
/// section 5.1).
const CLEAR_GLASS: [f64; 2] = [0.08, 0.15];
/// Largest difference from clear glass at which panes get its dependence on the angle; of other
/// panes only the reflectance at normal incidence is known.
const AS_CLEAR: f64 = 0.03;

const LAYERS: [&str; 10] = [
    "outside_layer",
    "layer_2",
    "layer_3",
    "layer_4",
    "layer_5",
    "layer_6",
    "layer_7",
    "layer_8",
    "layer_9",
    "layer_10",
];

pub(super) struct Materials<'m> {
    file: &'m Path,
    constructions: HashMap<String, &'m Object>,
    layers: HashMap<String, &'m Object>,
    /// `ShadingProperty:Reflectance` objects by the name of their shade.
    reflectances: HashMap<String, &'m Object>,
    schedules: HashMap<String, &'m Object>,
    stated: Stated,
    /// Material numbers of the constructions met so far; `true` for floors on the ground.
    known: HashMap<(String, bool), u32>,
}

impl<'m> Materials<'m> {
    pub(super) fn new(model: &'m Model, file: &'m Path) -> Self {
        let reflectances = model.of("ShadingProperty:Reflectance");
        Materials {
            file,
            constructions: model.by_name(&[
                "Construction",
                "Construction:CfactorUndergroundWall",
                "Construction:FfactorGroundFloor",
            ]),
            layers: model.by_name(&[
                "Material",
                "Material:NoMass",
                "Material:AirGap",
                "Material:InfraredTransparent",
                "Material:RoofVegetation",
                "WindowMaterial:Glazing",
                "WindowMaterial:Glazing:RefractionExtinctionMethod",
                "WindowMaterial:GlazingGroup:Thermochromic",
                "WindowMaterial:SimpleGlazingSystem",
            ]),
            reflectances: reflectances.map(|object| (same(object.text("shading_surface_name")), object)).collect(),
            schedules: model.by_name(&["Schedule:Constant"]),
            stated: Stated::default(),
            known: HashMap::new(),
        }
    }

    pub(super) fn into_stated(self) -> MaterialTable {
        self.stated.0
    }

    /// Returns the material of a wall or window. A construction that is not in the file gives a
    /// name without a description.
    pub(super) fn of_construction(
        &mut self,
        surface: &Object,
        on_ground: bool,
        geometry: &mut Geometry,
        notes: &mut Notes,
    ) -> Result<u32> {
        let name = surface.text("construction_name");
        let key = (same(name), on_ground);
        if let Some(&id) = self.known.get(&key) {
            return Ok(id);
        }
        let class = if on_ground { Class::Ground } else { Class::Obstruction };
        let id = match self.constructions.get(&key.0).copied() {
            Some(construction) => {
                let material = self.construction(construction, class, notes)?;
                self.stated.add(material, geometry)
            }
            None => {
                notes.add("constructions are not in the file; their reflectance is assumed", name);
                geometry.materials.id(if name.is_empty() { "default" } else { name })
            }
        };
        self.known.insert(key, id);
        Ok(id)
    }

    fn construction(&self, construction: &Object, class: Class, notes: &mut Notes) -> Result<Material> {
        let layers: Vec<&Object> =
            LAYERS.iter().filter_map(|key| self.layers.get(&same(construction.text(key))).copied()).collect();
        let matt = |diffuse| Material::matt(&construction.name, diffuse, class);
        if let Some(glass) = self.glass(&layers)? {
            return Ok(Material { glass: Some(glass), ..matt(0.0) });
        }
        let outside = construction.text("outside_layer");
        let layer = self.layers.get(&same(outside));
        let mut bands = BandOptics::default();
        let diffuse = match layer.map(|layer| (layer, layer.layout.class)) {
            Some((layer, "Material" | "Material:NoMass")) => {
                let diffuse = 1.0 - share(layer, self.file, "solar_absorptance", ABSORPTANCE, notes)?;
                let seen = stated_share(layer, self.file, "visible_absorptance", notes)?.map(|absorbed| 1.0 - absorbed);
                bands.diffuse = optics::visible(seen, diffuse);
                diffuse
            }
            Some((layer, "Material:RoofVegetation")) => {
                share(layer, self.file, "leaf_reflectivity", LEAF_REFLECTANCE, notes)?
            }
            // Underground constructions have no layers, and receive no light.
            None if construction.layout.class != "Construction" => 1.0 - ABSORPTANCE,
            _ => {
                notes.add(
                    "constructions have an outside layer without solar absorptance; the default of 0.7 is taken",
                    &construction.name,
                );
                1.0 - ABSORPTANCE
            }
        };
        Ok(Material { bands, ..matt(diffuse) })
    }

    /// Returns the glass of the panes among the layers; a glazing system has the panes that its
    /// heat loss suggests.
    fn glass(&self, layers: &[&Object]) -> Result<Option<Glass>> {
        let mut panes = 0;
        for layer in layers {
            panes += match layer.layout.class {
                "WindowMaterial:SimpleGlazingSystem" => panes_of_system(layer.number_or(self.file, "u_factor", 0.0)?),
                class if class.starts_with("WindowMaterial:") => 1,
                _ => 0,
            };
        }
        Ok(glass_of_panes(panes))
    }

    /// Returns the material of a shading surface.
    pub(super) fn of_shade(&mut self, shade: &Object, geometry: &mut Geometry, notes: &mut Notes) -> Result<u32> {
        let transmittance = self.transmittance(shade, notes)?;
        if transmittance > 0.0 {
            let name = format!("shading transmittance {transmittance}");
            let matt = Material::matt(name, 0.0, Class::Obstruction);
            return Ok(self.stated.add(Material { transmittance: Some(transmittance), ..matt }, geometry));
        }
        let Some(said) = self.reflectances.get(&same(&shade.name)).copied() else {
            return Ok(self.stated.add(Material::matt("shading", SHADE_REFLECTANCE, Class::Obstruction), geometry));
        };
        let key = "diffuse_solar_reflectance_of_unglazed_part_of_shading_surface";
        let diffuse = share(said, self.file, key, SHADE_REFLECTANCE, notes)?;
        let glazed = share(said, self.file, "fraction_of_shading_surface_that_is_glazed", 0.0, notes)?;
        let seen = "diffuse_visible_reflectance_of_unglazed_part_of_shading_surface";
        let seen = stated_share(said, self.file, seen, notes)?.map(|seen| (1.0 - glazed) * seen);
        let unglazed = optics::visible(seen, (1.0 - glazed) * diffuse);
        let bands = BandOptics { diffuse: unglazed, ..BandOptics::default() };
        if glazed == 0.0 {
            let name = if diffuse == SHADE_REFLECTANCE { "shading".to_owned() } else { format!("shading {diffuse}") };
            return Ok(self
                .stated
                .add(Material { bands, ..Material::matt(name, diffuse, Class::Obstruction) }, geometry));
        }
        let (glass, front) = self.glazing(said, notes)?;
        let name = format!("shading {diffuse} glazed {glazed}");
        let matt = Material { bands, ..Material::matt(name, (1.0 - glazed) * diffuse, Class::Obstruction) };
        let [one, two] = CLEAR_GLASS;
        let clear = if glass == Glass::Single { one } else { two };
        let front = front.unwrap_or(clear);
        if glazed == 1.0 && (front - clear).abs() <= AS_CLEAR {
            return Ok(self.stated.add(Material { glass: Some(glass), ..matt }, geometry));
        }
        notes.add(
            "shades are glazed; their glass counts as a mirror with the same reflectance at any angle",
            &shade.name,
        );
        Ok(self.stated.add(Material { specular: glazed * front, ..matt }, geometry))
    }

    /// Returns the glass of a glazed shade, one pane if its construction is not known, and its
    /// reflectance at normal incidence, if stated.
    fn glazing(&self, said: &Object, notes: &mut Notes) -> Result<(Glass, Option<f64>)> {
        let construction = self.constructions.get(&same(said.text("glazing_construction_name")));
        let names = construction.iter().flat_map(|construction| LAYERS.map(|key| same(construction.text(key))));
        let layers: Vec<&Object> = names.filter_map(|name| self.layers.get(&name).copied()).collect();
        let glass = self.glass(&layers)?.unwrap_or(Glass::Single);
        Ok((glass, panes::front_reflectance(&layers, self.file, notes)?))
    }

    /// Returns the constant share of light that a shade transmits.
    fn transmittance(&self, shade: &Object, notes: &mut Notes) -> Result<f64> {
        let name = shade.text("transmittance_schedule_name");
        if name.is_empty() {
            return Ok(0.0);
        }
        match self.schedules.get(&same(name)) {
            Some(schedule) => share(schedule, self.file, "hourly_value", 0.0, notes),
            None => {
                notes
                    .add("shades transmit light by a schedule that is not constant; they count as opaque", &shade.name);
                Ok(0.0)
            }
        }
    }
}
