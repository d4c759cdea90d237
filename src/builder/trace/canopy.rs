//! Canopies: leaves and screens, which stop no ray and are counted instead. In: rays and how far they go. Out: how often each
//! passes each material of that kind, and the leaves on its way that scatter light.
//!
//! Triangles that touch and are met at one distance are one leaf: a ray through an edge of two triangles, or through the two faces
//! of a leaf drawn from both sides, crosses once. Where faces meet without a corner in common, a ray through that very line may
//! count twice.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::trace::kernel::rays::{Hit, Ray, Tracer};
use crate::trace::probe::{Directions, ProbeTrace};
use crate::trace::receiver::Viewpoint;
use crate::trace::surroundings::{SeenCell, seen_from};
use heliotile_core::hemisphere::{bit, jitter, mix, texel_direction, unit};
use heliotile_core::layers::canopy::SeenLeaf;
use heliotile_core::light::radiosity::{SidesOf, Surround, each_ray};
use heliotile_core::site::cells::CellKey;
use heliotile_core::site::crossing::Crossing;
use heliotile_core::site::material::Material;
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
    /// `[material]`: whether its leaves scatter light.
    scatters: Vec<bool>,
    /// Whether some that are there do.
    some_scatter: bool,
}

/// A ray that meets leaves.
#[derive(Debug)]
pub(crate) struct Passage {
    /// Place of the ray in the list.
    pub place: u32,
    ray: Ray,
    /// The leaves that it crosses, nearest first: one triangle of each.
    leaves: Vec<Hit>,
}

/// A leaf that a ray crosses and that scatters light.
#[derive(Debug)]
pub(crate) struct LeafHit {
    /// Row of the materials table.
    pub material: u16,
    /// The triangle's normal.
    pub normal: DVec3,
    /// Input coordinates.
    pub point: DVec3,
    /// How far the ray goes to it.
    pub distance_m: f64,
    /// Materials that are crossed before, ascending, and how often each.
    pub before: Vec<(u16, u8)>,
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
        let scatters: Vec<bool> = scene.materials.iter().map(Material::scatters).collect();
        let scatter = |&id: &u32| scatters[usize::from(mesh.triangle_material[id as usize])];
        let some_scatter = leaves.iter().any(scatter);
        let canopies =
            (!leaves.is_empty()).then(|| Canopies { mesh, tracer: Tracer::of(mesh, &leaves), scatters, some_scatter });
        (Tracer::of(mesh, &opaque), canopies)
    }

    /// The tracer of leaves and screens alone.
    pub(crate) fn tracer(&self) -> &Tracer {
        &self.tracer
    }

    /// Whether some leaves scatter light.
    pub(crate) fn scatter(&self) -> bool {
        self.some_scatter
    }

    /// What some rays cross, by place and material.
    pub(crate) fn crossings(&self, paths: &[Path]) -> Vec<Crossing> {
        self.counted(&self.passages(paths))
    }

    /// The rays among `paths` that cross leaves, in the order of `paths`.
    pub(crate) fn passages(&self, paths: &[Path]) -> Vec<Passage> {
        let rays: Vec<Ray> = paths.iter().map(|path| path.ray).collect();
        // Most rays meet no leaf at all, and packets find that out fast.
        let met = self.tracer.occluded_many(&rays);
        let passage = |(path, _): (&Path, bool)| Passage { place: path.place, ray: path.ray, leaves: self.along(path) };
        paths.iter().zip(met).filter(|path| path.1).map(passage).collect()
    }

    /// How often rays cross each material, by place and material.
    pub(crate) fn counted(&self, passages: &[Passage]) -> Vec<Crossing> {
        let crossings = |passage: &Passage| {
            let mut counts = Vec::new();
            passage.leaves.iter().for_each(|hit| count(&mut counts, self.material(hit)));
            let ray = passage.place;
            counts.into_iter().map(move |(material, count)| Crossing { ray, material, count })
        };
        let mut found: Vec<Crossing> = passages.iter().flat_map(crossings).collect();
        found.sort_unstable();
        found
    }

    /// The leaves on the way of a ray that scatter light, nearest first.
    pub(crate) fn leaves(&self, passage: &Passage) -> Vec<LeafHit> {
        let [from, direction] = [passage.ray.origin, passage.ray.direction].map(|v| DVec3::from(v.map(f64::from)));
        let (mut before, mut found) = (Vec::new(), Vec::new());
        for hit in &passage.leaves {
            let material = self.material(hit);
            if self.scatters[usize::from(material)] {
                let point = self.mesh.grid().absolute(from) + direction * f64::from(hit.t);
                let normal = self.mesh.normal(hit.triangle as usize);
                let distance_m = f64::from(hit.t);
                found.push(LeafHit { material, normal, point, distance_m, before: before.clone() });
            }
            count(&mut before, material);
            before.sort_unstable();
        }
        found
    }

    /// The leaves that one ray crosses, one hit of each.
    fn along(&self, path: &Path) -> Vec<Hit> {
        let hits: Vec<Hit> = self.tracer.crossed(path.ray).into_iter().take_while(|hit| hit.t < path.reach_m).collect();
        let is_new = |&i: &usize| {
            let (hit, before) = (hits[i], hits[..i].iter().rev());
            let mut near = before.take_while(|before| hit.t - before.t <= ONE_PLACE * hit.t);
            !near.any(|before| self.one_leaf(before.triangle, hit.triangle))
        };
        (0..hits.len()).filter(is_new).map(|i| hits[i]).collect()
    }

    fn material(&self, hit: &Hit) -> u16 {
        self.mesh.triangle_material[hit.triangle as usize]
    }

    /// Whether two triangles are of one material and have a corner in common.
    fn one_leaf(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a as usize, b as usize];
        let corners = self.mesh.triangles[b];
        self.mesh.triangle_material[a] == self.mesh.triangle_material[b]
            && self.mesh.triangles[a].iter().any(|corner| corners.contains(corner))
    }
}

/// One more crossing of a material.
fn count(counts: &mut Vec<(u16, u8)>, material: u16) {
    match counts.iter_mut().find(|known| known.0 == material) {
        Some((_, count)) => *count = count.saturating_add(1),
        None => counts.push((material, 1)),
    }
}

/// Leaves that are seen, gathered by cell and by what is before them.
#[derive(Default)]
pub(crate) struct SeenLeaves(BTreeMap<(CellKey, Vec<(u16, u8)>), f64>);

impl SeenLeaves {
    /// One more, on a ray that stands for a share of the hemisphere.
    pub fn add(&mut self, cell: CellKey, leaf: LeafHit, share: f64) {
        *self.0.entry((cell, leaf.before)).or_default() += share;
    }

    /// All of them, or so many of them at most, drawn evenly by what they may send (systematic sampling: Madow 1949): their shares
    /// stand for the others.
    pub fn gathered(self, most: usize, seed: u64) -> Vec<SeenLeaf> {
        let weight = |before: &[(u16, u8)], share: f64| {
            let crossed: i32 = before.iter().map(|(_, count)| i32::from(*count)).sum();
            share * BEHIND_ONE.powi(crossed.min(MOST_BEHIND))
        };
        let all: f64 = self.0.iter().map(|((_, before), share)| weight(before, *share)).sum();
        let step = if self.0.len() > most { all / most as f64 } else { 0.0 };
        let mut at = unit(mix(seed, 0x6c65_6166)) * step;
        let mut drawn = |((cell, before), share): ((CellKey, Vec<(u16, u8)>), f64)| {
            let own = weight(&before, share);
            let mut share = share;
            if step > 0.0 {
                at -= own;
                let count = (-at / step).ceil().max(0.0);
                at += count * step;
                share *= count * step / own;
            }
            (share > 0.0).then_some(SeenLeaf { cell, before, share: share as f32 })
        };
        self.0.into_iter().filter_map(&mut drawn).collect()
    }
}

/// What leaves behind another one are likely to send, and how many before them count for that: others may stand for none of their light
/// where a replay has fewer leaves.
const BEHIND_ONE: f64 = 0.5;
const MOST_BEHIND: i32 = 4;

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

    /// The rays of an n x n hit texture, as far as they go; only those that meet a surface, unless all are wanted.
    pub(crate) fn hit_paths(&self, n: usize, distances_m: &[f32], all: bool, tracer: &Tracer) -> Vec<Path> {
        let (origin, direction) = (self.origin(tracer), self.hit_directions(n));
        let wanted = distances_m.iter().enumerate().filter(|(_, distance)| all || distance.is_finite());
        let path = |(texel, &reach_m): (usize, &f32)| {
            let ray = Ray { origin, direction: direction(texel).as_vec3().to_array() };
            Path { place: texel as u32, ray, reach_m }
        };
        wanted.map(path).collect()
    }
}

/// Leaves of a cell at most, to each ray to what else it sees.
const LEAVES_OF_RAY: usize = 2;

/// What the rays of a cell cross.
#[derive(Clone, Debug, Default)]
pub(crate) struct CellCrossings {
    /// By texel of the sky, where it is seen.
    pub sky: Vec<Crossing>,
    /// By ray to what else is seen; rays are numbered in ascending order of what they meet, as tables of cells hold them.
    pub seen: Vec<Crossing>,
    /// Leaves that scatter light.
    pub leaves: Vec<SeenLeaf>,
    /// Rays cast.
    pub rays: u64,
}

/// How cells see leaves.
#[derive(Clone, Copy)]
pub(crate) struct LeafView<'a> {
    pub canopies: &'a Canopies<'a>,
    /// Level of the cells at middle distance, if leaves that scatter light are looked for.
    pub closed_level: Option<i8>,
}

impl CellCrossings {
    /// Of a cell that is traced; nothing without canopies. `around`: what its rays below and above the horizon stand for.
    pub fn of(
        view: Option<LeafView>,
        key: CellKey,
        probe: &ProbeTrace,
        texture: &Directions,
        seen: &[SeenCell],
        around: impl FnOnce() -> Surround,
    ) -> Self {
        let Some(view) = view.filter(|_| !probe.points.is_empty()) else { return CellCrossings::default() };
        let (canopies, directions) = (view.canopies, texture.of(key));
        let sky = |texel: usize| {
            let ray = probe.starts.ray(usize::from(probe.owner[texel]), directions[texel]);
            Path { place: texel as u32, ray, reach_m: f32::INFINITY }
        };
        let open = |&texel: &usize| bit(&probe.bits, texel);
        let sky: Vec<Path> = texture.texels().filter(open).map(sky).collect();
        let mut order: Vec<&SeenCell> = seen.iter().collect();
        order.sort_by_key(|seen| (!seen.up, seen.cell.is_none(), seen.cell));
        let path = |(seen, place): (&&SeenCell, u32)| seen.path.map(|(ray, reach_m)| Path { place, ray, reach_m });
        let seen: Vec<Path> = order.iter().zip(0..).filter_map(path).collect();
        let rays = (sky.len() + seen.len()) as u64;
        let [to_sky, to_seen] = [canopies.passages(&sky), canopies.passages(&seen)];
        let (sky, seen) = (canopies.counted(&to_sky), canopies.counted(&to_seen));
        let mut leaves = SeenLeaves::default();
        if let Some(closed) = view.closed_level.filter(|_| !(to_sky.is_empty() && to_seen.is_empty())) {
            let mut see = |passage: &Passage, share: f64| {
                for leaf in canopies.leaves(passage) {
                    let at = |level| CellKey::leaf(leaf.point, leaf.normal, leaf.material, level);
                    leaves.add(seen_from(key, leaf.distance_m, closed, at), leaf, share);
                }
            };
            let texel = 2.0 / (texture.n * texture.n) as f64;
            for passage in &to_sky {
                let cosine = probe.normal.dot(directions[passage.place as usize]) as f32;
                see(passage, texel * f64::from(SidesOf(key).cosine(cosine)));
            }
            let each = each_ray(&order.iter().map(|seen| seen.as_hit()).collect::<Vec<u32>>(), around());
            for passage in &to_seen {
                see(passage, each[usize::from(order[passage.place as usize].up)]);
            }
        }
        CellCrossings { rays, sky, seen, leaves: leaves.gathered(LEAVES_OF_RAY * order.len(), key.seed()) }
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
