//! Bounce cells: the coarse cells that carry second and later bounces. In: a cell that a probe or another such cell sees. Out: its
//! sky bits and a list of what it sees.

use glam::DVec3;

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
