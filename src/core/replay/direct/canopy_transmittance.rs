//! Share of the light from each direction of the sky that canopies let through. In: shares by texel
//! of a square. Out: the share at any texel of a receiver's sky texture.

use crate::layers::canopy::sky_side;
use crate::layers::sides::TextureSides;

/// Shares of the light that come through to a receiver, on a square over its sky texture.
pub struct CanopyTransmittance {
    /// Shares of the texels, row-major.
    shares: Vec<f32>,
    side: usize,
    /// Number of fine texels a side of a texel of the square (`wide`) and of a base texel
    /// (`block`).
    wide: usize,
    block: usize,
}

impl CanopyTransmittance {
    /// Takes shares by texel, for a sky texture of the given sides.
    pub fn new(shares: Vec<f32>, sides: TextureSides) -> Self {
        let side = sky_side(sides.sky_base, sides.sky_fine);
        CanopyTransmittance { shares, side, wide: sides.sky_fine / side, block: sides.sky_fine / sides.sky_base }
    }

    /// Returns shares of 1 in all directions: nothing is in the way.
    pub fn clear(sides: TextureSides) -> Self {
        let side = sky_side(sides.sky_base, sides.sky_fine);
        CanopyTransmittance::new(vec![1.0; side * side], sides)
    }

    /// Returns the size of the shares in bytes.
    pub fn bytes(&self) -> usize {
        self.shares.len() * size_of::<f32>()
    }

    /// Returns the share at a fine texel.
    #[inline]
    pub fn at_fine(&self, column: usize, row: usize) -> f32 {
        self.shares[row / self.wide * self.side + column / self.wide]
    }

    /// Returns the share at fine texel `i` of a base texel.
    #[inline]
    pub fn at(&self, column: usize, row: usize, i: usize) -> f32 {
        self.at_fine(column * self.block + i % self.block, row * self.block + i / self.block)
    }

    /// Returns the sum of the shares at all fine texels of a base texel.
    pub fn sum(&self, column: usize, row: usize) -> f64 {
        let step = self.wide.min(self.block);
        let places = || (0..self.block).step_by(step);
        let share = |c: usize, r: usize| f64::from(self.at_fine(column * self.block + c, row * self.block + r));
        let sum: f64 = places().flat_map(|r| places().map(move |c| share(c, r))).sum();
        sum * (step * step) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::mix;

    /// For 5 pairs of sides, with squares of 16, 4, 256, 66 and 150 texels a side, the sum over a
    /// base texel equals that of its fine texels (1e-9), and a fine texel has the share of the
    /// square's texel at the same place.
    #[test]
    fn base_texels_equal_the_sum_of_their_fine_texels() {
        for (base, fine, side) in [(8, 64, 16), (4, 4, 4), (512, 1024, 256), (33, 66, 66), (300, 600, 150)] {
            let sides = TextureSides { sky_base: base, sky_fine: fine, response: 1 };
            assert_eq!(sky_side(base, fine), side);
            let share = |place: usize| (mix(7, place as u64) % 1000) as f32 / 1000.0;
            let veil = CanopyTransmittance::new((0..side * side).map(share).collect(), sides);
            let block = fine / base;
            for texel in (0..base * base).step_by(base * base / 16) {
                let (column, row) = (texel % base, texel / base);
                let each = |i: usize| {
                    let (c, r) = (column * block + i % block, row * block + i / block);
                    assert_eq!(veil.at(column, row, i), share(r * side / fine * side + c * side / fine));
                    f64::from(veil.at(column, row, i))
                };
                let sum: f64 = (0..block * block).map(each).sum();
                assert!((veil.sum(column, row) - sum).abs() < 1e-9);
            }
        }
    }
}
