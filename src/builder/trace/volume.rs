//! Volumes of leaves: closed hulls inside which leaves dim light along its way. In: the triangles
//! of a scene, the hits of a ray. Out: the parts of the ray that lie in volumes.
//!
//! Hulls of one material that overlap count once. Hulls of several materials count each, as if
//! their leaves stood among each other.

use std::collections::{BTreeMap, HashMap, HashSet};

use crate::trace::kernel::ray::{Hit, Ray};
use glam::DVec3;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::hemisphere::{mix, r2, unit};
use heliotile_core::site::cells::{CellKey, GRID_SHIFT_M, size_of};
use heliotile_core::site::material::{LEAF_AREA_DENSITY, LEAF_PROJECTION, Material};
use heliotile_scene::Scene;
use heliotile_scene::mesh::Mesh;

use crate::trace::kernel::rays::Tracer;
use crate::trace::surface::SurfacePoint;

/// Share of the distance below which two hits of touching triangles are one. It covers the rounding
/// of distances at grazing incidence.
pub(crate) const ONE_PLACE: f32 = 1e-4;

/// Volumes of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Volumes {
    /// `[material]`: light stopped along a metre where it begins, 1/m; `None` if it is no volume.
    stopped: Vec<Option<f64>>,
    /// Triangles of hulls whose normals point inwards.
    inwards: HashSet<u32>,
    /// Lowest and highest point of all hulls, metres, relative to the scene's origin.
    heights: (f64, f64),
}

/// Part of a ray in the volumes of one material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// Row of the materials table.
    pub material: u16,
    /// Distances from the start of the ray, metres.
    pub from_m: f64,
    pub to_m: f64,
}

/// Point drawn on a ray in a volume.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draw {
    /// Distance from the start of the ray, metres.
    pub distance_m: f64,
    /// Optical depth for which the point stands: that of a metre over the density of its
    /// probability, 1/m.
    pub weight: f64,
}

/// Light that leaves of the usual density, 1 m2/m3, stop along a metre where it begins, 1/m. All
/// choices among leaves follow it, so that builds with other densities choose alike.
pub(crate) const USUALLY_STOPPED: f64 = LEAF_PROJECTION * LEAF_AREA_DENSITY;

impl Volumes {
    /// Finds the volumes of a scene, and the hulls that are wound inwards.
    pub fn new(scene: &Scene) -> Self {
        let (mesh, materials) = (&scene.mesh, &scene.materials);
        let stopped = |material: &Material| material.transmittance.filter(|_| material.volume).map(|left| -left.ln());
        let mut volumes = Volumes { stopped: materials.iter().map(stopped).collect(), ..Volumes::default() };
        let triangles: Vec<u32> = (0..mesh.triangles.len() as u32).filter(|&id| volumes.bounds(mesh, id)).collect();
        let corners = triangles.iter().flat_map(|&id| mesh.triangle_points(id as usize));
        volumes.heights =
            corners.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.z), high.max(p.z)));
        // Six times the volume below a triangle, by piece of the hull.
        let mut pieces: BTreeMap<u32, (f64, Vec<u32>)> = BTreeMap::new();
        for (id, piece) in triangles.iter().zip(pieces_of(mesh, &triangles)) {
            let [a, b, c] = mesh.triangle_points(*id as usize);
            let (sum, members) = pieces.entry(piece).or_default();
            *sum += a.dot(b.cross(c));
            members.push(*id);
        }
        volumes.inwards = pieces.into_values().filter(|piece| piece.0 < 0.0).flat_map(|piece| piece.1).collect();
        volumes
    }

    /// Returns an error if a hull of a scene is open: it has no inside.
    pub fn check(scene: &Scene) -> Result<()> {
        let mesh = &scene.mesh;
        // `[edge]`: how often triangles run along it from its lower to its higher vertex, less the
        // other way.
        let mut edges: HashMap<(u16, u32, u32), i32> = HashMap::new();
        for (triangle, &material) in mesh.triangles.iter().zip(&mesh.triangle_material) {
            if scene.materials.get(usize::from(material)).is_some_and(|material| material.volume) {
                for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (triangle[i], triangle[j])) {
                    let step = if from < to { 1 } else { -1 };
                    *edges.entry((material, from.min(to), from.max(to))).or_default() += step;
                }
            }
        }
        let Some((&(material, from, _), _)) = edges.iter().filter(|edge| *edge.1 != 0).min_by_key(|edge| edge.0) else {
            return Ok(());
        };
        let (name, at) = (&scene.materials[usize::from(material)].name, mesh.vertices[from as usize] + mesh.origin);
        let what = format!(
            "the hull of leaves `{name}` is open at {:.2}, {:.2}, {:.2}: a volume needs a closed hull",
            at.x, at.y, at.z
        );
        let hint =
            "close the hull, or give the material a `transmittance` of its faces in place of a `leaf_area_density`";
        Err(Error::argument("scene", what, hint).because(Problem::Lacks("closed hull")))
    }

    /// Returns the light that a material stops along a metre where it begins, 1/m; `None` if it is
    /// no volume.
    pub fn stopped(&self, material: u16) -> Option<f64> {
        self.stopped.get(usize::from(material)).copied().flatten()
    }

    /// Returns true if a triangle bounds a volume.
    pub fn bounds(&self, mesh: &Mesh, triangle: u32) -> bool {
        self.stopped(mesh.triangle_material[triangle as usize]).is_some()
    }

    /// Returns 1 if light in a direction enters a hull by a triangle, -1 if it leaves one.
    fn step(&self, mesh: &Mesh, triangle: u32, direction: DVec3) -> i32 {
        let leaves = mesh.normal(triangle as usize).dot(direction) > 0.0;
        if leaves != self.inwards.contains(&triangle) { -1 } else { 1 }
    }

    /// Returns the parts of a ray up to `reach_m` in volumes, ascending by material and distance.
    /// `hits` are all hits of the ray with hulls, nearest first.
    pub fn parts(&self, mesh: &Mesh, ray: &Ray, hits: &[Hit], reach_m: f32) -> Vec<Part> {
        let direction = DVec3::from(ray.direction.map(f64::from));
        let mut of_material: BTreeMap<u16, Vec<(Hit, i32)>> = BTreeMap::new();
        for hit in hits {
            let step = self.step(mesh, hit.triangle, direction);
            let crossings = of_material.entry(mesh.triangle_material[hit.triangle as usize]).or_default();
            // A ray through an edge meets two triangles at one place.
            let mut near = crossings.iter().rev().take_while(|before| hit.t - before.0.t <= ONE_PLACE * hit.t);
            let same = |before: &(Hit, i32)| before.1 == step && touch(mesh, before.0.triangle, hit.triangle);
            if !near.any(same) {
                crossings.push((*hit, step));
            }
        }
        let mut parts = Vec::new();
        for (material, crossings) in of_material {
            // Hulls that the ray leaves without having entered them hold its start.
            let mut depth = (-crossings.iter().map(|crossing| crossing.1).sum::<i32>()).max(0);
            let mut from_m = (depth > 0).then_some(0.0);
            for (hit, step) in crossings {
                let t = f64::from(hit.t.min(reach_m));
                depth = (depth + step).max(0);
                match (from_m, depth) {
                    (None, 1..) => from_m = Some(t),
                    (Some(from), 0) => {
                        parts.push(Part { material, from_m: from, to_m: t });
                        from_m = None;
                    }
                    _ => (),
                }
            }
        }
        parts.retain(|part| part.to_m > part.from_m);
        parts
    }

    /// Draws a point in some parts of a ray in the volumes of one material: half of the points
    /// evenly, for thin leaves, half as light comes straight from leaves of the usual density.
    /// `draw` is from 0 to 1. `None` if there are no leaves.
    pub fn draw(&self, parts: &[Part], draw: f64) -> Option<Draw> {
        let stopped = self.stopped(parts.first()?.material)?;
        let length: f64 = parts.iter().map(|part| part.to_m - part.from_m).sum();
        let all = 1.0 - (-USUALLY_STOPPED * length).exp();
        let mut inside = match draw < 0.5 {
            true => -(1.0 - 2.0 * draw * all).ln() / USUALLY_STOPPED,
            false => (2.0 * draw - 1.0) * length,
        };
        let density = USUALLY_STOPPED * (-USUALLY_STOPPED * inside).exp() / all + 1.0 / length;
        let weight = 2.0 * stopped / density;
        if weight.is_nan() || weight <= 0.0 {
            return None;
        }
        for part in parts {
            let here = part.to_m - part.from_m;
            if inside <= here {
                return Some(Draw { distance_m: part.from_m + inside, weight });
            }
            inside -= here;
        }
        parts.last().map(|part| Draw { distance_m: part.to_m, weight })
    }

    /// Returns at most `wanted` points of a volume in the voxel of a cell, spread evenly over it.
    /// `tracer` holds the hulls. Empty only if the voxel holds next to nothing of the volume.
    pub fn sample(&self, key: CellKey, wanted: usize, mesh: &Mesh, tracer: &Tracer) -> Vec<SurfacePoint> {
        let grid = tracer.grid();
        let (corner, size) = (key.corner(grid.origin), size_of(key.level));
        let to_scene = corner - grid.origin;
        let low = -GRID_SHIFT_M;
        let high = low + size;
        let column = [
            DVec3::new(low.x, low.y, self.heights.0 - to_scene.z),
            DVec3::new(high.x, high.y, self.heights.1 - to_scene.z),
        ];
        let hulls = tracer.triangles_near(to_scene + column[0], to_scene + column[1], |tag| tag.is_of(key.material));
        let seed = key.seed();
        let start = glam::DVec2::new(unit(mix(seed, 101)), unit(mix(seed, 102)));
        let mut points = Vec::with_capacity(wanted);
        for line in 0..LINES {
            let at = glam::DVec2::new(low.x, low.y) + size * r2(f64::from(line), start);
            let mut crossings: Vec<(f64, i32)> = Vec::new();
            for &id in &hulls {
                let corners = mesh.triangle_points(id as usize).map(|p| p - to_scene);
                let Some(weights) = super::surface::barycentric(corners.map(|p| p.truncate()), at) else { continue };
                let z: f64 = corners.iter().zip(weights).map(|(corner, weight)| corner.z * weight).sum();
                crossings.push((z, self.step(mesh, id, DVec3::Z)));
            }
            // Upwards, a hull is entered before it is left.
            crossings.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
            let (mut depth, mut parts, mut from) = (0, Vec::new(), 0.0);
            for (z, step) in crossings {
                if depth == 0 && step > 0 {
                    from = z;
                }
                depth = (depth + step).max(0);
                if depth == 0 && step < 0 {
                    parts.push((f64::max(from, low.z), z.min(high.z)));
                }
            }
            parts.retain(|(from, to)| to > from);
            let length: f64 = parts.iter().map(|(from, to)| to - from).sum();
            // A column counts by its length: a point is kept if it falls into the volume.
            let mut inside = unit(mix(seed ^ 0x636f_6c75, u64::from(line))) * size;
            if inside >= length {
                continue;
            }
            for (from, to) in parts {
                if inside < to - from {
                    let position = DVec3::new(at.x, at.y, from + inside);
                    points.push(SurfacePoint { position: position + corner, normal: DVec3::Z });
                    break;
                }
                inside -= to - from;
            }
            if points.len() == wanted {
                break;
            }
        }
        points
    }
}

/// Number of columns tried for points of a volume in a voxel: a volume that fills a thousandth of
/// it is found.
const LINES: u32 = 1024;

/// Returns true if two triangles have a common corner.
pub(crate) fn touch(mesh: &Mesh, a: u32, b: u32) -> bool {
    let corners = mesh.triangles[b as usize];
    mesh.triangles[a as usize].iter().any(|corner| corners.contains(corner))
}

/// Returns for each of some triangles the lowest vertex of its piece: triangles that hang together
/// by corners.
fn pieces_of(mesh: &Mesh, triangles: &[u32]) -> Vec<u32> {
    let mut parent: HashMap<u32, u32> = HashMap::new();
    fn root(parent: &mut HashMap<u32, u32>, mut vertex: u32) -> u32 {
        loop {
            let above = *parent.entry(vertex).or_insert(vertex);
            if above == vertex {
                return vertex;
            }
            let next = *parent.entry(above).or_insert(above);
            parent.insert(vertex, next);
            vertex = next;
        }
    }
    for &id in triangles {
        let [a, b, c] = mesh.triangles[id as usize];
        for other in [b, c] {
            let (x, y) = (root(&mut parent, a), root(&mut parent, other));
            parent.insert(x.max(y), x.min(y));
        }
    }
    triangles.iter().map(|&id| root(&mut parent, mesh.triangles[id as usize][0])).collect()
}
