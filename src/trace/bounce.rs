//! Bounce cells: coarse cells of the system that is solved for second and later bounces. In: the cells that receivers'
//! probes lie in. Out: those cells and every cell reachable from them, each with sky bits and a list of what it sees.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::probe::{lifted, pick, trace_probe};
use super::rays::{Hit, Ray, Tracer};
use crate::hemisphere::{Frame, direction_of, jitter, mix, texels_in_blocks, unit};
use crate::scene::cells::{CellKey, level_of};
use crate::scene::mesh::Mesh;

/// Sizes of the coarse system.
#[derive(Clone, Copy, Debug)]
pub struct BounceSettings {
    /// Smallest cells of the closed system, as a level.
    pub closed_level: i8,
    /// Side of the cells' sky textures.
    pub sky: usize,
    /// Side of the square of cosine-distributed hit rays: `hits * hits` rays a cell.
    pub hits: usize,
}

/// What one ray of a bounce cell met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// A cell of the closed system.
    Cell(CellKey),
    Nothing,
}

/// A coarse cell.
#[derive(Clone, Debug)]
pub struct BounceTrace {
    pub key: CellKey,
    pub normal: DVec3,
    pub bits: Vec<u8>,
    /// Per ray: whether it goes above the horizon, and what it met. Rays are cosine-distributed: equal weights.
    pub rays: Vec<(bool, Seen)>,
    pub cast: u64,
}

/// Surfaces at distance t are cut into cells of about t / 4, the footprint of one of 64 rays.
const DISTANCE_SHARE: f64 = 0.25;

/// Traces one coarse cell; the cells it sees are never finer than itself, so the system stays finite in a large scene.
pub fn trace_bounce(key: CellKey, settings: BounceSettings, mesh: &Mesh, tracer: &Tracer) -> BounceTrace {
    let probe = trace_probe(key, settings.sky, mesh, tracer);
    let seed = mix(key.seed(), 0x626f_756e);
    let count = settings.hits * settings.hits;
    let weights: Vec<f64> = probe.points.iter().map(|p| p.1).collect();
    if probe.points.is_empty() {
        let rays = vec![(true, Seen::Nothing); count];
        return BounceTrace { key, normal: probe.normal, bits: probe.bits, rays, cast: 0 };
    }
    let start = unit(mix(seed, 7));
    let (origins, rays): (Vec<DVec3>, Vec<Ray>) = texels_in_blocks(settings.hits)
        .map(|(column, row)| {
            let i = row * settings.hits + column;
            // Points are drawn systematically, in an order that has nothing to do with the directions' order.
            let turn = (i * 37 + 11) % count;
            let point = probe.points[pick(&weights, (turn as f64 + start) / count as f64)].0;
            let local = cosine_direction(column, row, settings.hits, jitter(seed, i as u64));
            let direction = Frame::of(point.normal).to_world(local).as_vec3().to_array();
            (point.position, Ray { origin: lifted(point.position, point.normal, tracer), direction })
        })
        .unzip();
    let rays = tracer
        .closest_many(&rays)
        .into_iter()
        .zip(rays.iter().zip(origins))
        .map(|(hit, (ray, origin))| {
            let direction = DVec3::from(ray.direction.map(f64::from));
            let seen = hit.map_or(Seen::Nothing, |hit| {
                let distance_level = level_of(f64::from(hit.t) * DISTANCE_SHARE);
                let level = distance_level.max(key.level).max(settings.closed_level);
                Seen::Cell(cell_of(hit, direction, level, mesh, origin).coarse(level))
            });
            (direction.z > 0.0, seen)
        })
        .collect();
    let cast = probe.rays + count as u64;
    BounceTrace { key, normal: probe.normal, bits: probe.bits, rays, cast }
}

/// The closed system: all cells reachable from `start`, sorted by key. `progress` is told how many were traced.
pub fn close(
    start: &BTreeSet<CellKey>,
    settings: BounceSettings,
    mesh: &Mesh,
    tracer: &Tracer,
    progress: &(dyn Fn(u64) + Sync),
) -> Vec<BounceTrace> {
    let mut known: BTreeSet<CellKey> = start.clone();
    let mut wave: Vec<CellKey> = start.iter().copied().collect();
    let mut cells = Vec::new();
    while !wave.is_empty() {
        let traced: Vec<BounceTrace> = wave.par_iter().map(|&key| trace_bounce(key, settings, mesh, tracer)).collect();
        progress(traced.len() as u64);
        let seen = traced.iter().flat_map(|c| &c.rays).filter_map(|r| match r.1 {
            Seen::Cell(key) => Some(key),
            Seen::Nothing => None,
        });
        let next: BTreeSet<CellKey> = seen.filter(|key| !known.contains(key)).collect();
        known.extend(&next);
        wave = next.into_iter().collect();
        cells.extend(traced);
    }
    cells.sort_unstable_by_key(|c| c.key);
    cells
}

/// Cell of a hit, on the side that the ray comes from.
pub fn cell_of(hit: Hit, direction: DVec3, level: i8, mesh: &Mesh, origin: DVec3) -> CellKey {
    let triangle = hit.triangle as usize;
    let outward = mesh.normal(triangle);
    let back = outward.dot(direction) > 0.0;
    let point = origin + direction * f64::from(hit.t);
    CellKey::new(point, outward, back, mesh.triangle_material[triangle], level)
}

/// Direction of ray (column, row) of n x n, cosine-distributed about z: Malley's method over Shirley and Chiu's disc.
fn cosine_direction(column: usize, row: usize, n: usize, inside: DVec2) -> DVec3 {
    let p = (DVec2::new(column as f64, row as f64) + inside) / n as f64;
    // The equal-solid-angle lift has z = 1 - r^2; the cosine lift of the same disc point has z = sqrt(1 - r^2).
    let d = direction_of(p);
    let r2 = (1.0 - d.z).clamp(0.0, 1.0);
    let stretch = 1.0 / (2.0 - r2).sqrt();
    DVec3::new(d.x * stretch, d.y * stretch, (1.0 - r2).sqrt())
}
