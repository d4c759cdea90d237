//! The response texture: diffuse light at a receiver per unit of irradiance from each direction of the sky. In: 3-vectors
//! per texel and first-hit class, f32. Out: 16-bit floats of a tile, and back.

use half::f16;

use crate::site::material::Class;

/// First-hit classes, in the order of the arrays: ground, obstruction.
pub const CLASSES: usize = 2;

/// Response of one receiver: the diffuse irradiance from a source of direction s in texel t is (normal irradiance of the
/// source) x `s . G[t]`, W/m2 per W/m2, summed over classes.
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

/// Raw block: the low bytes, then the high bytes of all values of all receivers as IEEE 754 binary16.
pub fn pack(tile: &[Response]) -> Vec<u8> {
    let halves: Vec<[u8; 2]> = tile.iter().flat_map(|r| &r.values).map(|&v| f16::from_f32(v).to_le_bytes()).collect();
    halves.iter().map(|h| h[0]).chain(halves.iter().map(|h| h[1])).collect()
}

/// Inverse of [`pack`]; `None` if the bytes are not `count` responses of n x n texels with finite values.
pub fn unpack(raw: &[u8], count: usize, n: usize) -> Option<Vec<Response>> {
    let len = Response::len(n);
    let total = count.checked_mul(len)?;
    if raw.len() != total.checked_mul(2)? {
        return None;
    }
    let (low, high) = raw.split_at(total);
    let values: Vec<f32> = low.iter().zip(high).map(|(&l, &h)| f16::from_le_bytes([l, h]).to_f32()).collect();
    let finite = values.iter().all(|v| v.is_finite());
    finite.then(|| values.chunks(len.max(1)).map(|v| Response { values: v.to_vec() }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values survive to 5e-4 of their size (11 significant bits), and an infinity is refused.
    #[test]
    fn round_trip() {
        let values: Vec<f32> = (0..Response::len(4)).map(|i| (i as f32 * 0.37).sin() * 0.2).collect();
        let tile = vec![Response { values: values.clone() }, Response { values }];
        let raw = pack(&tile);
        let back = unpack(&raw, 2, 4).unwrap_or_default();
        assert_eq!(back.len(), 2);
        for (a, b) in tile[1].values.iter().zip(&back[1].values) {
            assert!((a - b).abs() <= 5e-4 * a.abs() + 1e-7);
        }
        let broken = vec![Response { values: vec![f32::INFINITY; Response::len(4)] }];
        assert_eq!(unpack(&pack(&broken), 1, 4), None);
    }
}
