//! Differences between two scenes. In: the triangles of a traced scene, and a scene. Out: the
//! triangles that only one of them has, and the new numbers of the materials.

use std::cmp::Ordering;

use glam::DVec3;

use crate::Scene;
use crate::mesh_objects::MeshObjects;
use heliotile_core::site::grid::Grid;
use heliotile_core::site::material::Material;
use heliotile_core::site::morton::lexicographic;

/// A scene as an archive holds it.
#[derive(Clone, Debug)]
pub struct TracedScene {
    /// Frame of the triangles.
    pub grid: Grid,
    /// Corners of each triangle relative to the origin of the frame, in the canonical order of
    /// [`Mesh`](crate::mesh::Mesh).
    pub triangles: Vec<[DVec3; 3]>,
    /// Row of `materials` for each triangle.
    pub triangle_material: Vec<u16>,
    /// Materials, sorted by name.
    pub materials: Vec<Material>,
    /// Objects that the triangles are parts of.
    pub objects: MeshObjects,
}

/// Difference between a traced scene and the current one.
#[derive(Clone, Debug, Default)]
pub struct SceneChange {
    /// Triangles that no longer exist, relative to the origin of the current scene.
    pub removed: Vec<[DVec3; 3]>,
    /// Triangles that are new: indices into the current mesh.
    pub added: Vec<u32>,
    /// New number of each old material, by old number; `None` if no current material has its name.
    /// The new numbers are in the same order as the old ones.
    pub renumbered: Vec<Option<u16>>,
    /// True if a removed or an added triangle belongs to a canopy.
    pub of_canopies: bool,
}

impl SceneChange {
    /// Compares a traced scene with the current one. Returns `None` if their frames are so far
    /// apart that equal surfaces do not have equal coordinates, to the bit.
    ///
    /// A triangle counts as removed and added if its material became, or no longer is, a mirror, a
    /// canopy or a material that scatters light.
    pub fn between(before: &TracedScene, after: &Scene) -> Option<Self> {
        let (frame, shift) = (after.mesh.grid(), before.grid.origin - after.mesh.origin);
        let of_after = || (0..after.mesh.triangles.len()).map(|triangle| after.mesh.triangle_points(triangle));
        if before.grid.step != frame.step {
            return None;
        }
        if shift != DVec3::ZERO {
            let exact = |point: DVec3| frame.holds_exactly(point) && frame.holds_exactly(point - shift);
            let corners = before.triangles.iter().flatten().map(|point| *point + shift);
            if !corners.chain(of_after().flatten()).all(exact) {
                return None;
            }
        }
        let number = |name: &str| after.materials.binary_search_by(|material| material.name.as_str().cmp(name)).ok();
        let renumbered: Vec<Option<u16>> =
            before.materials.iter().map(|material| number(&material.name).map(|row| row as u16)).collect();
        let stays = |old: &Material, new: u16| {
            let new = after.materials.get(usize::from(new));
            new.is_some_and(|new| {
                let kind = |of: &Material| (of.transmittance.is_some(), of.volume, of.scatters(), of.mirrors());
                kind(old) == kind(new)
            })
        };
        let same: Vec<Option<u16>> =
            before.materials.iter().zip(&renumbered).map(|(old, new)| new.filter(|&new| stays(old, new))).collect();

        let mut change = SceneChange { renumbered, ..SceneChange::default() };
        let mut old = Vec::with_capacity(before.triangles.len());
        for (corners, material) in before.triangles.iter().zip(&before.triangle_material) {
            let corners = corners.map(|corner| corner + shift);
            match same.get(usize::from(*material)).copied().flatten() {
                Some(material) => old.push(Triangle { corners, material }),
                None => {
                    change.of_canopies |= is_canopy(&before.materials, *material);
                    change.removed.push(corners);
                }
            }
        }
        // Both lists are sorted: equal triangles meet.
        let mut old = old.into_iter().peekable();
        for ((corners, &material), number) in of_after().zip(&after.mesh.triangle_material).zip(0..) {
            let new = Triangle { corners, material };
            while let Some(gone) = old.next_if(|old| old.order(&new).is_lt()) {
                change.of_canopies |= is_canopy(&after.materials, gone.material);
                change.removed.push(gone.corners);
            }
            if old.next_if(|old| old.order(&new).is_eq()).is_none() {
                change.of_canopies |= is_canopy(&after.materials, material);
                change.added.push(number);
            }
        }
        for gone in old {
            change.of_canopies |= is_canopy(&after.materials, gone.material);
            change.removed.push(gone.corners);
        }
        Some(change)
    }

    /// Returns true if no triangle was removed or added.
    pub fn is_empty(&self) -> bool {
        self.removed.is_empty() && self.added.is_empty()
    }
}

fn is_canopy(materials: &[Material], row: u16) -> bool {
    materials.get(usize::from(row)).is_some_and(|material| material.transmittance.is_some())
}

/// A triangle with the current number of its material.
struct Triangle {
    corners: [DVec3; 3],
    material: u16,
}

impl Triangle {
    /// Compares two triangles in the canonical order.
    fn order(&self, other: &Self) -> Ordering {
        let corners = self.corners.iter().zip(&other.corners).map(|(a, b)| lexicographic(*a, *b));
        corners.fold(Ordering::Equal, Ordering::then).then(self.material.cmp(&other.material))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::site::material::Class;

    fn material(name: &str) -> Material {
        Material::matt(name, 0.3, Class::Obstruction)
    }

    fn traced(scene: &Scene) -> TracedScene {
        let mesh = &scene.mesh;
        TracedScene {
            grid: mesh.grid(),
            triangles: (0..mesh.triangles.len()).map(|triangle| mesh.triangle_points(triangle)).collect(),
            triangle_material: mesh.triangle_material.clone(),
            materials: scene.materials.clone(),
            objects: scene.objects.clone(),
        }
    }

    /// In a scene of 300 triangles, 20 go, 30 come and 10 change their material. A new
    /// material before the others moves their numbers, and a far triangle moves the origin: 30
    /// triangles are removed and 41 added. A material of the same name that becomes a mirror gives
    /// other triangles, another reflectance does not, and a change of canopies is flagged. A scene
    /// of less than 4 m has another grid step, and one of 3 km does not have equal coordinates:
    /// neither is compared.
    #[test]
    fn a_change_lists_removed_and_added_triangles() {
        let at = |i: i32| DVec3::new(f64::from(i % 20) * 9.0, f64::from(i / 20) * 7.0, f64::from(i % 7));
        let triangle = |i: i32| [at(i), at(i) + DVec3::new(3.0, 0.3, 0.1), at(i) + DVec3::new(0.2, 2.0, 1.0)];
        let old: Vec<([DVec3; 3], u16)> = (0..300).map(|i| (triangle(i), u16::from(i % 3 == 0))).collect();
        let before = Scene::from_triangles(&old, vec![material("b"), material("c")]).expect("a scene");
        let mut new: Vec<([DVec3; 3], u16)> = old[20..].to_vec();
        new.iter_mut().take(10).for_each(|(_, material)| *material = 1 - *material);
        new.extend((400..430).map(|i| (triangle(i), 2)));
        let far = |m: f64| (triangle(0).map(|p| p + DVec3::new(m, 0.0, 0.0)), 0);
        let materials = vec![material("b"), material("c"), material("a")];
        new.push(far(900.0));
        let after = Scene::from_triangles(&new, materials.clone()).expect("a scene");
        assert_ne!(before.mesh.origin, after.mesh.origin);
        let change = SceneChange::between(&traced(&before), &after).expect("one frame");
        assert_eq!((change.removed.len(), change.added.len()), (30, 41));
        assert_eq!(change.renumbered, [Some(1), Some(2)]);

        let painted = |of: Material| {
            let scene = Scene::from_triangles(&old, vec![of, material("c")]).expect("a scene");
            SceneChange::between(&traced(&before), &scene).expect("one frame")
        };
        assert!(painted(Material { diffuse: 0.9, ..material("b") }).is_empty());
        let mirror = painted(Material { diffuse: 0.1, specular: 0.8, ..material("b") });
        assert_eq!((mirror.removed.len(), mirror.added.len(), mirror.of_canopies), (200, 200, false));
        let leaves = painted(Material { diffuse: 0.0, transmittance: Some(0.4), ..material("b") });
        assert_eq!((leaves.removed.len(), leaves.added.len(), leaves.of_canopies), (200, 200, true));
        new.push(far(3000.0));
        let wide = Scene::from_triangles(&new, materials).expect("a scene");
        assert!(SceneChange::between(&traced(&before), &wide).is_none());
        let small = Scene::from_triangles(&old[..1], vec![material("b"), material("c")]).expect("a scene");
        assert!(SceneChange::between(&traced(&before), &small).is_none());
    }
}
