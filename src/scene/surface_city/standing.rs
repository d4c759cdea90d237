//! Cells of buildings. In: heights of surface and ground, crowns, land cover. Out: the building of
//! each cell, and the height of the ground on all others.
//!
//! With a raster of the ground a cell stands if the surface is more than [`MIN_STEP_M`] above it;
//! with a land cover code of buildings half of that is enough. Without such a raster, cells without
//! a step between them are connected, and a piece of them stands if it is the higher one on more
//! than half of the length of its steps: streets and courts lie lower than their surroundings,
//! roofs and podiums higher. Standing pieces smaller than the least area are no buildings.
//!
//! Cells without a height inside a raster are voids. A void with roofs alone around it belongs to
//! the building, any other one is ground: photogrammetry has no heights in the shadow of walls.
//! Voids that reach the border of the raster stay without a height.

use std::collections::BTreeMap;

use crate::surface_city::landcover;
use crate::surface_city::lattice::{Lattice, STEPS, Spot, beside};
use crate::surface_city::layers::Layers;
use crate::surface_rasters::{MIN_STEP_M, SurfaceRasters};

/// Least height of a crown, metres: lower ones are hedges and noise.
pub(super) const MIN_CROWN_M: f32 = 1.0;

/// Largest difference between a surface and the top of a crown that it shows, metres.
const SAME_AS_CROWN_M: f32 = 1.5;

/// Longest way across cells without a height to the other side of a step, as a multiple of the
/// step: the shadow of a wall under a sun of 27 degrees, which is lower than in surveys.
const SHADOW: f64 = 2.0;
/// Longest such way, metres: the shadow of a tower of 30 m.
const LONGEST_SHADOW_M: f64 = 60.0;

/// Buildings and ground.
pub(super) struct Standing {
    /// Number of each cell's building, `[cell]`; `u32::MAX` for none.
    pub building: Lattice<u32>,
    /// Cells of each building, from the north-west.
    pub cells: Vec<Vec<Spot>>,
    /// Height of the ground in cells without a building, `[cell]`; NaN if it is not known.
    pub ground: Lattice<f32>,
    /// Height of the ground in all cells, `[cell]`, if it is known.
    pub below: Option<Lattice<f32>>,
    /// Numbers of cells of voids within buildings, and of voids that are ground.
    pub closed: [usize; 2],
}

/// Tells buildings from ground.
pub(super) fn standing(layers: &Layers, options: &SurfaceRasters) -> Standing {
    let least = (options.least_building() / layers.cell_m2()).ceil() as usize;
    let mut stands = match &layers.ground {
        Some(_) => above_ground(layers),
        None => by_steps(layers, options.step(layers.cell_m()), least),
    };
    let voids = voids(&layers.surface);
    let (within, open): (Vec<_>, Vec<_>) = voids.into_iter().partition(|void| is_within(void, layers, &stands));
    within.iter().flatten().for_each(|spot| stands.set(*spot, true));
    let mut is_open = stands.like(false);
    open.iter().flatten().for_each(|spot| is_open.set(*spot, true));
    let (_, pieces) = stands.pieces(|spot| stands.at(spot), |_, _| true);
    let mut building = stands.like(u32::MAX);
    let mut cells: Vec<Vec<Spot>> = Vec::new();
    let mut small = stands.like(false);
    for piece in pieces {
        if piece.len() < least {
            piece.into_iter().for_each(|spot| small.set(spot, true));
            continue;
        }
        piece.iter().for_each(|spot| building.set(*spot, cells.len() as u32));
        cells.push(piece);
    }
    let below = layers.ground.as_ref().map(|known| {
        let mut below = known.clone();
        below.fill();
        below
    });
    let mut ground = stands.like(f32::NAN);
    let mut gaps = false;
    for spot in stands.spots().filter(|spot| building.at(*spot) == u32::MAX) {
        let (surface, known) = (layers.surface.at(spot), layers.ground.as_ref().map(|ground| ground.at(spot)));
        let bare = known.filter(|known| !known.is_nan());
        let is_small = small.at(spot) || layers.crown.as_ref().is_some_and(|crown| crown.at(spot) >= MIN_CROWN_M);
        let height = match bare {
            Some(bare) if is_small || surface.is_nan() || surface < bare - MIN_STEP_M as f32 => bare,
            _ if small.at(spot) && layers.ground.is_none() => f32::NAN,
            _ => surface,
        };
        gaps |= height.is_nan() && (!surface.is_nan() || is_open.at(spot));
        ground.set(spot, height);
    }
    let mut closed = [within.iter().map(Vec::len).sum(), 0];
    if gaps {
        // Pieces too small for a building, and voids, get the ground around them.
        let mut filled = ground.clone();
        filled.fill();
        for spot in stands.spots().filter(|spot| small.at(*spot) || is_open.at(*spot)) {
            closed[1] += usize::from(is_open.at(spot) && ground.at(spot).is_nan());
            ground.set(spot, filled.at(spot));
        }
    }
    Standing { building, cells, ground, below, closed }
}

/// Returns the cells of each void, without those that reach the border of the raster.
fn voids(surface: &Lattice<f32>) -> Vec<Vec<Spot>> {
    let (_, mut voids) = surface.pieces(|spot| surface.at(spot).is_nan(), |_, _| true);
    let is_inner = |spot: &Spot| STEPS.iter().all(|step| surface.holds(beside(*spot, *step)));
    voids.retain(|void| void.iter().all(is_inner));
    voids
}

/// Returns true if all cells around a void stand.
fn is_within(void: &[Spot], layers: &Layers, stands: &Lattice<bool>) -> bool {
    let mut around = void.iter().flat_map(|spot| STEPS.map(|step| beside(*spot, step)));
    around.all(|spot| stands.at(spot) || layers.surface.at(spot).is_nan())
}

/// Returns true for cells that stand above a known ground.
fn above_ground(layers: &Layers) -> Lattice<bool> {
    let mut stands = layers.surface.like(false);
    let Some(mut ground) = layers.ground.clone() else { return stands };
    // Terrain is often left out below buildings.
    ground.fill();
    for spot in stands.spots() {
        let above = layers.surface.at(spot) - ground.at(spot);
        let class = layers.class.as_ref().map(|class| class.at(spot));
        let crown = layers.crown.as_ref().map_or(0.0, |crown| crown.at(spot));
        let is_built = class == Some(landcover::BUILDINGS);
        let is_crown = !is_built && crown >= MIN_CROWN_M && (above - crown).abs() < SAME_AS_CROWN_M;
        let least = if is_built { 0.5 } else { 1.0 } * MIN_STEP_M as f32;
        stands.set(spot, above > least && !is_crown);
    }
    stands
}

/// Returns true for cells that stand higher than their surroundings; `least` cells make a piece.
fn by_steps(layers: &Layers, step_m: f64, least: usize) -> Lattice<bool> {
    let height = |spot: Spot| layers.surface.at(spot);
    let joins = |a: Spot, b: Spot| f64::from((height(a) - height(b)).abs()) <= step_m;
    let (mut number, pieces) = layers.surface.pieces(|spot| !height(spot).is_nan(), joins);
    join_small(&mut number, &pieces, least, height);
    // Steps down and up of each piece, in sides of cells.
    let mut steps: BTreeMap<u32, [usize; 2]> = BTreeMap::new();
    for spot in number.spots() {
        let own = number.at(spot);
        if own == u32::MAX {
            continue;
        }
        for other in STEPS.into_iter().filter_map(|step| across(layers, spot, step, step_m)) {
            if number.at(other) != own {
                let [down, up] = steps.entry(own).or_default();
                if height(spot) > height(other) { *down += 1 } else { *up += 1 }
            }
        }
    }
    let mut stands = layers.surface.like(false);
    for spot in stands.spots() {
        let is_built = layers.class.as_ref().is_some_and(|class| class.at(spot) == landcover::BUILDINGS);
        let is_higher = steps.get(&number.at(spot)).is_some_and(|[down, up]| down > up);
        stands.set(spot, (is_higher || is_built) && !height(spot).is_nan());
    }
    stands
}

/// Returns the next cell with a height in a direction; `None` beyond the border, and beyond a void
/// that is too wide for the shadow of the step across it.
fn across(layers: &Layers, from: Spot, step: Spot, step_m: f64) -> Option<Spot> {
    let height = |spot: Spot| f64::from(layers.surface.at(spot));
    let (mut other, mut way) = (beside(from, step), 0.0);
    while height(other).is_nan() {
        if way >= LONGEST_SHADOW_M || !layers.surface.holds(other) {
            return None;
        }
        (other, way) = (beside(other, step), way + layers.cell_m());
    }
    let high = (height(other) - height(from)).abs();
    (way == 0.0 || high > step_m && way <= SHADOW * high).then_some(other)
}

/// Gives cells of small pieces, such as those that a wall cuts, to the larger piece beside them
/// that is nearest in height.
fn join_small(number: &mut Lattice<u32>, pieces: &[Vec<Spot>], least: usize, height: impl Fn(Spot) -> f32) {
    let is_small = |number: u32| pieces.get(number as usize).is_some_and(|piece| piece.len() < least);
    let mut open: Vec<Spot> = pieces.iter().filter(|piece| piece.len() < least).flatten().copied().collect();
    loop {
        let mut found = Vec::new();
        for &spot in &open {
            let around = STEPS.map(|step| beside(spot, step));
            let large =
                around.into_iter().filter(|other| number.at(*other) != u32::MAX && !is_small(number.at(*other)));
            let off = |other: &Spot| (height(*other) - height(spot)).abs();
            if let Some(near) = large.min_by(|a, b| off(a).total_cmp(&off(b))) {
                found.push((spot, number.at(near)));
            }
        }
        if found.is_empty() {
            return;
        }
        found.iter().for_each(|(spot, to)| number.set(*spot, *to));
        open.retain(|spot| is_small(number.at(*spot)));
    }
}
