//! Transform from 3-vectors to the whole numbers that a replay can tell apart, and back. In: a
//! receiver's response, f32. Out: coefficients.
//!
//! A source in direction s meets texels whose directions are close to s. So the part of G along its
//! texel's direction counts in full, and the parts across it count by the angle between. Each
//! texel's vector is turned into these parts, blocks of 8 x 8 texels into cosines (Ahmed, Natarajan
//! and Rao 1974, orthonormal), and these are rounded to a step each. All arithmetic is in f64, in
//! one order, without fused operations, so that every machine gives the same bits.

use glam::DVec3;

use crate::hemisphere::texel_centres;
use crate::layers::response::texture::{CLASSES, Response};

/// Number of texels to a side of a block.
pub const BLOCK: usize = 8;

/// Number of planes of a receiver: for each class the part along the direction, then the two
/// across.
pub const PLANES: usize = CLASSES * 3;

/// Returns true if a plane holds a part across the direction.
pub fn is_across(plane: usize) -> bool {
    !plane.is_multiple_of(3)
}

/// Largest size of a coefficient, above and below 0.
pub const LARGEST: i32 = (1 << 22) - 1;

/// Fraction of a step from which a coefficient is rounded up. It is more than a half, since a
/// coefficient that rounds to 0 costs next to nothing. Means are rounded from a half: they are
/// hardly ever below 0, so that rounding them down would lose light.
const ROUNDED_UP: f64 = 0.6;
const MEAN_ROUNDED_UP: f64 = 0.5;

/// Values of cos(k pi / 16) for k from 0 to 8.
const COSINES: [f64; 9] = [
    1.0,
    0.980_785_280_403_230_4,
    0.923_879_532_511_286_7,
    0.831_469_612_302_545_2,
    std::f64::consts::FRAC_1_SQRT_2,
    0.555_570_233_019_602_2,
    0.382_683_432_365_089_8,
    0.195_090_322_016_128_28,
    0.0,
];

/// A block of values or coefficients, row by row.
type Square = [[f64; BLOCK]; BLOCK];

/// Returns the orthonormal cosines: `[frequency][place]`.
fn basis() -> Square {
    std::array::from_fn(|k| {
        std::array::from_fn(|i| {
            // The cosine at k (2 i + 1) / 16 half turns follows from its symmetries; frequency 0
            // uses the cosine of 4 sixteenths.
            let sixteenths = if k == 0 { 4 } else { k * (2 * i + 1) % 32 };
            let folded = if sixteenths > 16 { 32 - sixteenths } else { sixteenths };
            if folded > 8 { -0.5 * COSINES[16 - folded] } else { 0.5 * COSINES[folded] }
        })
    })
}

/// Transform of the responses of n x n texels.
pub struct Transform {
    /// Side of the texture.
    n: usize,
    /// `[x, y, z of the direction; x and y over 1 + z][texel]`.
    texels: [Vec<f64>; 5],
    basis: Square,
    /// Steps of a coefficient, along the direction and across.
    steps: [f64; 2],
}

impl Transform {
    /// Makes the transform with steps of 2^-exponent along the direction and n times that across:
    /// at n texels a side both add alike to a source's light. Returns `None` if `n` is no multiple
    /// of a block's side.
    pub fn new(n: usize, exponent: u8) -> Option<Self> {
        if n == 0 || !n.is_multiple_of(BLOCK) {
            return None;
        }
        // Directions lie on a grid, so that another program with slightly different results rounds
        // to the same values.
        const GRID: f64 = (1 << 24) as f64;
        let centres: Vec<DVec3> = texel_centres(n).into_iter().map(|s| (s * GRID).round() / GRID).collect();
        let of_texels = |part: fn(&DVec3) -> f64| centres.iter().map(part).collect();
        let step = 0.5_f64.powi(i32::from(exponent));
        Some(Transform {
            n,
            texels: [
                of_texels(|s| s.x),
                of_texels(|s| s.y),
                of_texels(|s| s.z),
                of_texels(|s| s.x / (1.0 + s.z)),
                of_texels(|s| s.y / (1.0 + s.z)),
            ],
            basis: basis(),
            steps: [step, step * n as f64],
        })
    }

    fn texel(&self, t: usize) -> [f64; 5] {
        self.texels.each_ref().map(|of_texels| of_texels[t])
    }

    /// Returns the number of blocks of a plane.
    pub fn blocks(&self) -> usize {
        (self.n / BLOCK).pow(2)
    }

    fn step(&self, plane: usize) -> f64 {
        self.steps[usize::from(is_across(plane))]
    }

    /// Returns the index in a plane of the first texel in a row of a block.
    #[inline(always)]
    fn start(&self, block: usize, row: usize) -> usize {
        let wide = self.n / BLOCK;
        (block / wide * BLOCK + row) * self.n + block % wide * BLOCK
    }

    /// Returns the coefficients of a response: `[plane][block][row][column]`.
    pub fn forward(&self, response: &Response) -> Vec<i32> {
        let count = self.n * self.n;
        let mut planes = vec![0.0; PLANES * count];
        let values = response.values.chunks_exact(3 * count);
        for (of_class, values) in planes.chunks_exact_mut(3 * count).zip(values) {
            for t in 0..count {
                let [x, y, z] = [0, 1, 2].map(|axis| f64::from(values[axis * count + t]));
                let [sx, sy, sz, u, v] = self.texel(t);
                // The parts across are those along Frisvad's tangents (2012, "Building an
                // orthonormal basis from a 3D unit vector without normalization"). Texels have z >=
                // 0, so 1 + z is never near 0.
                let along = x * sx + y * sy + z * sz;
                of_class[t] = along;
                of_class[count + t] = x - u * (along + z);
                of_class[2 * count + t] = y - v * (along + z);
            }
        }
        let mut out = Vec::with_capacity(PLANES * self.blocks() * BLOCK * BLOCK);
        for (plane, values) in planes.chunks_exact(count).enumerate() {
            for block in 0..self.blocks() {
                let square: Square =
                    std::array::from_fn(|row| std::array::from_fn(|column| values[self.start(block, row) + column]));
                let from = |place: usize| if place == 0 { MEAN_ROUNDED_UP } else { ROUNDED_UP };
                let cosines = self.cosines(&square);
                let steps = cosines.as_flattened().iter().map(|c| c / self.step(plane));
                out.extend(steps.enumerate().map(|(place, value)| rounded(value, from(place))));
            }
        }
        out
    }

    fn cosines(&self, square: &Square) -> Square {
        // `[row][frequency]`, then `[frequency][frequency]`.
        let of_row = |row: &[f64; BLOCK], k: usize| row.iter().zip(&self.basis[k]).map(|(v, with)| v * with).sum();
        let rows: Square = std::array::from_fn(|i| std::array::from_fn(|k| of_row(&square[i], k)));
        let of_rows = |k: usize| (0..BLOCK).fold([0.0; BLOCK], |sums, i| plus(sums, &rows[i], self.basis[k][i]));
        std::array::from_fn(of_rows)
    }

    /// Returns the response of some coefficients. `planes` is a buffer for the values of the
    /// planes; its former contents do not matter.
    #[inline(always)]
    pub fn inverse(&self, coefficients: &[i32], planes: &mut Vec<f64>) -> Response {
        let count = self.n * self.n;
        planes.resize(PLANES * count, 0.0);
        let blocks = coefficients.as_chunks::<BLOCK>().0.as_chunks::<BLOCK>().0;
        for (plane, (values, blocks)) in
            planes.chunks_exact_mut(count).zip(blocks.chunks_exact(self.blocks())).enumerate()
        {
            for (block, coefficients) in blocks.iter().enumerate() {
                let square = self.values(coefficients, self.step(plane));
                for (row, line) in square.iter().enumerate() {
                    let start = self.start(block, row);
                    values[start..start + BLOCK].copy_from_slice(line);
                }
            }
        }
        let mut response = Response { values: vec![0.0; PLANES * count] };
        let of_classes = response.values.chunks_exact_mut(3 * count);
        for (out, planes) in of_classes.zip(planes.chunks_exact(3 * count)) {
            let (xs, rest) = out.split_at_mut(count);
            let (ys, zs) = rest.split_at_mut(count);
            let (along, rest) = planes.split_at(count);
            let (p, q) = rest.split_at(count);
            let (zs, q) = (&mut zs[..count], &q[..count]);
            let [sx, sy, sz, u, v] = self.texels.each_ref().map(|of_texels| &of_texels[..count]);
            for t in 0..count {
                let across = p[t] * u[t] + q[t] * v[t];
                xs[t] = ((along[t] - across) * sx[t] + p[t]) as f32;
                ys[t] = ((along[t] - across) * sy[t] + q[t]) as f32;
                zs[t] = (along[t] * sz[t] - (p[t] * sx[t] + q[t] * sy[t])) as f32;
            }
        }
        response
    }

    /// Returns the values of a block. It sums over the frequencies of a row, then over the rows,
    /// from the lowest to the last one that is not 0.
    #[inline(always)]
    fn values(&self, coefficients: &[[i32; BLOCK]; BLOCK], step: f64) -> Square {
        let any = coefficients.iter().fold([0; BLOCK], |any, line| std::array::from_fn(|k| any[k] | line[k]));
        let mut out = [[0.0; BLOCK]; BLOCK];
        let Some(last) = any.iter().rposition(|any| *any != 0) else {
            return out;
        };
        let height = coefficients.iter().rposition(|line| *line != [0; BLOCK]).map_or(0, |row| row + 1);
        for (line, with) in coefficients.iter().zip(&self.basis).take(height) {
            let mut sums = [0.0; BLOCK];
            for (&coefficient, with) in line.iter().zip(&self.basis).take(last + 1) {
                sums = plus(sums, with, f64::from(coefficient) * step);
            }
            for (out, &factor) in out.iter_mut().zip(with) {
                *out = plus(*out, &sums, factor);
            }
        }
        out
    }
}

#[inline(always)]
fn plus(sums: [f64; BLOCK], line: &[f64; BLOCK], factor: f64) -> [f64; BLOCK] {
    std::array::from_fn(|i| sums[i] + line[i] * factor)
}

/// Rounds a value to a whole number: away from 0 if the fraction is `from` or more, else towards 0.
/// Values within 0.4 of a whole number become that number, so that coefficients come back.
fn rounded(value: f64, from: f64) -> i32 {
    let size = (value.abs() + (1.0 - from)).floor() as i32;
    let size = size.min(LARGEST);
    if value < 0.0 { -size } else { size }
}
