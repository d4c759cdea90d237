//! Materials of surfaces, by name. In: semantics, the object's type and the tilt of a face. Out:
//! the name of a material.

use glam::DVec3;

use crate::formats::cityjson::document::{Shape, Text};
use crate::geometry::Geometry;
use heliotile_core::site::semantics::SurfaceKind;

/// Upward part of the unit normal below which a face is a wall: 0.26 is 75 degrees from level.
/// Mansard roofs reach 70 degrees, and walls of photogrammetry lean by ten.
const STEEP: f64 = 0.26;

/// Semantics of surfaces where nothing is: the mouth of a tunnel, the border between two waters.
pub(super) const VIRTUAL: [&str; 2] = ["ClosureSurface", "WaterClosureSurface"];

/// Semantics of surfaces inside a room, where light arrives only through windows.
pub(super) const INNER: [&str; 3] = ["InteriorWallSurface", "CeilingSurface", "FloorSurface"];

/// Returns the depth of the arrays of a geometry type that bounds something; `None` for other
/// types.
pub(super) fn depth_of(kind: &str) -> Option<usize> {
    match kind {
        "MultiSurface" | "CompositeSurface" => Some(3),
        "Solid" => Some(4),
        "MultiSolid" | "CompositeSolid" => Some(5),
        _ => None,
    }
}

/// Returns the type that semantics give to a surface, without the mark of an extension.
pub(super) fn semantic<'s>(shape: &'s Shape, value: Option<u32>) -> Result<Option<&'s str>, String> {
    let Some(value) = value else { return Ok(None) };
    let surfaces = shape.semantics.as_ref().and_then(|semantics| semantics.surfaces.as_deref()).unwrap_or_default();
    match surfaces.get(value as usize) {
        Some(surface) => Ok(Some(plain(&surface.kind)).filter(|name| !name.is_empty())),
        None => Err(format!("the values of its semantics name surface {value} of {}, counted from 0", surfaces.len())),
    }
}

/// Returns the kind of a surface by its semantics, or by the name that [`by_tilt`] gave to a face
/// of a building. `None` for types that do not decide it (CityJSON 2.0.1, section 3.3).
pub(super) fn kind_of(semantics: &str) -> Option<SurfaceKind> {
    Some(match semantics {
        "RoofSurface" | "OuterFloorSurface" => SurfaceKind::Roof,
        "WallSurface" | "Door" => SurfaceKind::Wall,
        "Window" => SurfaceKind::Window,
        "GroundSurface" | "OuterCeilingSurface" => SurfaceKind::Floor,
        "WaterSurface" | "WaterGroundSurface" | "TrafficArea" | "AuxiliaryTrafficArea" | "TransportationMarking" => {
            SurfaceKind::Ground
        }
        _ => return None,
    })
}

/// Returns a name without the `+` at the beginning of extension names (CityJSON 2.0.1, section 8).
pub(super) fn plain<'t>(name: &'t Text) -> &'t str {
    name.0.strip_prefix('+').unwrap_or(&name.0)
}

/// Returns true for objects whose faces without semantics are named by their tilt.
pub(super) fn is_building(kind: &str) -> bool {
    matches!(kind, "Building" | "BuildingPart")
}

/// Returns true for a building or a part of its hull. Rooms, furniture and storeys lie within.
/// Extensions of buildings end with the word (`NoiseBuilding`).
pub(in crate::formats) fn is_hull(kind: &str) -> bool {
    let inside = ["BuildingRoom", "BuildingFurniture", "BuildingStorey", "BuildingUnit"];
    (kind.starts_with("Building") && !inside.contains(&kind)) || kind.ends_with("Building")
}

/// Name of a wall.
pub(super) const WALL: &str = "WallSurface";

/// Returns the name of a building's face by the upward part of its normal. A roof faces up, a wall
/// is steeper than 75 degrees from level, and every face that looks down counts as the floor plate
/// on the ground, including the few undersides of balconies.
pub(super) fn by_tilt(ring: impl Iterator<Item = DVec3> + Clone) -> &'static str {
    // The sum is twice the area times the mean normal (Newell), relative to the first corner
    // because map coordinates are large.
    let first = ring.clone().next().unwrap_or_default();
    let edges = ring.clone().zip(ring.skip(1));
    let normal: DVec3 = edges.map(|(a, b)| (a - first).cross(b - first)).sum();
    let up = normal.normalize_or_zero().z;
    match () {
        () if up > STEEP => "RoofSurface",
        () if up < -STEEP => "GroundSurface",
        () => WALL,
    }
}

/// Names the faces of buildings without semantics by their tilt, once they look outwards.
pub(in crate::formats) fn name_by_tilt(geometry: &mut Geometry) {
    for face in geometry.by_tilt.clone() {
        let Some(polygon) = geometry.polygon(face) else { continue };
        let outline = polygon.rings().next().unwrap_or_default();
        let corners = outline.iter().map(|&corner| geometry.vertices.get(corner as usize).copied().unwrap_or_default());
        let name = by_tilt(corners);
        let material = geometry.materials.id(name);
        geometry.name_face(face, material, kind_of(name));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faces 0 to 74 degrees from level are roofs, 76 to 104 degrees walls, from 106 degrees on
    /// floor plates, also far from the origin.
    #[test]
    fn tilt_names_roofs_walls_and_floors() {
        for (degrees, expected) in [
            (0.0, "RoofSurface"),
            (45.0, "RoofSurface"),
            (74.0, "RoofSurface"),
            (76.0, "WallSurface"),
            (90.0, "WallSurface"),
            (104.0, "WallSurface"),
            (106.0, "GroundSurface"),
            (180.0, "GroundSurface"),
        ] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let at = DVec3::new(78_000.0, 457_000.0, 3.0);
            let up_slope = DVec3::new(0.0, cos, sin);
            let ring = [at, at + DVec3::X, at + DVec3::X + up_slope, at + up_slope];
            assert_eq!(by_tilt(ring.into_iter()), expected, "{degrees}");
        }
        assert_eq!(by_tilt([DVec3::ZERO; 3].into_iter()), "WallSurface");
    }
}
