//! Materials of the ground. In: codes of land cover as UMEP has them. Out: names of materials and
//! their reflectances.

use crate::geometry::Geometry;
use crate::materials::assumed::assumed;
use crate::surface_city::layers::NO_CLASS;
use crate::terrain::surface::NAME;

/// Code of buildings.
pub(super) const BUILDINGS: u16 = 2;

/// Codes of UMEP's land cover (Lindberg et al. 2018, Environmental Modelling and Software 99, "UMEP
/// Land Cover Reclassifier"), each with its material, whose name decides its reflectance. Ground
/// below trees (3 evergreen, 4 deciduous) counts as grass, and ground of buildings that do not
/// stand as paved.
const CLASSES: [(u16, &str); 7] =
    [(1, "paved"), (BUILDINGS, "paved"), (3, "grass"), (4, "grass"), (5, "grass"), (6, "bare_soil"), (7, "water")];

/// Returns the material of ground of a code; `terrain` without a code.
pub(super) fn material_of(code: u16) -> String {
    match CLASSES.iter().find(|(known, ..)| *known == code) {
        Some((_, name)) => (*name).to_owned(),
        None if code == NO_CLASS => NAME.to_owned(),
        None => format!("landcover_{code}"),
    }
}

/// Returns the first code with the material of `code`, or `code` itself if it is unknown.
pub(super) fn joined(code: u16) -> u16 {
    let name = |code: u16| CLASSES.iter().find(|(known, ..)| *known == code).map(|(_, name)| name);
    CLASSES
        .iter()
        .map(|(known, ..)| *known)
        .find(|known| name(code).is_some() && name(*known) == name(code))
        .unwrap_or(code)
}

/// States the reflectances of the materials of known codes.
pub(super) fn state(geometry: &mut Geometry) {
    for (_, name) in CLASSES {
        geometry.stated.insert(name.to_owned(), assumed(name));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::materials::select::class_of_name;
    use heliotile_core::site::material::Class;

    /// The materials of known codes and that of an unknown one are of class ground by their names
    /// alone, so that terrain of them is one surface.
    #[test]
    fn names_are_ground() {
        for code in [1, 2, 3, 4, 5, 6, 7, 12, NO_CLASS] {
            assert_eq!(class_of_name(&material_of(code)), Class::Ground, "{code}");
        }
        assert_eq!([joined(2), joined(4), joined(7), joined(12), joined(NO_CLASS)], [1, 3, 7, 12, NO_CLASS]);
    }
}
