//! Objects of the triangles of a mesh. In: objects as files name them, and the object of each
//! triangle. Out: distinct objects sorted by name, and the object of each triangle.

use heliotile_core::site::scene_object::SceneObject;
use rayon::slice::ParallelSliceMut;

/// Objects of a mesh, and the object of each triangle.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshObjects {
    /// Objects in use, sorted by name; empty for a scene whose files name no objects.
    pub list: Vec<SceneObject>,
    /// Object of each triangle, `[triangle of the mesh]`: index into `list`; empty without objects.
    pub of_triangle: Vec<u32>,
}

impl MeshObjects {
    /// Builds the lists from objects that may repeat and the object of each triangle, an index into
    /// `objects`.
    pub fn new(objects: &[SceneObject], of_triangle: &[u32]) -> Self {
        let (ranks, sorted) = ranked(objects);
        let rank = |object: &u32| ranks.get(*object as usize).copied().unwrap_or_default();
        MeshObjects::of_sorted(&sorted, of_triangle.iter().map(rank).collect())
    }

    /// Builds the lists from sorted objects and the object of each triangle, an index into
    /// `sorted`. Objects without triangles are left out.
    pub(super) fn of_sorted(sorted: &[SceneObject], ranks: Vec<u32>) -> Self {
        let mut used = ranks.clone();
        used.par_sort_unstable();
        used.dedup();
        let list = used.iter().filter_map(|rank| sorted.get(*rank as usize)).cloned().collect();
        let number = |rank: u32| used.partition_point(|other| *other < rank) as u32;
        MeshObjects { list, of_triangle: ranks.into_iter().map(number).collect() }
    }
}

/// Returns the rank of each object among the objects sorted by name, and the sorted objects; of
/// equal names the first one counts.
pub(super) fn ranked(objects: &[SceneObject]) -> (Vec<u32>, Vec<SceneObject>) {
    let mut sorted = objects.to_vec();
    sorted.sort_by(|a, b| a.name.cmp(&b.name));
    sorted.dedup_by(|a, b| a.name == b.name);
    let rank = |object: &SceneObject| sorted.partition_point(|other| other.name < object.name) as u32;
    (objects.iter().map(rank).collect(), sorted)
}
