//! The response texture: diffuse light at a receiver per unit of irradiance from each direction of
//! the sky. In: 3-vectors per texel and first-hit class, f32. Out: the bytes of a tile, rounded to
//! what a replay can tell apart, and back.
//!
//! Rounding with steps of 2^-e along a texel's direction and n times that across adds at most
//! sqrt(2 (4/9 + 0.56) / 12) = 0.41 steps of one W/m2 for each W/m2 of a source at normal
//! incidence, RMS over directions: two classes, uniform errors, and 4/9 and 0.0444 x 2 x 2 pi the
//! means of the squared bilinear weights, and of these times the squared angles in texels. With e =
//! 7 + log2 n that is 0.0032 / n.

mod code;
mod transform;

use pulp::{Arch, NullaryFnOnce};

use crate::layers::response::code::TileDecoder;
use crate::layers::response::transform::Transform;
use crate::site::material::Class;

/// First-hit classes, in the order of the arrays: ground, obstruction.
pub const CLASSES: usize = 2;

/// Response of one receiver: the diffuse irradiance from a source of direction s in texel t is
/// (normal irradiance of the source) x `s . G[t]`, W/m2 per W/m2, summed over classes.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// `[class][axis x, y, z][texel]`, texels row-major, world frame.
    pub values: Vec<f32>,
}

impl Response {
    /// Number of values of one receiver with n x n texels.
    pub fn len(n: usize) -> usize {
        CLASSES * 3 * n * n
    }

    /// One first-hit class alone: `[texel][axis]`.
    pub fn vectors_of(&self, class: Class) -> Vec<[f32; 3]> {
        let texels = self.values.len() / (CLASSES * 3);
        let at = |axis: usize, texel: usize| self.values[(class.index() * 3 + axis) * texels + texel];
        (0..texels).map(|texel| [at(0, texel), at(1, texel), at(2, texel)]).collect()
    }

    /// Both classes together: `[texel][axis]`.
    pub fn vectors(&self) -> Vec<[f32; 3]> {
        let (ground, obstruction) = self.values.split_at(self.values.len() / CLASSES);
        let texels = ground.len() / 3;
        let at = |axis: usize| {
            let range = axis * texels..(axis + 1) * texels;
            ground[range.clone()].iter().zip(&obstruction[range]).map(|(a, b)| a + b)
        };
        at(0).zip(at(1)).zip(at(2)).map(|((x, y), z)| [x, y, z]).collect()
    }
}

/// Most values of a tile, 32 MiB: a small block can stand for large textures.
pub const MAX_VALUES: usize = 1 << 23;

/// Exponents beyond this mean nothing.
const MAX_EXPONENT: u8 = 40;

/// The step of n x n texels is 2 to minus this; finer textures, for finer settings, get finer
/// steps.
fn exponent(n: usize) -> u8 {
    7 + n.max(1).ilog2() as u8
}

/// Raw block of responses of one size: the exponent, then the coefficients' bytes; `None` if a side
/// of their textures is no multiple of 8. What was unpacked gives the bytes that it came from,
/// among the same receivers.
pub fn pack(tile: &[Response]) -> Option<Vec<u8>> {
    let n = tile.first().map_or(0, |first| (first.values.len() / (CLASSES * 3)).isqrt());
    let transform = Transform::new(n, exponent(n))?;
    let coefficients: Vec<Vec<i32>> = tile.iter().map(|response| transform.forward(response)).collect();
    Some([vec![exponent(n)], code::encode(&coefficients)].concat())
}

/// The responses of a raw block; `None` if the bytes are not `count` responses of n x n texels.
pub fn unpack(raw: &[u8], count: usize, n: usize) -> Option<Vec<Response>> {
    let values = n.checked_mul(n)?.checked_mul(CLASSES * 3)?.checked_mul(count)?;
    if values > MAX_VALUES {
        return None;
    }
    let (&exponent, bytes) = raw.split_first()?;
    if exponent > MAX_EXPONENT {
        return None;
    }
    let transform = Transform::new(n, exponent)?;
    let decoder = TileDecoder::new(bytes, count, transform.blocks())?;
    Arch::new().dispatch(Unpacking { transform: &transform, decoder, count })
}

/// Unpacking for the processor that it runs on: the same operations in the same order on each.
struct Unpacking<'a> {
    transform: &'a Transform,
    decoder: TileDecoder<'a>,
    count: usize,
}

impl NullaryFnOnce for Unpacking<'_> {
    type Output = Option<Vec<Response>>;

    #[inline(always)]
    fn call(mut self) -> Self::Output {
        let (mut tile, mut planes) = (Vec::new(), Vec::new());
        for _ in 0..self.count {
            tile.push(self.transform.inverse(self.decoder.receiver()?, &mut planes));
        }
        self.decoder.is_done().then_some(tile)
    }
}

#[cfg(test)]
mod tests;
