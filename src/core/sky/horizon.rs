//! The band at the horizon in Perez' model of tilted surfaces. In: the side of a sky texture. Out:
//! weights of the band's texels for receivers and for responses.
//!
//! The visibility of the band is taken from the lowest 6.5 degrees (its height in Perez, Seals,
//! Ineichen, Stewart and Menicucci, "A new simplified version of the Perez diffuse irradiance model
//! for tilted surfaces", Solar Energy 39(3), 1987). Its light comes from the horizon itself:
//! directions are flattened. So an open receiver gets light by the sine of its tilt, as in the
//! paper of 1990.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::hemisphere::{azimuth_and_z, direction_of, texel_direction};
use crate::layers::sky::half_texel;

/// Sine of 6.5 degrees, the band's height.
const TOP: f64 = 0.113_203_213_767_907;

/// A texel that the band covers, wholly or in part.
#[derive(Clone, Copy, Debug)]
pub struct BandTexel {
    /// Number of the texel, row-major.
    pub texel: usize,
    /// Direction of the texel's middle.
    pub direction: DVec3,
    /// Sum of the horizontal unit directions over the texel's part of the band. Its product with a
    /// wall's normal is the irradiance of the wall.
    pub flat: DVec2,
}

/// Texels of the band. The sum of their [`BandTexel::flat`] gives an open wall an irradiance of 1.
#[derive(Clone, Debug)]
pub struct HorizonBand {
    texels: Vec<BandTexel>,
    /// Half the width of a texel, as a change of cosines.
    half: f64,
}

impl HorizonBand {
    /// Returns the band of an n x n texture.
    pub fn new(n: usize) -> Self {
        let samples = (2048 / n.max(1)).clamp(2, 32);
        let of_row = |row: usize| -> Vec<BandTexel> {
            let texel = |column: usize| {
                let inside = |i: usize| (i as f64 + 0.5) / samples as f64;
                let points = (0..samples * samples).map(|i| DVec2::new(inside(i % samples), inside(i / samples)));
                let square = points.map(|inside| (DVec2::new(column as f64, row as f64) + inside) / n as f64);
                let low = square.filter(|square| azimuth_and_z(*square).1 < TOP).map(direction_of);
                let flat: DVec2 = low.map(|d| DVec2::new(d.x, d.y).normalize_or_zero()).sum();
                let direction = texel_direction(column, row, n, DVec2::splat(0.5));
                BandTexel { texel: row * n + column, direction, flat }
            };
            // The map keeps heights on squares, so the band lies near the edge.
            let near = |column: &usize| {
                let to_edge = |place: usize| place.min(n - 1 - place) as f64 / n as f64;
                // The band's upper end lies at (1 - sqrt(1 - TOP)) / 2 = 0.029 of the side from the
                // edge.
                to_edge(*column).min(to_edge(row)) < 0.04
            };
            (0..n).filter(near).map(texel).filter(|found| found.flat != DVec2::ZERO).collect()
        };
        let mut texels: Vec<BandTexel> = (0..n).into_par_iter().flat_map_iter(of_row).collect();
        // A wall of any azimuth gets the mean of |flat| max(cos, 0), which is |flat| / pi.
        let open = texels.iter().map(|found| found.flat.length()).sum::<f64>() / PI;
        texels.iter_mut().for_each(|found| found.flat /= open.max(f64::MIN_POSITIVE));
        HorizonBand { texels, half: half_texel(n) }
    }

    /// Returns the texels of the band, row by row.
    pub fn texels(&self) -> &[BandTexel] {
        &self.texels
    }

    /// Iterates over the texels of the band in front of a receiver with this normal, with their
    /// weights. The weights sum to the sine of its tilt. An overhanging surface sees only a part of
    /// the band; this part counts for all of it.
    pub fn weights(&self, normal: DVec3) -> impl Iterator<Item = (usize, f64)> {
        let weight = |found: &BandTexel| {
            // Not fused, which takes WebAssembly long; half of a number is exact.
            let front = (normal.dot(found.direction) / self.half * 0.5 + 0.5).clamp(0.0, 1.0);
            (found.texel, normal.truncate().dot(found.flat).max(0.0) * front)
        };
        let weights: Vec<(usize, f64)> = self.texels.iter().map(weight).collect();
        let all: f64 = weights.iter().map(|(_, weight)| weight).sum();
        let scale = if all > 0.0 { normal.truncate().length() / all } else { 0.0 };
        weights.into_iter().filter(|(_, weight)| *weight > 0.0).map(move |(texel, weight)| (texel, weight * scale))
    }

    /// Returns the irradiance of a receiver from a band that gives an open wall 1; `share` is the
    /// visible share of a texel.
    pub fn seen(&self, normal: DVec3, share: impl Fn(usize) -> f64) -> f64 {
        self.weights(normal).map(|(texel, weight)| weight * share(texel)).sum()
    }

    /// Returns the irradiance by reflection; `response` is `[texel][axis]`. For a roof of less than
    /// 6.5 degrees, the part of the band behind it counts against the part in front of it.
    pub fn reflected(&self, response: &[[f32; 3]]) -> f64 {
        let of = |found: &BandTexel| {
            response.get(found.texel).map_or(0.0, |g| found.flat.dot(DVec2::new(f64::from(g[0]), f64::from(g[1]))))
        };
        self.texels.iter().map(of).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::direction_from_degrees;

    /// Open receivers of 13 tilts and 12 azimuths, overhanging ones too, get the sine of the tilt
    /// (1e-12) on textures of 16, 128 and 512 texels a side. A response that is a wall's normal
    /// where the wall sees the sky gives 1 within 2 %, 0.2 % and 0.01 %.
    #[test]
    fn open_receivers_get_the_sine_of_the_tilt() {
        for (n, most) in [(16, 2e-2), (128, 2e-3), (512, 1e-4)] {
            let band = HorizonBand::new(n);
            for azimuth in (0..12).map(|i| f64::from(i) * 31.0) {
                for tilt in (0..13).map(|i| f64::from(i) * 14.5) {
                    let normal = direction_from_degrees(azimuth, 90.0 - tilt);
                    let sum: f64 = band.weights(normal).map(|(_, weight)| weight).sum();
                    assert!((sum - tilt.to_radians().sin()).abs() < 1e-12, "{n} {azimuth} {tilt}: {sum}");
                    assert_eq!(band.seen(normal, |_| 0.5), 0.5 * sum);
                }
                let wall = direction_from_degrees(azimuth, 0.0);
                let faces = |t| wall.dot(texel_direction(t % n, t / n, n, DVec2::splat(0.5))) > 0.0;
                let vector = |t| if faces(t) { wall.as_vec3().to_array() } else { [0.0; 3] };
                let reflected = band.reflected(&(0..n * n).map(vector).collect::<Vec<_>>());
                assert!((reflected - 1.0).abs() < most, "{n} {azimuth}: {reflected}");
            }
        }
    }

    /// The band is sin 6.5 deg of the hemisphere: its share of 512 x 512 texels is that within 3 %.
    /// Behind a skyline of that height none of it is visible.
    #[test]
    fn the_horizon_band_has_its_share_of_texels() {
        assert!((TOP - 6.5_f64.to_radians().sin()).abs() < 1e-14);
        let n = 512;
        let band = HorizonBand::new(n);
        let share = band.texels().len() as f64 / (n * n) as f64;
        assert!((share / TOP - 1.0).abs() < 0.03, "{share}");
        let above = |t: usize| {
            f64::from(u8::from(
                azimuth_and_z(DVec2::new((t % n) as f64 + 0.5, (t / n) as f64 + 0.5) / n as f64).1 > 0.12,
            ))
        };
        assert_eq!(band.seen(DVec3::X, above), 0.0);
    }
}
