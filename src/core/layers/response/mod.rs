//! The response texture: diffuse light at a receiver per unit of irradiance from each direction of
//! the sky. In: 3-vectors per texel and first-hit class, f32. Out: the bytes of a tile, rounded to
//! what a replay can tell apart, and back.
//!
//! Steps are 2^-e along a texel's direction and n times that across. Rounding to them adds at most
//! sqrt(2 (4/9 + 0.56) / 12) = 0.41 steps of one W/m2 for each W/m2 of a source at normal
//! incidence, RMS over directions. This holds for two classes and uniform errors. 4/9 is the mean
//! of the squared bilinear weights; 0.56 = 0.0444 x 2 x 2 pi is the mean of these times the squared
//! angles in texels. With e = 7 + log2 n the error is 0.0032 / n.

mod code;
mod texture;
mod transform;

use pulp::{Arch, NullaryFnOnce};

use crate::layers::response::code::TileDecoder;
use crate::layers::response::transform::Transform;
pub use texture::{CLASSES, Response};

/// Largest number of values of a tile, 32 MiB. A limit is needed since a small block can stand for
/// large textures.
pub const MAX_VALUES: usize = 1 << 23;

/// Largest exponent of a step that is read.
const MAX_EXPONENT: u8 = 40;

/// Returns e, where the step of n x n texels is 2^-e. Finer textures belong to finer settings and
/// get finer steps.
fn exponent(n: usize) -> u8 {
    7 + n.max(1).ilog2() as u8
}

/// Packs responses of one size into a raw block: the exponent, then the coefficients' bytes.
/// Returns `None` if the side of their textures is no multiple of 8. Unpacked responses give the
/// bytes that they came from, among the same receivers.
pub fn pack(tile: &[Response]) -> Option<Vec<u8>> {
    let n = tile.first().map_or(0, |first| (first.values.len() / (CLASSES * 3)).isqrt());
    let transform = Transform::new(n, exponent(n))?;
    let coefficients: Vec<Vec<i32>> = tile.iter().map(|response| transform.forward(response)).collect();
    Some([vec![exponent(n)], code::encode(&coefficients)].concat())
}

/// Unpacks the responses of a raw block. Returns `None` if the bytes are not `count` responses of n
/// x n texels.
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

/// Unpacking compiled for the processor that it runs on, with the same operations in the same order
/// on every processor.
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
