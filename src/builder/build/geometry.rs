//! The scene's triangles in the archive. In: a mesh. Out: blocks of them.

use super::site_tracer::SiteTracer;
use crate::pack::COMPRESSION;
use heliotile_core::archive::tables::{GeometryTable, MAX_TRIANGLES};
use heliotile_core::archive::{EncodedBlock, format};
use heliotile_core::error::Result;
use heliotile_scene::mesh::Mesh;

impl SiteTracer<'_> {
    /// All triangles in the order of the mesh, which is that of their vertices from west to east; one block after the other.
    pub(super) fn scene_blocks(&self) -> impl Iterator<Item = Result<EncodedBlock>> {
        let mesh = &self.scene.mesh;
        let count = mesh.triangles.len();
        (0..count).step_by(MAX_TRIANGLES).zip(0..).map(move |(first, chunk)| {
            let some = first..count.min(first + MAX_TRIANGLES);
            table(mesh, some).encode(format::SCENE, chunk, COMPRESSION)
        })
    }
}

/// Some triangles with their vertices, which keep their order.
fn table(mesh: &Mesh, some: std::ops::Range<usize>) -> GeometryTable {
    let triangles = &mesh.triangles[some.clone()];
    let mut rows: Vec<u32> = triangles.iter().flatten().copied().collect();
    rows.sort_unstable();
    rows.dedup();
    // Every corner is among them, and there are less than 2^18.
    let place = |corner: &u32| rows.partition_point(|row| row < corner) as u32;
    GeometryTable {
        vertex: rows.iter().map(|&row| mesh.vertices[row as usize].as_vec3().to_array()).collect(),
        corner: triangles.iter().map(|corners| corners.each_ref().map(place)).collect(),
        material: mesh.triangle_material[some].to_vec(),
    }
}
