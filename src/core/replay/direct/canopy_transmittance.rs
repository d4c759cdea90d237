//! Share of the light from each direction of the sky that canopies let through. In: shares by texel
//! of a square. Out: the share at any texel of a receiver's sky texture.

use crate::layers::canopy::sky_side;
use crate::layers::sides::TextureSides;

/// Shares of the light that come through to a receiver, on a square over its sky texture.
pub struct CanopyTransmittance {
    side: usize,
    /// Number of fine texels a side of a texel of the square (`wide`) and of a base texel
    /// (`block`).
    wide: usize,
    block: usize,
    /// Number of texels of the square a side of a tile.
    of_tile: usize,
    /// Tiles of the square, row-major. Each is a base texel, or a texel of a square that is
    /// coarser.
    tiles: Vec<Tile>,
    /// `[mixed tile][texel]`, row-major: shares.
    shares: Vec<f32>,
}

/// Shares of the texels of a tile.
#[derive(Clone, Copy)]
enum Tile {
    /// One share, also in the texels next to the tile: it is that of all fine texels.
    Even(f32),
    /// One share, but for texels next to the tile.
    Flat(f32),
    /// Shares that begin at a place.
    Mixed(u32),
}

impl CanopyTransmittance {
    /// Takes shares by texel of the square, row-major, for a sky texture of the given sides.
    pub fn new(shares: &[f32], sides: TextureSides) -> Self {
        let side = sky_side(sides.sky_base, sides.sky_fine);
        let across = sides.sky_base.min(side);
        let of_tile = side / across;
        let mut mixed = Vec::new();
        let mut tile = |column: usize, row: usize| {
            let first = row * of_tile * side + column * of_tile;
            let same = |rows: std::ops::Range<usize>, columns: std::ops::Range<usize>| {
                rows.clone().all(|row| shares[row * side..][columns.clone()].iter().all(|s| *s == shares[first]))
            };
            let own = |at: usize| at * of_tile..(at + 1) * of_tile;
            let near = |at: usize| (at * of_tile).saturating_sub(1)..((at + 1) * of_tile + 1).min(side);
            if same(near(row), near(column)) {
                return Tile::Even(shares[first]);
            }
            if same(own(row), own(column)) {
                return Tile::Flat(shares[first]);
            }
            let place = mixed.len() as u32;
            (0..of_tile).for_each(|row| mixed.extend(&shares[first + row * side..][..of_tile]));
            Tile::Mixed(place)
        };
        let tiles = (0..across * across).map(|i| tile(i % across, i / across)).collect();
        let (wide, block) = (sides.sky_fine / side, sides.sky_fine / sides.sky_base);
        CanopyTransmittance { side, wide, block, of_tile, tiles, shares: mixed }
    }

    /// Returns shares of 1 in all directions: nothing is in the way.
    pub fn clear(sides: TextureSides) -> Self {
        let side = sky_side(sides.sky_base, sides.sky_fine);
        CanopyTransmittance::new(&vec![1.0; side * side], sides)
    }

    /// Returns the size of the shares in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.tiles[..]) + size_of_val(&self.shares[..])
    }

    /// Returns the tile of a texel of the square.
    #[inline]
    fn tile(&self, column: usize, row: usize) -> Tile {
        self.tiles[row / self.of_tile * (self.side / self.of_tile) + column / self.of_tile]
    }

    /// Returns the share at a texel of the square.
    #[inline]
    fn share(&self, column: usize, row: usize) -> f32 {
        match self.tile(column, row) {
            Tile::Even(share) | Tile::Flat(share) => share,
            Tile::Mixed(place) => {
                self.shares[place as usize + row % self.of_tile * self.of_tile + column % self.of_tile]
            }
        }
    }

    /// Returns the share at all fine texels of a base texel, if it is the same.
    #[inline]
    pub fn even(&self, column: usize, row: usize) -> Option<f32> {
        match self.tile(column * self.block / self.wide, row * self.block / self.wide) {
            Tile::Even(share) => Some(share),
            _ => None,
        }
    }

    /// Returns the share at a fine texel, interpolated between the middles of the square's texels:
    /// at the edge of a crown the nearest texel alone errs by up to a tenth of the light.
    #[inline]
    pub fn at_fine(&self, column: usize, row: usize) -> f32 {
        let ([left, right], x) = self.between(column);
        let ([below, above], y) = self.between(row);
        let on = |row: usize| {
            let left = self.share(left, row);
            left + x * (self.share(right, row) - left)
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
        if let Some(share) = self.even(column, row) {
            return f64::from(share) * (self.block * self.block) as f64;
        }
        let step = self.wide.min(self.block);
        let places = || (0..self.block).step_by(step);
        let nearest = |c: usize, r: usize| self.share(c / self.wide, r / self.wide);
        let share = |c: usize, r: usize| f64::from(nearest(column * self.block + c, row * self.block + r));
        let sum: f64 = places().flat_map(|r| places().map(move |c| share(c, r))).sum();
        sum * (step * step) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For 5 pairs of sides, with squares of 32, 4, 1024, 33 and 300 texels a side, shares that
    /// rise evenly are interpolated to the share at the middle of each fine texel (1e-5), inside of
    /// the square, and the sum over a base texel is that of its texels of the square (1e-9).
    #[test]
    fn shares_are_interpolated() {
        for (base, fine, side) in [(8, 64, 32), (4, 4, 4), (512, 2048, 1024), (33, 66, 33), (300, 600, 300)] {
            let sides = TextureSides { sky_base: base, sky_fine: fine, response: 1 };
            assert_eq!(sky_side(base, fine), side);
            let rise = |x: f64, y: f64| (0.1 + 0.3 * x + 0.5 * y) as f32;
            let middle = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
            let share = |place: usize| rise(middle(place % side, side), middle(place / side, side));
            let veil = CanopyTransmittance::new(&(0..side * side).map(share).collect::<Vec<f32>>(), sides);
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

    /// With a share of 0.25 in one texel of the square and 0.5 in all others, a base texel is even
    /// where all of its fine texels have one share, for each of 4 sides and 9 places of the texel.
    #[test]
    fn even_texels_have_one_share() {
        for (base, fine) in [(8, 64), (16, 32), (16, 16), (32, 512)] {
            let sides = TextureSides { sky_base: base, sky_fine: fine, response: 1 };
            let (side, block) = (sky_side(base, fine), fine / base);
            for odd in 0..9 {
                let odd = (odd / 3) * (side - 1) / 2 * side + (odd % 3) * (side - 1) / 2;
                let share = |texel| if texel == odd { 0.25 } else { 0.5 };
                let veil = CanopyTransmittance::new(&(0..side * side).map(share).collect::<Vec<f32>>(), sides);
                let mut uneven = 0;
                for texel in 0..base * base {
                    let share = |i| veil.at(texel % base, texel / base, i);
                    let same = (0..block * block).all(|i| share(i) == share(0));
                    match veil.even(texel % base, texel / base) {
                        Some(even) => assert!(same && even == share(0), "{base} {fine} {odd} {texel}"),
                        None => uneven += 1,
                    }
                }
                assert!((1..=9).contains(&uneven), "{base} {fine} {odd}: {uneven}");
            }
        }
    }
}
