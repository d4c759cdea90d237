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

    /// Returns the share at a fine texel, interpolated between the middles of the square's texels:
    /// at the edge of a crown the nearest texel alone errs by up to a tenth of the light.
    #[inline]
    pub fn at_fine(&self, column: usize, row: usize) -> f32 {
        let ([left, right], x) = self.between(column);
        let ([below, above], y) = self.between(row);
        let on = |row: usize| {
            let row = &self.shares[row * self.side..][..self.side];
            row[left] + x * (row[right] - row[left])
        };
        let (below, above) = (on(below), on(above));
        below + y * (above - below)
    }

    /// Returns the two texels of the square between whose middles a fine texel lies, and how far it
    /// is on its way from the first to the second.
    #[inline]
    fn between(&self, fine: usize) -> ([usize; 2], f32) {
        let (texel, inside) = (fine / self.wide, fine % self.wide);
        let way = (2 * inside + 1) as f32 / (2 * self.wide) as f32 - 0.5;
        match way < 0.0 {
            true => ([texel.saturating_sub(1), texel], way + 1.0),
            false => ([texel, (texel + 1).min(self.side - 1)], way),
        }
    }

    /// Returns the share at fine texel `i` of a base texel.
    #[inline]
    pub fn at(&self, column: usize, row: usize, i: usize) -> f32 {
        self.at_fine(column * self.block + i % self.block, row * self.block + i / self.block)
    }

    /// Returns the sum of the shares of the square's texels over all fine texels of a base texel.
    /// Light of a whole base texel needs no interpolation.
    pub fn sum(&self, column: usize, row: usize) -> f64 {
        let step = self.wide.min(self.block);
        let places = || (0..self.block).step_by(step);
        let nearest = |c: usize, r: usize| self.shares[r / self.wide * self.side + c / self.wide];
        let share = |c: usize, r: usize| f64::from(nearest(column * self.block + c, row * self.block + r));
        let sum: f64 = places().flat_map(|r| places().map(move |c| share(c, r))).sum();
        sum * (step * step) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For 5 pairs of sides, with squares of 32, 4, 256, 66 and 150 texels a side, shares that rise
    /// evenly are interpolated to the share at the middle of each fine texel (1e-5), inside of the
    /// square, and the sum over a base texel is that of its texels of the square (1e-9).
    #[test]
    fn shares_are_interpolated() {
        for (base, fine, side) in [(8, 64, 32), (4, 4, 4), (512, 1024, 256), (33, 66, 66), (300, 600, 150)] {
            let sides = TextureSides { sky_base: base, sky_fine: fine, response: 1 };
            assert_eq!(sky_side(base, fine), side);
            let rise = |x: f64, y: f64| (0.1 + 0.3 * x + 0.5 * y) as f32;
            let middle = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
            let share = |place: usize| rise(middle(place % side, side), middle(place / side, side));
            let veil = CanopyTransmittance::new((0..side * side).map(share).collect(), sides);
            let block = fine / base;
            for texel in (0..base * base).step_by(base * base / 16) {
                let (column, row) = (texel % base, texel / base);
                let each = |i: usize| {
                    let (c, r) = (column * block + i % block, row * block + i / block);
                    let rim = fine / side;
                    if [c, r].iter().all(|place| (rim..fine - rim).contains(place)) {
                        assert!((veil.at(column, row, i) - rise(middle(c, fine), middle(r, fine))).abs() < 1e-5);
                    }
                    f64::from(share(r * side / fine * side + c * side / fine))
                };
                let sum: f64 = (0..block * block).map(each).sum();
                assert!((veil.sum(column, row) - sum).abs() < 1e-9);
            }
        }
    }
}
