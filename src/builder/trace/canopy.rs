//! Canopies: leaves and screens, which stop no ray and are counted instead. In: rays and how far they go. Out: how often each
//! passes each material of that kind.
//!
//! Triangles that touch and are met at one distance are one leaf: a ray through an edge of two triangles, or through the two faces
//! of a leaf drawn from both sides, crosses once. Where faces meet without a corner in common, a ray through that very line may
//! count twice.

use crate::trace::kernel::rays::{Hit, Ray, Tracer};
use crate::trace::probe::{Directions, ProbeTrace};
use crate::trace::receiver::Viewpoint;
use crate::trace::surroundings::SeenCell;
use heliotile_core::hemisphere::{bit, jitter, mix, texel_direction};
use heliotile_core::site::cells::CellKey;
use heliotile_core::site::crossing::Crossing;
use heliotile_scene::Scene;
use heliotile_scene::mesh::Mesh;

/// Share of the distance below which two hits of touching triangles are one: the rounding of distances at grazing incidence.
const ONE_PLACE: f32 = 1e-4;

/// A ray of a list, and where it ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Path {
    /// Place in the list.
    pub place: u32,
    /// Where it starts and its direction.
    pub ray: Ray,
    /// What lies at this distance or beyond is not crossed; infinite towards the sky.
    pub reach_m: f32,
}

/// The leaves and screens of a scene.
pub struct Canopies<'a> {
    mesh: &'a Mesh,
    tracer: Tracer,
}

impl<'a> Canopies<'a> {
    /// A tracer of what stops rays, and the canopies if there are some.
    pub fn split(scene: &'a Scene) -> (Tracer, Option<Self>) {
        let mesh = &scene.mesh;
        let lets_through = |&id: &u32| {
            let material = usize::from(mesh.triangle_material[id as usize]);
            scene.materials.get(material).is_some_and(|material| material.transmittance.is_some())
        };
        let (leaves, opaque): (Vec<u32>, Vec<u32>) = (0..mesh.triangles.len() as u32).partition(lets_through);
        let canopies = (!leaves.is_empty()).then(|| Canopies { mesh, tracer: Tracer::of(mesh, &leaves) });
        (Tracer::of(mesh, &opaque), canopies)
    }

    /// What some rays cross, by place and material.
    pub(crate) fn crossings(&self, paths: &[Path]) -> Vec<Crossing> {
        let rays: Vec<Ray> = paths.iter().map(|path| path.ray).collect();
        // Most rays meet no leaf at all, and packets find that out fast.
        let met = self.tracer.occluded_many(&rays);
        let mut found: Vec<Crossing> = paths.iter().zip(met).filter(|p| p.1).flat_map(|p| self.along(p.0)).collect();
        found.sort_unstable();
        found
    }

    /// What one ray crosses.
    fn along(&self, path: &Path) -> Vec<Crossing> {
        let hits: Vec<Hit> = self.tracer.crossed(path.ray).into_iter().take_while(|hit| hit.t < path.reach_m).collect();
        let mut counts: Vec<Crossing> = Vec::new();
        for (i, hit) in hits.iter().enumerate() {
            let near = hits[..i].iter().rev().take_while(|before| hit.t - before.t <= ONE_PLACE * hit.t);
            if near.into_iter().any(|before| self.one_leaf(before.triangle, hit.triangle)) {
                continue;
            }
            let material = self.mesh.triangle_material[hit.triangle as usize];
            match counts.iter_mut().find(|known| known.material == material) {
                Some(known) => known.count = known.count.saturating_add(1),
                None => counts.push(Crossing { ray: path.place, material, count: 1 }),
            }
        }
        counts
    }

    /// Whether two triangles are of one material and have a corner in common.
    fn one_leaf(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a as usize, b as usize];
        let corners = self.mesh.triangles[b];
        self.mesh.triangle_material[a] == self.mesh.triangle_material[b]
            && self.mesh.triangles[a].iter().any(|corner| corners.contains(corner))
    }
}

impl Viewpoint {
    /// A jittered ray through each of some texels of an n x n world-frame texture; of those whose ray goes behind the surface, one
    /// along it.
    pub(crate) fn sky_paths(&self, n: usize, texels: impl Iterator<Item = usize>, tracer: &Tracer) -> Vec<Path> {
        let (origin, seed) = (self.origin(tracer), mix(self.seed(), 0x6c65_6166));
        let path = |texel: usize| {
            let d = texel_direction(texel % n, texel / n, n, jitter(seed, texel as u64));
            let behind = self.normal.dot(d);
            let d = if behind > 0.0 { d } else { d - self.normal * (behind - 1e-4) };
            let ray = Ray { origin, direction: d.as_vec3().to_array() };
            Path { place: texel as u32, ray, reach_m: f32::INFINITY }
        };
        texels.map(path).collect()
    }

    /// The rays of an n x n hit texture that meet a surface, as far as they go.
    pub(crate) fn hit_paths(&self, n: usize, distances_m: &[f32], tracer: &Tracer) -> Vec<Path> {
        let (origin, direction) = (self.origin(tracer), self.hit_directions(n));
        let met = distances_m.iter().enumerate().filter(|(_, distance)| distance.is_finite());
        let path = |(texel, &reach_m): (usize, &f32)| {
            let ray = Ray { origin, direction: direction(texel).as_vec3().to_array() };
            Path { place: texel as u32, ray, reach_m }
        };
        met.map(path).collect()
    }
}

/// What the rays of a cell cross.
#[derive(Clone, Debug, Default)]
pub(crate) struct CellCrossings {
    /// By texel of the sky, where it is seen.
    pub sky: Vec<Crossing>,
    /// By ray to what else is seen; rays are numbered in ascending order of what they meet, as tables of cells hold them.
    pub seen: Vec<Crossing>,
    /// Rays cast.
    pub rays: u64,
}

impl CellCrossings {
    /// Of a cell that is traced; nothing without canopies.
    pub fn of(
        canopies: Option<&Canopies>,
        key: CellKey,
        probe: &ProbeTrace,
        texture: &Directions,
        seen: &[SeenCell],
    ) -> Self {
        let Some(canopies) = canopies.filter(|_| !probe.points.is_empty()) else { return CellCrossings::default() };
        let directions = texture.of(key);
        let sky = |texel: usize| {
            let origin = probe.origins[usize::from(probe.owner[texel])];
            let ray = Ray { origin, direction: directions[texel].as_vec3().to_array() };
            Path { place: texel as u32, ray, reach_m: f32::INFINITY }
        };
        let open = |&texel: &usize| bit(&probe.bits, texel);
        let sky: Vec<Path> = texture.texels().filter(open).map(sky).collect();
        let mut order: Vec<&SeenCell> = seen.iter().collect();
        order.sort_by_key(|seen| (!seen.up, seen.cell.is_none(), seen.cell));
        let path = |(seen, place): (&SeenCell, u32)| seen.path.map(|(ray, reach_m)| Path { place, ray, reach_m });
        let seen: Vec<Path> = order.into_iter().zip(0..).filter_map(path).collect();
        CellCrossings {
            rays: (sky.len() + seen.len()) as u64,
            sky: canopies.crossings(&sky),
            seen: canopies.crossings(&seen),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use heliotile_core::site::material::{Class, Material};

    /// A leaf of six triangles around a corner, drawn from both sides, and a quad of two above it: rays through the corner, through an
    /// edge, through a diagonal and through the middle of triangles cross 2 leaves each, 1 of each material; a ray that ends between
    /// them 1, and one beside them none.
    #[test]
    fn one_place_is_one_leaf() {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let mut triangles = Vec::new();
        for k in 0..6 {
            let corner = |k: i32| {
                let a = f64::from(k) * std::f64::consts::FRAC_PI_3;
                at(4.0 * a.cos(), 4.0 * a.sin(), 2.0)
            };
            let (a, b) = (corner(k), corner(k + 1));
            triangles.push(([at(0.0, 0.0, 2.0), a, b], 0));
            triangles.push(([at(0.0, 0.0, 2.0), b, a], 0));
        }
        let [a, b, c, d] = [(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)].map(|(x, y)| at(x, y, 3.0));
        triangles.extend([([a, b, c], 1), ([a, c, d], 1)]);
        let screen =
            |name: &str| Material { transmittance: Some(0.5), ..Material::matt(name, 0.0, Class::Obstruction) };
        let scene = Scene::from_triangles(&triangles, vec![screen("a"), screen("b")]).expect("a scene");
        let (opaque, canopies) = Canopies::split(&scene);
        let canopies = canopies.expect("canopies");
        let origin = scene.mesh.origin;
        let path = |(x, y, reach_m): (f64, f64, f32)| {
            let from = (at(x, y, 0.0) - origin).as_vec3().to_array();
            Path { place: 7, ray: Ray { origin: from, direction: [0.0, 0.0, 1.0] }, reach_m }
        };
        let far = f32::INFINITY;
        let count = |material, count| Crossing { ray: 7, material, count };
        for through in [(0.0, 0.0, far), (2.0, 0.0, far), (1.0, 1.0, far), (0.3, -1.1, far), (-1.7, 1.2, far)] {
            assert_eq!(canopies.crossings(&[path(through)]), [count(0, 1), count(1, 1)], "{through:?}");
            assert!(!opaque.occluded(path(through).ray));
        }
        assert_eq!(canopies.crossings(&[path((0.3, 0.3, 2.5))]), [count(0, 1)]);
        assert_eq!(canopies.crossings(&[path((9.0, 0.3, far))]), []);
    }
}
