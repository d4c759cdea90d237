//! Direct light behind canopies. In: suns and skies with each leafage, receivers' sky bits and crossings. Out: sun_direct and
//! sky_direct of those receivers that see the sky through leaves.

use glam::DVec3;

use crate::layers::canopy::{Powers, SKY, sky_side};
use crate::layers::mosaic::{Mosaic, Texel};
use crate::layers::sky::half_texel;
use crate::replay::components::Component::{SkyDirect, SunDirect};
use crate::replay::components::ComponentSet;
use crate::replay::suns::Suns;
use crate::replay::tile::{TextureSides, TileLayers, put};
use crate::replay::values::TileValues;
use crate::sky::patches::Patches;
use crate::sky::projection::Projection;
use crate::sky::skies::{Skies, mean_positive};
use crate::sky::sky::SkyModel;
use crate::weather::bins::Bins;
use crate::weather::conditions::Condition;

/// Weather of each leafage.
pub struct Shaded {
    ways: Vec<Way>,
    sides: TextureSides,
}

/// Suns and skies that shine while leaves let through certain shares.
struct Way {
    powers: Powers,
    suns: Suns,
    skies: Skies,
}

/// Shares of the light that come through to a receiver, on a square over its sky texture.
pub struct Veil {
    /// Row-major.
    shares: Vec<f32>,
    side: usize,
    /// Fine texels to a side of a texel of the square, and of a base texel.
    wide: usize,
    block: usize,
}

impl Veil {
    /// Of shares by texel, for the sides of a sky texture.
    pub fn new(shares: Vec<f32>, sides: TextureSides) -> Self {
        let side = sky_side(sides.sky_base, sides.sky_fine);
        Veil { shares, side, wide: sides.sky_fine / side, block: sides.sky_fine / sides.sky_base }
    }

    /// Share at a fine texel (column, row).
    #[inline]
    pub fn at_fine(&self, (column, row): (usize, usize)) -> f32 {
        self.shares[row / self.wide * self.side + column / self.wide]
    }

    /// Share at fine texel `i` of the base texel (column, row).
    #[inline]
    pub fn at(&self, (column, row): (usize, usize), i: usize) -> f32 {
        self.at_fine((column * self.block + i % self.block, row * self.block + i / self.block))
    }

    /// Sum of the shares at all fine texels of a base texel.
    fn sum(&self, (column, row): (usize, usize)) -> f64 {
        let step = self.wide.min(self.block);
        let places = || (0..self.block).step_by(step);
        let share = |(c, r): (usize, usize)| self.at_fine((column * self.block + c, row * self.block + r));
        let sum: f64 = places().flat_map(|r| places().map(move |c| (c, r))).map(|p| f64::from(share(p))).sum();
        sum * (step * step) as f64
    }
}

impl Shaded {
    /// How conditions add to the results with each leafage; `projection` of the base texels.
    pub fn new(
        conditions: &[Condition],
        leafages: Vec<(Powers, Bins)>,
        (model, components): (SkyModel, ComponentSet),
        patches: &Patches,
        projection: &Projection,
        sides: TextureSides,
    ) -> Self {
        let when = |needed: bool| -> &[Condition] { if needed { conditions } else { &[] } };
        let ways: Vec<&Bins> = leafages.iter().map(|(_, bins)| bins).collect();
        let open_sr = &projection.open_horizontal_sr;
        let skies = Skies::new(when(components.needs(SkyDirect)), &ways, model, patches, open_sr);
        let suns: Vec<Suns> =
            ways.iter().map(|bins| Suns::new(when(components.needs(SunDirect)), bins, sides)).collect();
        let way = |(((powers, _), suns), skies)| Way { powers, suns, skies };
        Shaded { ways: leafages.into_iter().zip(suns).zip(skies).map(way).collect(), sides }
    }

    /// Replaces the direct light of a tile's receivers that see the sky through leaves.
    pub fn replace(&self, tile: &TileLayers, projection: &Projection, out: &mut TileValues) {
        let side = sky_side(self.sides.sky_base, self.sides.sky_fine);
        let through = |(receiver, way): (usize, &Way)| {
            let shares = tile.canopies.get(receiver)?.through(SKY, side * side, &way.powers)?;
            Some(Veil::new(shares, self.sides))
        };
        // Whether anything is crossed does not depend on the transmittances.
        let Some(first) = self.ways.first() else { return };
        let behind: Vec<usize> = (0..tile.canopies.len()).filter(|&r| through((r, first)).is_some()).collect();
        for &receiver in &behind {
            let mut sums = vec![0.0_f64; out.labels()];
            for veil in self.ways.iter().filter_map(|way| Some((way, through((receiver, way))?))) {
                veil.0.suns.direct_behind(tile.normals[receiver], &tile.sky[receiver], &veil.1, &mut sums);
            }
            put(&sums, out.row_mut(SunDirect as usize, receiver));
        }
        let mut sums = vec![0.0_f32; behind.len() * out.labels()];
        for way in self.ways.iter().filter(|way| !way.skies.is_empty()) {
            let mut coefficients = Vec::new();
            for &receiver in &behind {
                let Some(veil) = through((receiver, way)) else { continue };
                let (normal, sky) = (tile.normals[receiver], &tile.sky[receiver]);
                coefficients_behind(projection, normal, sky, &veil, &mut coefficients);
            }
            way.skies.irradiance(&coefficients, |i, bin, v| sums[i * out.labels() + bin] += v);
        }
        for (&receiver, sums) in behind.iter().zip(sums.chunks(out.labels().max(1))) {
            let row = out.row_mut(SkyDirect as usize, receiver);
            row.iter_mut().zip(sums).for_each(|(out, sum)| *out = sum.max(0.0));
        }
    }
}

/// [`crate::sky::skies::sky_coefficients`] behind a veil.
fn coefficients_behind(projection: &Projection, normal: DVec3, sky: &Mosaic, veil: &Veil, out: &mut Vec<f32>) {
    let (base, block) = (projection.side(), sky.block());
    let half = half_texel(base);
    let mut sums = vec![0.0_f64; projection.patches()];
    for texel in 0..base * base {
        let cos = mean_positive(normal.dot(projection.mean_directions[texel]), half);
        let place = (texel % base, texel / base);
        let all = 0..block * block;
        let seen = |bits: &[u64], i: usize| bits[i / 64] >> (i % 64) & 1 == 1;
        let share = |i: usize| f64::from(veil.at(place, i));
        let sum: f64 = match sky.texel(place.0, place.1) {
            _ if cos == 0.0 => continue,
            Texel::Closed => continue,
            Texel::Open => veil.sum(place),
            Texel::Mixed(bits) => all.filter(|&i| seen(bits, i)).map(share).sum(),
        };
        projection.add(texel, cos * sum / (block * block) as f64, &mut sums);
    }
    out.extend(sums.into_iter().map(|sum| (sum * projection.texel_sr()) as f32));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::mix;

    /// For 5 pairs of sides, with squares of 16, 4, 256, 66 and 150 texels a side, the sum over a base texel is that of its fine texels
    /// (1e-9), and a fine texel has the share of the square's texel at the same place.
    #[test]
    fn places() {
        for (base, fine, side) in [(8, 64, 16), (4, 4, 4), (512, 1024, 256), (33, 66, 66), (300, 600, 150)] {
            let sides = TextureSides { sky_base: base, sky_fine: fine, response: 1 };
            assert_eq!(sky_side(base, fine), side);
            let share = |place: usize| (mix(7, place as u64) % 1000) as f32 / 1000.0;
            let veil = Veil::new((0..side * side).map(share).collect(), sides);
            let block = fine / base;
            for texel in (0..base * base).step_by(base * base / 16) {
                let place = (texel % base, texel / base);
                let each = |i: usize| {
                    let (c, r) = (place.0 * block + i % block, place.1 * block + i / block);
                    assert_eq!(veil.at(place, i), share(r * side / fine * side + c * side / fine));
                    f64::from(veil.at(place, i))
                };
                let sum: f64 = (0..block * block).map(each).sum();
                assert!((veil.sum(place) - sum).abs() < 1e-9);
            }
        }
    }
}
