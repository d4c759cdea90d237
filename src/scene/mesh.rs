//! Mesh.

use glam::DVec3;

/// Triangles in canonical order: equal scenes are equal meshes, whatever the order of faces and vertices in the file.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Centre of the bounding box in input coordinates, subtracted from every vertex.
    pub origin: DVec3,
    /// Positions relative to `origin`, metres, finite, sorted lexicographically, no two equal.
    pub vertices: Vec<DVec3>,
    /// Corners in the winding of the file, each triple rotated so that its smallest index is first; sorted.
    pub triangles: Vec<[u32; 3]>,
    /// Index into the scene's materials, one per triangle.
    pub triangle_material: Vec<u16>,
}
