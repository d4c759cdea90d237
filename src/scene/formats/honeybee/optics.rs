//! In: a Radiance modifier, a construction or a schedule. Out: the material with the same
//! reflectance, or `None` if the reflectance is not stated.

use std::collections::HashMap;

use crate::formats::building::notes::Notes;
use crate::formats::building::optics::{
    ABSORPTANCE, LEAF_REFLECTANCE, glass_of_panes, panes_of_system, share, visible,
};
use crate::formats::honeybee::properties::{Construction, Layer, Modifier, Named, Schedule};
use heliotile_core::site::bands::BandOptics;
use heliotile_core::site::material::{Class, Glass, Material};

/// Default reflectance of a `ShadeConstruction` (honeybee-schema).
const SHADE_REFLECTANCE: f64 = 0.2;

fn matt(name: &str, diffuse: f64) -> Material {
    Material::matt(name, diffuse, Class::Obstruction)
}

/// Returns the plain mean of three channels, as for sunlight.
fn mean([r, g, b]: [f64; 3], name: &str, notes: &mut Notes) -> f64 {
    [r, g, b].into_iter().map(|value| share(value, name, notes)).sum::<f64>() / 3.0
}

/// Returns the material of a Radiance modifier (G. Ward, The RADIANCE 5.1 Synthetic Imaging System,
/// materials.1). The mirror image in plastic has no colour, in metal it has the colour of the
/// metal. A rough modifier is no mirror here: it reflects all its light diffusely.
pub(super) fn of_modifier(modifier: &Modifier, notes: &mut Notes) -> Option<Material> {
    let name = modifier.identifier.as_str();
    let channels = |default| {
        [modifier.r_reflectance, modifier.g_reflectance, modifier.b_reflectance].map(|value| value.unwrap_or(default))
    };
    let specularity = |notes: &mut Notes, default| share(modifier.specularity.unwrap_or(default), name, notes);
    let kind = modifier.kind.as_str();
    match kind {
        "Plastic" | "Metal" => {
            let color = mean(channels(0.0), name, notes);
            let specularity = specularity(notes, if kind == "Metal" { 0.9 } else { 0.0 });
            let specular = if kind == "Metal" { color * specularity } else { specularity };
            let diffuse = color * (1.0 - specularity);
            Some(if modifier.roughness.unwrap_or(0.0) > 0.0 {
                matt(name, (diffuse + specular).min(1.0))
            } else {
                // Rounding may lift the sum above 1 by the last bit.
                Material { specular: specular.min(1.0 - diffuse), ..matt(name, diffuse) }
            })
        }
        "Mirror" => Some(Material { specular: mean(channels(1.0), name, notes), ..matt(name, 0.0) }),
        "Glass" => Some(Material { glass: Some(Glass::Single), ..matt(name, 0.0) }),
        "Trans" => {
            notes.add("modifiers transmit light; they count as opaque with the same reflectance", name);
            let through = share(modifier.transmitted_diff.unwrap_or(0.0), name, notes);
            let color = mean(channels(0.0), name, notes);
            Some(matt(name, color * (1.0 - specularity(notes, 0.0)) * (1.0 - through)))
        }
        "BSDF" if modifier.front_diffuse_reflectance.is_some() => {
            Some(matt(name, mean(modifier.front_diffuse_reflectance.unwrap_or_default(), name, notes)))
        }
        _ => {
            notes.add("modifiers state no reflectance; the next statement for the surface is used", name);
            None
        }
    }
}

/// Layers by identifier.
pub(super) struct Layers<'l>(pub &'l HashMap<&'l str, &'l Layer>);

/// Returns the material of the outer side of a construction.
pub(super) fn of_construction(construction: &Construction, layers: &Layers, notes: &mut Notes) -> Option<Material> {
    let name = construction.identifier.as_str();
    if construction.kind == "ShadeConstruction" {
        let reflectance = share(construction.solar_reflectance.unwrap_or(SHADE_REFLECTANCE), name, notes);
        let seen = visible(construction.visible_reflectance.map(|seen| share(seen, name, notes)), reflectance);
        return Some(match construction.is_specular {
            // A specular shade that reflects no solar light is not traced as a mirror.
            Some(true) if reflectance > 0.0 => {
                let bands = BandOptics { specular: seen, ..BandOptics::default() };
                Material { specular: reflectance, bands, ..matt(name, 0.0) }
            }
            Some(true) => matt(name, 0.0),
            _ => Material { bands: BandOptics { diffuse: seen, ..BandOptics::default() }, ..matt(name, reflectance) },
        });
    }
    // A window with a shade counts as bare, and a window that changes counts in its first state,
    // under the name of the whole.
    let first = construction.constructions.as_ref().and_then(|all| all.first());
    let bare = construction.window_construction.as_deref().or(first).unwrap_or(construction);
    let named = bare.materials.iter().flatten().filter_map(|layer| find(layer, layers.0));
    let found: Vec<&Layer> = named.collect();
    let panes = found.iter().map(|layer| match layer.kind.as_str() {
        "EnergyWindowMaterialSimpleGlazSys" => panes_of_system(layer.u_factor.unwrap_or(0.0)),
        "EnergyWindowMaterialGlazing" => 1,
        _ => 0,
    });
    if let Some(glass) = glass_of_panes(panes.sum()) {
        return Some(Material { glass: Some(glass), ..matt(name, 0.0) });
    }
    let outside = bare.materials.iter().flatten().next().and_then(|layer| find(layer, layers.0));
    let mut bands = BandOptics::default();
    let diffuse = match outside.map(|layer| (layer, layer.kind.as_str())) {
        Some((layer, "EnergyMaterial" | "EnergyMaterialNoMass")) => {
            let diffuse = 1.0 - share(layer.solar_absorptance.unwrap_or(ABSORPTANCE), name, notes);
            let seen = layer.visible_absorptance.map(|absorbed| 1.0 - share(absorbed, name, notes));
            bands.diffuse = visible(seen, diffuse);
            diffuse
        }
        Some((layer, "EnergyMaterialVegetation")) => {
            share(layer.leaf_reflectivity.unwrap_or(LEAF_REFLECTANCE), name, notes)
        }
        _ => {
            notes.add("constructions have an outer layer without solar absorptance; the next statement for the surface is used", name);
            return None;
        }
    };
    Some(Material { bands, ..matt(name, diffuse) })
}

/// Returns the material of a shade with a constant transmittance; `None` if it transmits nothing or
/// the schedule is not constant.
pub(super) fn shade_transmittance(schedule: Option<&Schedule>, shade: &str, notes: &mut Notes) -> Option<Material> {
    let days = schedule.and_then(|schedule| schedule.day_schedules.as_ref()).into_iter().flatten();
    let list = schedule.and_then(|schedule| schedule.values.as_ref()).into_iter().flatten();
    let mut values = days.flat_map(|day| &day.values).chain(list).copied();
    let first = values.next();
    let Some(constant) = first.filter(|first| values.all(|value| value == *first)) else {
        notes.add("shades transmit light by a schedule that is not constant; they count as opaque", shade);
        return None;
    };
    let through = share(constant, shade, notes);
    let material = matt(&format!("shading transmittance {through}"), 0.0);
    (through > 0.0).then_some(Material { transmittance: Some(through), ..material })
}

/// Returns the item of a name, or the item itself if it stands in place.
pub(super) fn find<'n, T>(named: &'n Named<T>, all: &HashMap<&str, &'n T>) -> Option<&'n T> {
    match named {
        Named::By(name) => all.get(name.as_str()).copied(),
        Named::Itself(itself) => Some(itself),
    }
}
