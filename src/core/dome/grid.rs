//! Subdivisions of the sky. In: a factor, or a number of patches. Out: the patches' borders and
//! solid angles, and resampling from one subdivision to another.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::DVec3;

/// Numbers of patches in Tregenza's rows, from the horizon up; with the cap there are 145.
const TREGENZA: [usize; 7] = [30, 30, 24, 24, 18, 12, 6];

/// A ring of patches between two altitudes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Band {
    /// Sine of the lower altitude.
    pub low: f64,
    /// Sine of the upper altitude.
    pub high: f64,
    /// Number of the first patch; patches are `first..first + count`.
    pub first: usize,
    /// Number of patches.
    pub count: usize,
}

impl Band {
    fn places(&self) -> Range<usize> {
        self.first..self.first + self.count
    }

    /// Returns the solid angle of one of its patches, sr: zone of the sphere over the number of
    /// patches.
    fn solid_angle_sr(&self) -> f64 {
        TAU * (self.high - self.low) / self.count as f64
    }

    /// Returns solid angle x mean cosine on a horizontal surface of one of its patches, sr.
    fn horizontal_sr(&self) -> f64 {
        PI * (self.high * self.high - self.low * self.low) / self.count as f64
    }

    /// Returns the share of its zone that lies in the zone of another band.
    fn share_in(&self, other: &Band) -> f64 {
        ((self.high.min(other.high) - self.low.max(other.low)) / (self.high - self.low)).max(0.0)
    }

    /// Returns the mean of the values of its patches over a part of its circle; `from` and `width`
    /// in turns clockwise from north.
    fn mean(&self, numbers: &[f32], from: f64, width: f64) -> f64 {
        let count = self.count as f64;
        // The first patch is centred on north.
        let (start, end) = (from * count + 0.5, (from + width) * count + 0.5);
        let (mut at, mut sum) = (start, 0.0);
        while at < end {
            let next = (at.floor() + 1.0).min(end);
            let patch = at.floor().rem_euclid(count) as usize;
            sum += (next - at) * numbers.get(patch).map_or(0.0, |number| f64::from(*number));
            at = next;
        }
        sum / (width * count)
    }
}

/// A subdivision of the sky: Tregenza's, or Reinhart's refinement, which splits each of the seven
/// rows by a factor in altitude and in azimuth. [`crate::sky::patches`] names the sources and the
/// order of patches.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchGrid {
    /// Bands from the horizon up; the cap is the last.
    bands: Vec<Band>,
}

impl PatchGrid {
    /// Factors of the subdivisions that skies and files have: 145, 577 and 2305 patches.
    pub const FACTORS: [usize; 3] = [1, 2, 4];

    /// Returns the subdivision with each row split `factor` times: 144 x factor^2 + 1 patches.
    pub fn of_factor(factor: usize) -> Self {
        let factor = factor.max(1);
        let rows = TREGENZA.len() * factor;
        // The cap has half a row's height.
        let row_rad = 0.5 * PI / (rows as f64 + 0.5);
        let mut bands = Vec::with_capacity(rows + 1);
        let mut first = 0;
        let per_row = TREGENZA.iter().flat_map(|n| std::iter::repeat_n(n * factor, factor));
        for (row, count) in per_row.enumerate() {
            bands.push(Band {
                low: (row as f64 * row_rad).sin(),
                high: ((row + 1) as f64 * row_rad).sin(),
                first,
                count,
            });
            first += count;
        }
        bands.push(Band { low: (rows as f64 * row_rad).sin(), high: 1.0, first, count: 1 });
        PatchGrid { bands }
    }

    /// Returns the subdivision of 145, 577 or 2305 patches.
    pub fn of_count(count: usize) -> Option<Self> {
        let factor = Self::FACTORS.into_iter().find(|factor| 144 * factor * factor + 1 == count)?;
        Some(PatchGrid::of_factor(factor))
    }

    pub(crate) fn bands(&self) -> &[Band] {
        &self.bands
    }

    /// Returns the number of patches.
    #[expect(clippy::len_without_is_empty, reason = "a sky has at least 145 patches")]
    pub fn len(&self) -> usize {
        self.bands.last().map_or(0, |cap| cap.first + cap.count)
    }

    /// Returns the patch of a unit direction; a direction below the horizon counts as on it.
    pub fn patch_of(&self, direction: DVec3) -> usize {
        self.patch_at((direction.x.atan2(direction.y) / TAU).rem_euclid(1.0), direction.z)
    }

    /// Returns the patch at an azimuth, turns clockwise from north in 0..=1, and the sine of an
    /// altitude.
    pub fn patch_at(&self, turns: f64, z: f64) -> usize {
        self.patch_in(self.row_at(z), turns).unwrap_or_default()
    }

    /// Returns the row of patches, from the horizon up, at the sine of an altitude.
    pub(crate) fn row_at(&self, z: f64) -> usize {
        let above = self.bands.iter().take_while(|b| b.high <= z).count();
        above.min(self.bands.len().saturating_sub(1))
    }

    /// Returns the patch of a row at an azimuth, turns clockwise from north in 0..=1.
    pub(crate) fn patch_in(&self, row: usize, turns: f64) -> Option<usize> {
        let band = self.bands.get(row)?;
        let place = (turns * band.count as f64 + 0.5) as usize;
        // The first patch is centred on north, so the last half patch before north belongs to it.
        Some(band.first + if place >= band.count { 0 } else { place })
    }

    /// Returns the exact solid angle of each patch, sr.
    pub fn solid_angles_sr(&self) -> Vec<f64> {
        self.bands.iter().flat_map(|b| std::iter::repeat_n(b.solid_angle_sr(), b.count)).collect()
    }

    /// Returns the irradiance of an open horizontal surface, W/m2, under radiances of the patches,
    /// W/m2/sr: the exact integral.
    pub fn horizontal_w_m2(&self, radiances: &[f32]) -> f64 {
        let of_band = |b: &Band| {
            let ring = radiances.get(b.places()).unwrap_or_default();
            b.horizontal_sr() * ring.iter().map(|l| f64::from(*l)).sum::<f64>()
        };
        self.bands.iter().map(of_band).sum()
    }

    /// Returns the values on another subdivision, whose north lies `turns` clockwise of north here:
    /// means by solid angle over the overlap of the patches. Patches of the same borders keep their
    /// values to the bit.
    pub fn resampled(&self, numbers: &[f32], to: &PatchGrid, turns: f64) -> Vec<f64> {
        if self == to && turns == 0.0 {
            return numbers.iter().map(|number| f64::from(*number)).collect();
        }
        let mut means = vec![0.0; to.len()];
        for target in &to.bands {
            let width = 1.0 / target.count as f64;
            for source in &self.bands {
                let share = target.share_in(source);
                let (Some(ring), Some(out)) = (numbers.get(source.places()), means.get_mut(target.places())) else {
                    continue;
                };
                if share > 0.0 {
                    for (patch, out) in out.iter_mut().enumerate() {
                        *out += share * source.mean(ring, (patch as f64 - 0.5) * width + turns, width);
                    }
                }
            }
        }
        means
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means of 145, 577 and 2305 patches on each other keep the integral over solid angle (1e-12),
    /// and values that are all 1 stay 1 (1e-12). On their own subdivision values stay unchanged.
    /// The integral with the cosine moves by at most 1 % where patches are halved.
    #[test]
    fn resampling_keeps_the_integral() {
        for from in [1, 2, 4].map(PatchGrid::of_factor) {
            let numbers: Vec<f32> = (0..from.len()).map(|i| (i * 7 % 13) as f32).collect();
            let integral = |grid: &PatchGrid, numbers: &[f64]| -> f64 {
                grid.solid_angles_sr().iter().zip(numbers).map(|(sr, l)| sr * l).sum()
            };
            let exact = integral(&from, &numbers.iter().map(|l| f64::from(*l)).collect::<Vec<_>>());
            for to in [1, 2, 4, 8].map(PatchGrid::of_factor) {
                for turns in [0.0, 0.01, -0.3] {
                    let means = from.resampled(&numbers, &to, turns);
                    assert!((integral(&to, &means) / exact - 1.0).abs() < 1e-12);
                    let ones = from.resampled(&vec![1.0; from.len()], &to, turns);
                    assert!(ones.iter().all(|one| (one - 1.0).abs() < 1e-12));
                    let narrow: Vec<f32> = means.iter().map(|l| *l as f32).collect();
                    let moved = to.horizontal_w_m2(&narrow) / from.horizontal_w_m2(&numbers) - 1.0;
                    assert!(moved.abs() < 0.01, "{moved}");
                }
            }
            let same = from.resampled(&numbers, &from, 0.0);
            assert!(same.iter().zip(&numbers).all(|(a, b)| *a == f64::from(*b)));
        }
    }

    /// A value in the east (patch 15 of 60) lies in the north of axes that are turned by a quarter,
    /// whose north is the east.
    #[test]
    fn turns_are_clockwise() {
        let grid = PatchGrid::of_factor(2);
        let mut numbers = vec![0.0_f32; grid.len()];
        numbers[15] = 1.0;
        let seen = grid.resampled(&numbers, &grid, 15.0 / 60.0);
        assert!((seen[0] - 1.0).abs() < 1e-9, "{}", seen[0]);
        let east = grid.patch_of(DVec3::new(1.0, 0.0, 0.02));
        assert_eq!(east, 15);
    }

    /// 145, 577 and 2305 patches are known by their number, 146 and 1297 are not. The horizontal
    /// integral of radiance 1 is pi (1e-12).
    #[test]
    fn only_145_577_and_2305_patches_are_known() {
        for count in [145, 577, 2305] {
            let grid = PatchGrid::of_count(count).expect("known");
            assert_eq!(grid.len(), count);
            assert!((grid.horizontal_w_m2(&vec![1.0; count]) - PI).abs() < 1e-12);
        }
        assert!(PatchGrid::of_count(146).is_none() && PatchGrid::of_count(1297).is_none());
    }
}
