//! Sky patches: the sky cut into 145, 577 or 2305 parts of constant radiance, and their radiances for a condition.
//!
//! Reinhart's subdivision of Tregenza's sky (Tregenza, "Subdivision of the sky hemisphere for luminance measurements",
//! Lighting Research and Technology 19(1), 1987; Reinhart and Walkenhorst, "Validation of dynamic RADIANCE-based daylight
//! simulations", Energy and Buildings 33(7), 2001): each of Tregenza's seven rows is split MF times in altitude and MF times
//! in azimuth, the zenith cap stays whole. Patches are numbered from the horizon row up, in a row clockwise from
//! north; the first patch of a row is centred on north.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::conditions::Condition;
use super::sky::{Distribution, SkyModel};
use crate::error::Error;

/// Patches of Tregenza's rows, from the horizon up; the cap makes 145.
const TREGENZA: [usize; 7] = [30, 30, 24, 24, 18, 12, 6];

/// Points in which the radiance of a patch is averaged, per side: spacing 1.5 deg or finer.
fn samples_per_side(factor: usize) -> usize {
    (16 / factor).clamp(4, 8)
}

/// Entries of the table of the indicatrix over the chord between a point and the sun. Linear interpolation then errs by
/// (d / 1024)^2 / 2 of the circumsolar term: 3e-5 at Perez' steepest d of about -8.
const CHORDS: usize = 1024;

/// A ring of patches between two altitudes.
#[derive(Clone, Debug)]
struct Band {
    /// Sine of the lower and upper altitude.
    low: f64,
    high: f64,
    /// Patches are `first..first + count`.
    first: usize,
    count: usize,
}

/// A subdivision of the sky.
#[derive(Clone, Debug)]
pub struct Patches {
    /// From the horizon up; the cap is the last.
    bands: Vec<Band>,
    /// Points per side of a patch.
    side: usize,
    /// `[patch][sample altitude][sample azimuth]`: points of equal solid angle within each patch.
    samples: Vec<DVec3>,
    /// Angle from the sun at each entry of the chord table, radians, and its cosine.
    chord_angles: Vec<(f64, f64)>,
}

impl Patches {
    /// 145, 577 or 2305 patches (MF 1, 2, 4).
    pub fn new(count: usize) -> Result<Self, Error> {
        let factor = match count {
            145 => 1,
            577 => 2,
            2305 => 4,
            _ => {
                return Err(Error::Unsupported {
                    what: "number of sky patches".into(),
                    found: count.to_string(),
                    supported: "145, 577 and 2305".into(),
                });
            }
        };
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
        let low = (rows as f64 * row_rad).sin();
        bands.push(Band { low, high: 1.0, first, count: 1 });
        let side = samples_per_side(factor);
        let mut samples = Vec::with_capacity(count * side * side);
        for band in &bands {
            for patch in 0..band.count {
                for j in 0..side {
                    let z = band.sample_z(j, side);
                    let horizontal = (1.0 - z * z).max(0.0).sqrt();
                    for i in 0..side {
                        let inside = (i as f64 + 0.5) / side as f64 - 0.5;
                        let azimuth = TAU * (patch as f64 + inside) / band.count as f64;
                        let (sin, cos) = azimuth.sin_cos();
                        samples.push(DVec3::new(horizontal * sin, horizontal * cos, z));
                    }
                }
            }
        }
        let chord_angles = (0..=CHORDS)
            .map(|k| {
                let half = k as f64 / CHORDS as f64;
                (2.0 * half.min(1.0).asin(), 1.0 - 2.0 * half * half)
            })
            .collect();
        Ok(Patches { bands, side, samples, chord_angles })
    }

    /// Number of patches.
    #[expect(clippy::len_without_is_empty, reason = "a sky has at least 145 patches")]
    pub fn len(&self) -> usize {
        self.bands.iter().map(|b| b.count).sum()
    }

    /// Patch of a unit direction; directions below the horizon count as on it.
    pub fn patch_of(&self, direction: DVec3) -> usize {
        let above = self.bands.partition_point(|b| b.high <= direction.z);
        let Some(band) = self.bands.get(above).or(self.bands.last()) else {
            return 0;
        };
        let turns = (direction.x.atan2(direction.y) / TAU).rem_euclid(1.0);
        let place = (turns * band.count as f64 + 0.5) as usize;
        band.first + if place >= band.count { 0 } else { place }
    }

    /// Unit directions of the patch centres: middle altitude and azimuth, the cap's is the zenith.
    pub fn centres(&self) -> Vec<DVec3> {
        let mut centres = Vec::with_capacity(self.len());
        for band in &self.bands {
            let altitude = 0.5 * (band.low.clamp(0.0, 1.0).asin() + band.high.clamp(0.0, 1.0).asin());
            let (sin_altitude, cos_altitude) = altitude.sin_cos();
            for patch in 0..band.count {
                let (sin, cos) = (TAU * patch as f64 / band.count as f64).sin_cos();
                centres.push(match band.count {
                    1 => DVec3::Z,
                    _ => DVec3::new(cos_altitude * sin, cos_altitude * cos, sin_altitude),
                });
            }
        }
        centres
    }

    /// Exact solid angle of each patch, sr: zone of the sphere over its number of patches.
    pub fn solid_angles_sr(&self) -> Vec<f64> {
        self.bands.iter().flat_map(|b| std::iter::repeat_n(TAU * (b.high - b.low) / b.count as f64, b.count)).collect()
    }

    /// Radiance of each patch, W/m2/sr: the model's mean over the patch, scaled so that the sum of radiance x
    /// `open_horizontal_sr` (the patches' cosine-weighted solid angles as the receivers' coefficients count them, see
    /// [`super::projection`]) is DHI. A model that gives no finite sky is replaced by the uniform one.
    pub fn radiances(&self, model: SkyModel, condition: &Condition, open_horizontal_sr: &[f64]) -> Vec<f64> {
        let count = self.len();
        if condition.dhi_w_m2 <= 0.0 {
            return vec![0.0; count];
        }
        let mut radiances = self.relative(&model.distribution(condition), condition.sky_sun);
        let integral = |values: &[f64]| -> f64 { values.iter().zip(open_horizontal_sr).map(|(l, w)| l * w).sum() };
        let mut sum = integral(&radiances);
        let mut scale = condition.dhi_w_m2 / sum;
        if !(sum.is_finite() && scale.is_finite() && scale > 0.0) {
            radiances.fill(1.0);
            sum = integral(&radiances);
            scale = if sum > 0.0 { condition.dhi_w_m2 / sum } else { 0.0 };
        }
        for radiance in &mut radiances {
            *radiance *= scale;
        }
        radiances
    }

    /// Mean relative radiance of each patch. The gradation depends on the sample's altitude only and the indicatrix on its
    /// distance from the sun only: both are tabulated once per sky, which leaves one square root a sample.
    fn relative(&self, sky: &Distribution, sun: DVec3) -> Vec<f64> {
        let glow: Vec<f64> = self.chord_angles.iter().map(|&(angle, cos)| sky.indicatrix(angle, cos)).collect();
        // Of chord^2 = 2 - 2 cos gamma; the table runs over chords 0..2.
        let half_table = 0.5 * CHORDS as f64;
        let glow_at = |direction: &DVec3| {
            let chord = (2.0 - 2.0 * direction.dot(sun)).max(0.0).sqrt();
            let at = (chord * half_table).min(CHORDS as f64);
            let below = (at as usize).min(CHORDS - 1);
            match glow.get(below..below + 2) {
                Some([low, high]) => low + (high - low) * (at - below as f64),
                _ => 0.0,
            }
        };
        let per_patch = (self.side * self.side) as f64;
        let mut samples = self.samples.chunks_exact(self.side);
        let mut means = Vec::with_capacity(self.len());
        let mut gradation = vec![0.0; self.side];
        for band in &self.bands {
            for (j, value) in gradation.iter_mut().enumerate() {
                *value = sky.gradation(band.sample_z(j, self.side)) / per_patch;
            }
            for _ in 0..band.count {
                let rows = gradation.iter().zip(samples.by_ref());
                means.push(rows.map(|(g, row)| g * row.iter().map(glow_at).sum::<f64>()).sum());
            }
        }
        means
    }
}

impl Band {
    /// Sine of the altitude of the j-th of `side` sample rings of equal solid angle.
    fn sample_z(&self, j: usize, side: usize) -> f64 {
        self.low + (self.high - self.low) * (j as f64 + 0.5) / side as f64
    }
}

#[cfg(test)]
#[path = "patches_tests.rs"]
mod tests;
