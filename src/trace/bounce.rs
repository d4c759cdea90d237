//! Bounce cells: the coarse cells that carry second and later bounces. In: the cells that probes see. Out: those cells and every
//! cell reachable from them, each with sky bits and a list of what it sees.

use std::collections::BTreeSet;

use glam::DVec3;
use rayon::prelude::*;

use super::probe::{Directions, trace_probe};
use super::rays::Tracer;
use super::surroundings::{Seen, surroundings};
use crate::scene::cells::CellKey;
use crate::scene::mesh::Mesh;

/// Sizes of the coarse system.
#[derive(Clone, Copy, Debug)]
pub struct BounceSettings {
    /// Level of its cells at middle distance; cells nearby are finer, cells far away coarser.
    pub closed_level: i8,
    /// Hit rays of a cell.
    pub hits: usize,
}

/// A coarse cell.
#[derive(Clone, Debug)]
pub struct BounceTrace {
    pub key: CellKey,
    pub normal: DVec3,
    pub bits: Vec<u8>,
    pub seen: Vec<Seen>,
    pub cast: u64,
}

/// Traces one coarse cell; the cells it sees are never finer than itself, so the system stays finite in a large scene.
pub fn trace_bounce(
    key: CellKey,
    texture: &Directions,
    settings: BounceSettings,
    mesh: &Mesh,
    tracer: &Tracer,
) -> BounceTrace {
    let probe = trace_probe(key, texture, mesh, tracer);
    let seen = surroundings(key, &probe, texture, settings.hits, settings.closed_level, mesh, tracer);
    let cast = probe.rays + settings.hits as u64;
    BounceTrace { key, normal: probe.normal, bits: probe.bits, seen, cast }
}

/// The closed system: all cells reachable from `start`, sorted by key. `texture`: the cells' sky texture. `progress` is told how many were traced.
pub fn close(
    start: BTreeSet<CellKey>,
    texture: &Directions,
    settings: BounceSettings,
    mesh: &Mesh,
    tracer: &Tracer,
    progress: &(dyn Fn(u64) + Sync),
) -> Vec<BounceTrace> {
    let mut wave: Vec<CellKey> = start.iter().copied().collect();
    let mut known = start;
    let mut cells = Vec::new();
    while !wave.is_empty() {
        let traced: Vec<BounceTrace> =
            wave.par_iter().map(|&key| trace_bounce(key, texture, settings, mesh, tracer)).collect();
        progress(traced.len() as u64);
        let seen = traced.iter().flat_map(|c| &c.seen).filter_map(|s| s.cell);
        let next: BTreeSet<CellKey> = seen.filter(|key| !known.contains(key)).collect();
        known.extend(&next);
        wave = next.into_iter().collect();
        cells.extend(traced);
    }
    cells.sort_unstable_by_key(|c| c.key);
    cells
}
