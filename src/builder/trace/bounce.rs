//! Bounce cells: the coarse cells that carry second and later bounces. In: a cell that a probe or another such cell sees. Out: its
//! sky bits and a list of what it sees.

use crate::trace::mirror::Reflections;
use crate::trace::probe::{Directions, ProbeTrace, trace_probe};
use crate::trace::surface::CellSurfaces;
use crate::trace::surroundings::{SurroundingSettings, Surroundings, surroundings};
use heliotile_core::site::cells::CellKey;

/// Traces one coarse cell; the cells it sees are never finer than itself, so the system stays finite in a large scene.
pub fn trace_bounce(
    key: CellKey,
    texture: &Directions,
    settings: SurroundingSettings,
    surfaces: CellSurfaces,
    reflections: Option<&Reflections>,
) -> (ProbeTrace, Surroundings) {
    let probe = trace_probe(key, texture, surfaces);
    let seen = surroundings(key, &probe, texture, settings, surfaces, reflections);
    (probe, seen)
}
