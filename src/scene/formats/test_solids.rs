//! Solids for tests of readers. In: nothing. Out: a cube of 1 m, and the area and volume of a
//! geometry.

use glam::DVec3;

use crate::geometry::Geometry;
use crate::polygon::triangulate;

/// Returns corners and 12 triangles of the cube from 0 to 1: outsides counter-clockwise, z up.
pub(super) fn cube() -> ([DVec3; 8], [[u32; 3]; 12]) {
    let vertices = std::array::from_fn(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64));
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = std::array::from_fn(|i| {
        let [a, b, c, d]: [u32; 4] = sides[i / 2];
        if i % 2 == 0 { [a, b, c] } else { [a, c, d] }
    });
    (vertices, triangles)
}

/// Returns the area and, by the divergence theorem, the volume of a closed surface; the volume is
/// negative if the surface is inside out.
pub(super) fn area_and_volume(geometry: &Geometry) -> (f64, f64) {
    let triangles = triangulate(geometry).expect("within limits").triangles;
    triangles.iter().fold((0.0, 0.0), |(area, volume), triangle| {
        let [a, b, c] = triangle.corners.map(|corner| geometry.vertices[corner as usize]);
        let normal = (b - a).cross(c - a);
        (area + 0.5 * normal.length(), volume + a.dot(normal) / 6.0)
    })
}
