//! Assumed materials. In: a name without a description. Out: plain reflectances of its kind, for a
//! warning to list.

use std::path::Path;

use crate::materials::select::class_of_name;
use crate::text::excerpt;
use heliotile_core::site::material::{BROADLEAF_DIFFUSE, Class, Material};
use heliotile_core::text::{Message, counted, message};

/// Solar reflectance of walls: absorptance 0.7, the default of EnergyPlus' `Material` (Input Output
/// Reference, `Solar Absorptance`).
const WALL: f64 = 0.3;
/// Solar reflectance of ground, roofs and everything else. For ground it is the value that Liu and
/// Jordan (1963) introduced and EnergyPlus uses by default, for the others the default of
/// EnergyPlus' shading surfaces (`ShadingProperty:Reflectance`).
const OTHER: f64 = 0.2;
/// Solar reflectance of open water for a high sun; water is no mirror here.
const WATER: f64 = 0.07;
/// Names of land cover with their reflectances: of paved ground (dark asphalt), grass and bare soil
/// the effective albedos of SOLWEIG (Lindberg, Onomura and Grimmond 2016). Oke (1987, Boundary
/// Layer Climates, Table 1.1) has asphalt 0.05 to 0.20, grass 0.16 to 0.26, soil 0.05 (dark, wet)
/// to 0.40 (light, dry), water below a high sun 0.03 to 0.10.
const LAND: [(&str, f64); 4] = [("paved", 0.18), ("grass", 0.16), ("bare_soil", 0.25), ("water", WATER)];
/// Solar reflectance of coated and clear double glazing at normal incidence; it is no mirror here.
const WINDOW: f64 = 0.15;
/// Transmittance of each of the two walls of a tree crown's hull: 3 % in all, the default of
/// SOLWEIG (Lindberg and Grimmond 2011).
const CROWN: f64 = 0.17;

/// Mean of a colour's channels from which it is white. Many programs write white where no colour
/// was chosen, so that it says nothing of the reflectance. White paint reflects 0.8 to 0.9 of the
/// sun's light, fresh snow 0.9.
const WHITE: f64 = 0.98;

/// Returns true if a colour of this mean counts as not chosen.
pub(crate) fn is_white(mean: f64) -> bool {
    mean >= WHITE
}

/// Returns a warning about colours that say nothing of the reflectance; `names` are the materials
/// with such colours. `None` if there are none.
pub(crate) fn undescribed(file: &Path, names: &[String], why: &str) -> Option<Message> {
    let (first, file) = (excerpt(names.first()?.as_bytes()), file.display());
    Some(message!(
        "{file}: {} (first: `{first}`) {why}: the usual reflectance for the name is used; state another in a materials.toml ({{materials}})",
        counted(names.len() as u64, "material")
    ))
}

/// Reason that [`undescribed`] gives for white colours.
pub(crate) const WHITE_WORDS: &str = "of white, which programs write where no colour was chosen";

/// Returns a material with the usual reflectance for its name.
pub(crate) fn assumed(name: &str) -> Material {
    let lower = name.to_lowercase();
    let has = |words: &[&str]| words.iter().any(|word| lower.contains(word));
    let class = class_of_name(name);
    if has(&["vegetation", "tree", "canopy"]) && class == Class::Obstruction && !lower.contains("street") {
        let matt = Material::matt(name, BROADLEAF_DIFFUSE * (1.0 - CROWN), class);
        return Material { transmittance: Some(CROWN), ..matt };
    }
    if let Some((_, reflectance)) = LAND.iter().find(|(known, _)| *known == lower) {
        return Material::matt(name, *reflectance, class);
    }
    let diffuse = match () {
        () if lower.contains("water") => WATER,
        () if has(&["window", "glass", "glazing"]) => WINDOW,
        () if has(&["wall", "facade"]) => WALL,
        () => OTHER,
    };
    Material::matt(name, diffuse, class)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The 22 names that CityJSON 2.0 gives to surfaces and objects: those on which one walks,
    /// drives or swims are ground, the others are not.
    #[test]
    fn surfaces_of_cityjson_have_their_class() {
        const GROUND: &str = "GroundSurface WaterSurface WaterGroundSurface TrafficArea AuxiliaryTrafficArea TransportationMarking \
                              TINRelief WaterBody Waterway PlantCover LandUse Road Railway TransportSquare";
        const BUILT: &str =
            "RoofSurface WallSurface OuterCeilingSurface OuterFloorSurface Door Bridge CityFurniture TunnelPart";
        for (names, class) in [(GROUND, Class::Ground), (BUILT, Class::Obstruction)] {
            for name in names.split_whitespace() {
                let material = assumed(name);
                assert_eq!((material.class, material.transmittance), (class, None), "{name}");
                let usual = if name.starts_with("Water") { WATER } else { OTHER };
                assert_eq!(material.diffuse, if name == "WallSurface" { WALL } else { usual }, "{name}");
            }
        }
    }

    /// Twelve names get the reflectance of their kind, and all of them give valid materials.
    #[test]
    fn names_get_the_reflectance_of_their_kind() {
        for (name, diffuse, transmittance, class) in [
            ("RoofSurface", 0.2, None, Class::Obstruction),
            ("WallSurface", 0.3, None, Class::Obstruction),
            ("GroundSurface", 0.2, None, Class::Ground),
            ("TINRelief", 0.2, None, Class::Ground),
            ("WaterBody", 0.07, None, Class::Ground),
            ("Window", 0.15, None, Class::Obstruction),
            ("SolitaryVegetationObject", 0.425 * 0.83, Some(0.17), Class::Obstruction),
            ("street", 0.2, None, Class::Ground),
            ("default", 0.2, None, Class::Obstruction),
            ("paved", 0.18, None, Class::Ground),
            ("Grass", 0.16, None, Class::Ground),
            ("", 0.2, None, Class::Obstruction),
        ] {
            let material = assumed(name);
            assert_eq!(
                (material.diffuse, material.transmittance, material.class),
                (diffuse, transmittance, class),
                "{name}"
            );
            material.check().expect(name);
        }
    }
}
