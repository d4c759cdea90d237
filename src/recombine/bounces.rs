//! Second and later bounces. In: the closed system of coarse cells and their reflectances. Out: each cell's radiosity per unit
//! of irradiance from each direction of the sky.
//!
//! X_j[t] = rho_j ( b_j[t] n_j + sum_k F_jk X_k[t] ) for every sky texel t (one 3-vector each, as for the receiver's response;
//! Goral et al. 1984 for the radiosity system). Only cells from the closed level up see each other in circles: they take a
//! fixed number of Jacobi steps. Finer cells see coarser ones only and follow once, level by level. So the result for a cell
//! depends on the cells reachable from it, not on which others are in the table.

use rayon::prelude::*;

use crate::hemisphere::{bit, texel_centres};
use crate::layers::probes::{Bounces, DOWN, MISS};

/// How many times light may be reflected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// Until less than [`TOLERANCE`] of the light is left.
    All,
    /// At most this many diffuse reflections; 1 is the paper's model.
    Count(u32),
}

/// Share of the reflected light that `Depth::All` may leave out.
pub const TOLERANCE: f64 = 1e-3;

/// Columns of the system solved together: small enough for a core's cache.
const BLOCK: usize = 32;

/// Solved system.
#[derive(Clone, Debug)]
pub struct Solved {
    /// [block of columns][cell][column]: radiosity per unit normal irradiance is s . X; a cell's columns are [axis][texel].
    blocks: Vec<Vec<[f32; BLOCK]>>,
    /// Values of one cell: 3 x texels.
    pub width: usize,
}

impl Solved {
    /// Values of one cell, [axis][texel].
    pub fn row(&self, cell: usize) -> impl Iterator<Item = f32> + '_ {
        self.blocks.iter().flat_map(move |block| block[cell]).take(self.width)
    }
}

/// How one cell's two kinds of rays share its surroundings.
#[derive(Clone, Copy, Debug)]
pub struct Surround {
    /// Cosine-weighted share of the hemisphere above the horizon that is not sky.
    pub up: f64,
    /// Cosine-weighted share below the horizon.
    pub down: f64,
}

/// Shares of a cell with mean normal n and n x n sky bits. The share above the horizon is what the sky bits leave, so that
/// sky and surroundings always add up to the whole hemisphere: a white furnace stays white.
pub fn surround(normal: [f32; 3], bits: &[u8], centres: &[[f32; 3]]) -> Surround {
    let share = 2.0 / centres.len() as f64;
    let mut sky = 0.0;
    for (t, d) in centres.iter().enumerate() {
        if bit(bits, t) {
            let cos = normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2];
            sky += f64::from(cos.max(0.0));
        }
    }
    let half = (1.0 + f64::from(normal[2])) / 2.0;
    Surround { up: (half - sky * share).max(0.0), down: (1.0 - half).max(0.0) }
}

/// Texel centres of an n x n texture in f32.
pub fn centres_f32(n: usize) -> Vec<[f32; 3]> {
    texel_centres(n).iter().map(|d| d.as_vec3().to_array()).collect()
}

/// Cells and their weights.
pub type Weighted = Vec<(u32, f32)>;

/// Weights of the cells that one cell sees, for its rays above and below the horizon apart: each list sums to the share of
/// rays that met something (of the rays that met something, for the upper ones). Sorted by first ray.
pub fn seen(hits: &[u32]) -> (Weighted, Weighted) {
    let below: Vec<u32> = hits.iter().filter(|&&h| h & DOWN != 0).map(|h| h & !DOWN).collect();
    let above: Vec<u32> = hits.iter().filter(|&&h| h & DOWN == 0 && h != MISS).copied().collect();
    let merge = |rays: &[u32]| {
        let weight = 1.0 / rays.len().max(1) as f32;
        let mut merged: Weighted = Vec::with_capacity(rays.len());
        for &cell in rays.iter().filter(|&&h| h != MISS) {
            match merged.iter_mut().find(|m| m.0 == cell) {
                Some(m) => m.1 += weight,
                None => merged.push((cell, weight)),
            }
        }
        merged
    };
    (merge(&above), merge(&below))
}

/// Solves the system for `n` x `n` texels; `reflectance[material]` is the diffuse one.
pub fn solve(cells: &Bounces, n: usize, closed_level: i8, reflectance: &[f64], depth: Depth) -> Solved {
    let (texels, width) = (n * n, 3 * n * n);
    let count = cells.keys.len();
    // The first reflection is the fine probe's, the second is the source term below.
    let steps = match depth {
        Depth::Count(bounces) => (bounces as usize).saturating_sub(2),
        Depth::All => {
            let largest = reflectance.iter().copied().fold(0.0, f64::max).clamp(1e-3, 0.97);
            (TOLERANCE.ln() / largest.ln()).ceil() as usize
        }
    };
    let rho = |cell: usize| reflectance.get(usize::from(cells.keys[cell].material)).copied().unwrap_or(0.0) as f32;
    let centres = centres_f32(n);
    let rays = cells.hits.len().checked_div(count).unwrap_or(0);
    let row_bytes = cells.bits.len().checked_div(count).unwrap_or(0);
    let rows: Vec<Weighted> = (0..count)
        .into_par_iter()
        .map(|i| {
            let bits = &cells.bits[i * row_bytes..(i + 1) * row_bytes];
            let around = surround(cells.normals[i], bits, &centres);
            let (above, below) = seen(&cells.hits[i * rays..(i + 1) * rays]);
            let scaled =
                |list: Weighted, share: f64| list.into_iter().map(move |(cell, w)| (cell, w * share as f32 * rho(i)));
            scaled(above, around.up).chain(scaled(below, around.down)).collect()
        })
        .collect();
    // Keys are sorted by level: finer cells first.
    let closed = cells.keys.partition_point(|k| k.level < closed_level);
    let gather = |i: usize, source: &[f32; BLOCK], now: &[[f32; BLOCK]]| {
        let mut sum = *source;
        for &(cell, weight) in &rows[i] {
            for (s, x) in sum.iter_mut().zip(&now[cell as usize]) {
                *s += weight * x;
            }
        }
        sum
    };
    let blocks = (0..width.div_ceil(BLOCK))
        .into_par_iter()
        // Two of the three buffers serve block after block.
        .map_init(Default::default, |(source, next): &mut (Vec<_>, Vec<_>), block| {
            source.clear();
            source.resize(count, [0.0_f32; BLOCK]);
            for (i, source) in source.iter_mut().enumerate() {
                let bits = &cells.bits[i * row_bytes..(i + 1) * row_bytes];
                for (slot, column) in (block * BLOCK..width.min((block + 1) * BLOCK)).enumerate() {
                    if bit(bits, column % texels) {
                        source[slot] = rho(i) * cells.normals[i][column / texels];
                    }
                }
            }
            let mut now = source.clone();
            // With a bounded number of reflections every cell takes each step; else the finer cells wait for the closed ones.
            let first = if depth == Depth::All { closed } else { 0 };
            for _ in 0..steps {
                next.clear();
                next.extend((first..count).map(|i| gather(i, &source[i], &now)));
                now[first..].copy_from_slice(next);
            }
            for i in (0..first).rev() {
                now[i] = gather(i, &source[i], &now);
            }
            now
        })
        .collect();
    Solved { blocks, width }
}
