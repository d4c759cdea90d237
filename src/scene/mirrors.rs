//! Mirrors: which triangles reflect like one, and their orientations. In: a mesh and its materials.
//! Out: an orientation for every mirror.
//!
//! A mirror changes a direction by its normal only. So all parallel mirrors of one material have
//! one orientation, whether they are a hundred recessed windows or a single pane. A curved mirror
//! has many orientations.

use std::collections::HashMap;

use glam::DVec3;
use heliotile_core::site::chain::MirrorPlane;

use crate::mesh::Mesh;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::material::Material;

/// Largest angle between normals of one orientation, radians: a mirrored sun is off by at most half
/// a texel of the finest sky.
const SAME: f64 = 5e-4;

/// Most orientations of a scene: their numbers have 16 bits.
const MAX_ORIENTATIONS: usize = 1 << 16;

/// The mirrors of a scene.
#[derive(Clone, Debug, Default)]
pub struct Mirrors {
    /// Normal and material of each orientation, `[number]`; chains name orientations by number.
    pub orientations: Vec<MirrorPlane>,
    /// Number of each triangle's orientation + 1, `[triangle]`; 0 if it is no mirror. Empty if
    /// there is no mirror.
    of_triangle: Vec<u32>,
}

impl Mirrors {
    /// Finds the orientations. Their numbers depend on the geometry only, not on the order of
    /// triangles.
    pub fn find(mesh: &Mesh, materials: &[Material]) -> Result<Self> {
        let mirrors = |triangle: &usize| {
            let material = mesh.triangle_material.get(*triangle).copied().unwrap_or_default();
            materials.get(usize::from(material)).is_some_and(Material::mirrors)
        };
        let mut faces: Vec<Face> =
            (0..mesh.triangles.len()).filter(mirrors).map(|triangle| Face::new(mesh, triangle)).collect();
        if faces.is_empty() {
            return Ok(Mirrors::default());
        }
        let order = |f: &Face| (f.material, f.normal.to_array().map(f64::to_bits), f.area.to_bits(), f.triangle);
        faces.sort_unstable_by_key(order);
        let mut sums: Vec<(DVec3, DVec3)> = Vec::new();
        let mut found = Mirrors { orientations: Vec::new(), of_triangle: vec![0; mesh.triangles.len()] };
        // Candidates by material and by boxes of the normals, each box as wide as an orientation.
        let mut boxes: HashMap<(u16, [i32; 3]), Vec<usize>> = HashMap::new();
        for face in &faces {
            let place = (face.normal / SAME).floor().to_array().map(|x| x as i32);
            let near = (0..27).flat_map(|i| {
                let offset = [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1];
                let key = std::array::from_fn(|axis| {
                    place.get(axis).copied().unwrap_or(0) + offset.get(axis).copied().unwrap_or(0)
                });
                boxes.get(&(face.material, key)).into_iter().flatten().copied()
            });
            let same = |number: &usize| {
                sums.get(*number).is_some_and(|(first, _)| first.distance_squared(face.normal) <= SAME * SAME)
            };
            let number = match near.filter(same).min() {
                Some(number) => number,
                None => {
                    boxes.entry((face.material, place)).or_default().push(sums.len());
                    sums.push((face.normal, DVec3::ZERO));
                    found.orientations.push(MirrorPlane { normal: face.normal, material: face.material });
                    sums.len() - 1
                }
            };
            if let (Some((_, sum)), Some(slot)) = (sums.get_mut(number), found.of_triangle.get_mut(face.triangle)) {
                *sum += face.normal * face.area;
                *slot = number as u32 + 1;
            }
        }
        if sums.len() > MAX_ORIENTATIONS {
            return Err(Error::Limit {
                what: "the number of orientations of mirrors (make curved mirrors of fewer planes)".into(),
                value: sums.len() as u64,
                max: MAX_ORIENTATIONS as u64,
            });
        }
        for (orientation, (first, sum)) in found.orientations.iter_mut().zip(sums) {
            orientation.normal = sum.try_normalize().unwrap_or(first);
        }
        Ok(found)
    }

    /// Returns true if the scene has no mirror.
    pub fn is_empty(&self) -> bool {
        self.orientations.is_empty()
    }

    /// Returns the number of a triangle's orientation, if the triangle is a mirror.
    pub fn of_triangle(&self, triangle: u32) -> Option<u16> {
        let number = self.of_triangle.get(triangle as usize)?.checked_sub(1)?;
        u16::try_from(number).ok()
    }

    /// Returns the triangles that are mirrors, ascending.
    pub fn triangles(&self) -> impl Iterator<Item = u32> + '_ {
        (0..).zip(&self.of_triangle).filter(|(_, number)| **number > 0).map(|(triangle, _)| triangle)
    }
}

/// A triangle that is a mirror.
struct Face {
    material: u16,
    /// Unit normal, its sign made independent of the winding.
    normal: DVec3,
    area: f64,
    triangle: usize,
}

impl Face {
    fn new(mesh: &Mesh, triangle: usize) -> Self {
        let [a, b, c] = mesh.triangle_points(triangle);
        let n = mesh.normal(triangle);
        let size = n.abs();
        let largest = if size.z >= size.x && size.z >= size.y {
            n.z
        } else if size.x >= size.y {
            n.x
        } else {
            n.y
        };
        Face {
            material: mesh.triangle_material.get(triangle).copied().unwrap_or_default(),
            // + 0.0 turns -0.0 into 0.0: equal normals have equal bits.
            normal: n * largest.signum() + 0.0,
            area: 0.5 * (b - a).cross(c - a).length(),
            triangle,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use heliotile_core::site::material::{Class, Material};

    fn mirror(name: &str) -> Material {
        Material { specular: 0.8, ..Material::matt(name, 0.1, Class::Obstruction) }
    }

    /// Four panes in two parallel planes, wound either way and turned by 0.1 mrad, have 1
    /// orientation of a material. A pane turned by 2 mrad and one of another material have 2 more,
    /// and a matt wall has none. The order of triangles does not matter.
    #[test]
    fn parallel_panes_share_one_orientation() {
        let pane = |x: f64, y: f64, lean: f64| {
            [DVec3::new(x, y, 0.0), DVec3::new(x + 1.0, y, 0.0), DVec3::new(x, y + lean, 1.0)]
        };
        let mut triangles: Vec<([DVec3; 3], u16)> = vec![
            (pane(0.0, 0.0, 0.0), 0),
            (pane(2.0, 0.3, 0.0), 0),
            (pane(4.0, 0.0, 1e-4), 0),
            (
                {
                    let [a, b, c] = pane(6.0, 0.0, 0.0);
                    [a, c, b]
                },
                0,
            ),
            (pane(8.0, 0.0, 2e-3), 0),
            (pane(10.0, 0.0, 0.0), 1),
            (pane(12.0, 0.0, 0.0), 2),
        ];
        let materials = vec![mirror("a"), mirror("b"), Material::matt("wall", 0.3, Class::Obstruction)];
        let find = |triangles: &[([DVec3; 3], u16)]| {
            let scene = Scene::from_triangles(triangles, materials.clone()).expect("a scene");
            Mirrors::find(&scene.mesh, &scene.materials).expect("few")
        };
        let found = find(&triangles);
        assert_eq!((found.orientations.len(), found.triangles().count()), (3, 6));
        triangles.reverse();
        assert_eq!(find(&triangles).orientations, found.orientations);
    }
}
