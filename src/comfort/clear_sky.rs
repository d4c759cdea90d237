//! Decrease of a clear sky's longwave radiance towards the zenith. In: the sky that planes see.
//! Out: the share that they miss of the difference between a clear and a black sky.
//!
//! P. Martin and P. Berdahl, "Characteristics of infrared sky radiation in the United States",
//! Solar Energy 33, 1984: the emissivity towards a zenith angle z is 1 - (1 - e) exp(b (1.7 - 1 /
//! cos z)) with b = 0.308, where e is that of the whole sky. Cloud bases are nearly black, so the
//! formula holds for the deficit of any sky beside a black one. A court that sees the zenith only
//! gets less than from an isotropic sky.

use glam::{DVec2, DVec3};

use heliotile_core::hemisphere::{HEMISPHERE_SR, direction_of};
use heliotile_core::layers::sky_bitmap::SkyBitmap;

/// Exponent b.
const EXPONENT: f64 = 0.308;

/// Cosine of the zenith angle below which the sky is taken as at that angle.
const MIN_COSINE: f64 = 0.01;

/// Texels of a sky, with the deficit of a clear sky beside a black one in their directions.
pub struct ClearSky {
    side: usize,
    /// `[texel]`: direction of its middle, times deficit x solid angle / pi, scaled so that the
    /// horizontal plane that sees all texels gets 1.
    lacking: Vec<DVec3>,
}

impl ClearSky {
    /// Returns the deficits of skies with `side` base texels a side.
    pub fn new(side: usize) -> Self {
        let texel_sr = HEMISPHERE_SR / (side * side) as f64;
        let of_texel = |texel: usize| {
            let place = DVec2::new((texel % side) as f64 + 0.5, (texel / side) as f64 + 0.5) / side as f64;
            let direction = direction_of(place);
            let lacks = (-EXPONENT / direction.z.max(MIN_COSINE)).exp();
            direction * lacks * texel_sr
        };
        let mut lacking: Vec<DVec3> = (0..side * side).map(of_texel).collect();
        let open: f64 = lacking.iter().map(|texel| texel.z).sum();
        lacking.iter_mut().for_each(|texel| *texel /= open.max(f64::MIN_POSITIVE));
        ClearSky { side, lacking }
    }

    /// Returns the number of base texels a side.
    pub fn side(&self) -> usize {
        self.side
    }

    /// Returns the deficit of the sky that a plane sees, beside a black one, as a share of the
    /// deficit of the open horizontal plane.
    pub fn missed(&self, normal: DVec3, sky: &SkyBitmap) -> f64 {
        let mut sum = 0.0;
        sky.for_visible(|texel, share| {
            let lacking = self.lacking.get(texel).copied().unwrap_or_default();
            sum += share * normal.dot(lacking).max(0.0);
        });
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::layers::bits::BitSquare;

    fn sky(side: usize, is_open: impl Fn(DVec3) -> bool) -> SkyBitmap {
        let mut bits = BitSquare::new(side);
        for texel in 0..side * side {
            let place = DVec2::new((texel % side) as f64 + 0.5, (texel / side) as f64 + 0.5) / side as f64;
            if is_open(direction_of(place)) {
                bits.set(texel % side, texel / side, true);
            }
        }
        SkyBitmap::new(&bits, side)
    }

    /// The deficit of the open horizontal plane is 1, and that of a wall before an open horizon
    /// 0.345, less than the half of the sky that it sees, because the zenith has the largest
    /// deficit. The cone above a sine of the altitude of 0.75 is 0.4375 of the horizontal's sky and
    /// has 0.5194 of the deficit (the two numbers by the trapezoid rule with 2 million points in
    /// numpy).
    #[test]
    fn the_deficit_is_largest_at_the_zenith() {
        let clear = ClearSky::new(128);
        let open = sky(128, |_| true);
        assert!((clear.missed(DVec3::Z, &open) - 1.0).abs() < 1e-12);
        assert!((clear.missed(DVec3::X, &open) - 0.345).abs() < 2e-3, "{}", clear.missed(DVec3::X, &open));
        let cone = sky(128, |direction| direction.z > 0.75);
        assert!((clear.missed(DVec3::Z, &cone) - 0.5194).abs() < 1e-3, "{}", clear.missed(DVec3::Z, &cone));
        assert_eq!(clear.missed(DVec3::NEG_Z, &open), 0.0);
    }
}
