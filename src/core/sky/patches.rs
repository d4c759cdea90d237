//! Sky patches: the sky cut into 145, 577 or 2305 parts of constant radiance, and their radiances
//! for a condition.
//!
//! Reinhart's subdivision of Tregenza's sky (Tregenza, "Subdivision of the sky hemisphere for
//! luminance measurements", Lighting Research and Technology 19(1), 1987; Reinhart and Walkenhorst,
//! "Validation of dynamic RADIANCE-based daylight simulations", Energy and Buildings 33(7), 2001).
//! Each of Tregenza's seven rows is split MF times in altitude and MF times in azimuth; the zenith
//! cap stays whole. Patches are numbered from the horizon row up and, within a row, clockwise from
//! north. The first patch of a row is centred on north.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::dome::grid::{Band, PatchGrid};
use crate::error::Error;
use crate::sky::distribution::Distribution;
use crate::sky::model::SkyModel;
use crate::weather::conditions::Condition;

/// Returns the number of points per side over which the radiance of a patch is averaged: spacing
/// 1.5 deg or finer.
fn samples_per_side(factor: usize) -> usize {
    (16 / factor).clamp(4, 8)
}

/// Returns the number of two-point Gauss rules per side of a patch far from the sun, where radiance
/// is smooth.
fn rules_per_side(factor: usize) -> usize {
    (2 / factor).max(1)
}

/// Angle from the sun to the centre of a patch, radians, below which the radiance is averaged over
/// all points of the patch. A patch that holds the sun always lies within it, also one of 12
/// degrees of Tregenza's own sky.
const NEAR_RAD: f64 = 0.35;

/// Offset of the points of the two-point Gauss rule from the middle of an interval, in its lengths.
const GAUSS: f64 = 0.288_675_134_594_812_9;

/// Number of steps of the table of the indicatrix over the chord between a point and the sun.
/// Linear interpolation then errs by (d / 1024)^2 / 2 of the circumsolar term: 3e-5 at Perez'
/// steepest d of about -8.
const CHORDS: usize = 1024;

/// A subdivision of the sky.
#[derive(Clone, Debug)]
pub struct Patches {
    grid: PatchGrid,
    /// Points per side of a patch.
    side: usize,
    /// `[patch][sample altitude][sample azimuth]`: points of equal solid angle within each patch.
    samples: Vec<DVec3>,
    /// Number of Gauss rules per side of a patch.
    rules: usize,
    /// `[patch][altitude][azimuth]`: points of the Gauss rules.
    far: Vec<DVec3>,
    centres: Vec<DVec3>,
    /// Angle from the sun at each entry of the chord table, radians, and its cosine.
    chord_angles: Vec<(f64, f64)>,
}

impl Patches {
    /// Returns a sky of 145, 577 or 2305 patches (MF 1, 2, 4); other numbers are an error.
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
        let grid = PatchGrid::of_factor(factor);
        let (side, rules) = (samples_per_side(factor), rules_per_side(factor));
        let even: Vec<f64> = (0..side).map(|j| (j as f64 + 0.5) / side as f64).collect();
        let middles = (0..rules).map(|j| (j as f64 + 0.5) / rules as f64);
        let gauss: Vec<f64> = middles.flat_map(|m| [m - GAUSS / rules as f64, m + GAUSS / rules as f64]).collect();
        let (samples, far) = (points(grid.bands(), &even), points(grid.bands(), &gauss));
        let chord_angles = (0..=CHORDS)
            .map(|k| {
                let half = k as f64 / CHORDS as f64;
                // A chord is 2 sin(gamma / 2), and cos gamma is 1 - 2 sin^2(gamma / 2).
                (2.0 * half.min(1.0).asin(), 1.0 - 2.0 * half * half)
            })
            .collect();
        let centres = centres(grid.bands());
        Ok(Patches { grid, side, samples, rules, far, centres, chord_angles })
    }

    /// Returns the number of patches.
    #[expect(clippy::len_without_is_empty, reason = "a sky has at least 145 patches")]
    pub fn len(&self) -> usize {
        self.grid.len()
    }

    /// Returns the patch of a unit direction; directions below the horizon count as on it.
    pub fn patch_of(&self, direction: DVec3) -> usize {
        self.grid.patch_of(direction)
    }

    /// Returns the patch at an azimuth, turns clockwise from north in 0..=1, and the sine of an
    /// altitude.
    pub fn patch_at(&self, turns: f64, z: f64) -> usize {
        self.grid.patch_at(turns, z)
    }

    /// Returns the unit directions of the patch centres: middle altitude and azimuth; the zenith
    /// for the cap.
    pub fn centres(&self) -> &[DVec3] {
        &self.centres
    }

    /// Returns the exact solid angle of each patch, sr: zone of the sphere over its number of
    /// patches.
    pub fn solid_angles_sr(&self) -> Vec<f64> {
        self.grid.solid_angles_sr()
    }

    /// Returns the radiance of each patch, W/m2/sr: the model's mean over the patch, scaled so that
    /// the sum of radiance x `open_horizontal_sr` is the dome's share of DHI ([`SkyModel::parts`]).
    /// `open_horizontal_sr` are the patches' cosine-weighted solid angles as the receivers'
    /// coefficients count them, see [`crate::sky::projection`]. A uniform sky replaces a model's
    /// sky that is not finite.
    ///
    /// A sky from a file ([`Condition::own_sky`]) replaces the model's. It is resampled to these
    /// patches and scaled to the dome's share of DHI, too. Clouds ([`Condition::clouds`]) then dim
    /// each patch by their mean over it.
    pub fn radiances(&self, model: SkyModel, condition: &Condition, open_horizontal_sr: &[f64]) -> Vec<f64> {
        let count = self.len();
        if condition.dhi_w_m2 <= 0.0 {
            return vec![0.0; count];
        }
        let dome_w_m2 = model.parts(condition).dome_w_m2;
        let mut radiances = match &condition.own_sky {
            Some(own) => own.on(&self.grid),
            None => self.relative(&model.distribution(condition), condition.sky_sun),
        };
        let integral = |values: &[f64]| -> f64 { values.iter().zip(open_horizontal_sr).map(|(l, w)| l * w).sum() };
        let mut sum = integral(&radiances);
        let mut scale = dome_w_m2 / sum;
        // A model without light, or one that overflows, still has to give DHI.
        if !(sum.is_finite() && scale.is_finite() && scale > 0.0) {
            radiances.fill(1.0);
            sum = integral(&radiances);
            scale = if sum > 0.0 { dome_w_m2 / sum } else { 0.0 };
        }
        for radiance in &mut radiances {
            *radiance *= scale;
        }
        if let Some(clouds) = &condition.clouds {
            radiances.iter_mut().zip(clouds.on(&self.grid)).for_each(|(radiance, through)| *radiance *= through);
        }
        radiances
    }

    /// Returns the mean relative radiance of each patch. The gradation depends on the sample's
    /// altitude only and the indicatrix on its distance from the sun only. Tables of both, made
    /// once per sky, leave one square root a sample.
    ///
    /// Away from the sun the indicatrix is smooth, and few points suffice: Gauss rules with two
    /// rings of points. Their weights are exact for the gradation, averaged over many rings, times
    /// a linear function of the height.
    fn relative(&self, sky: &Distribution, sun: DVec3) -> Vec<f64> {
        let glow: Vec<f64> = self.chord_angles.iter().map(|&(angle, cos)| sky.indicatrix(angle, cos)).collect();
        // chord^2 = 2 - 2 cos gamma; the table runs over chords 0..2.
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
        let near_cos = NEAR_RAD.cos();
        let per_patch = (self.side * self.side) as f64;
        let points = 2 * self.rules;
        let mut samples = self.samples.chunks_exact(self.side * self.side);
        let mut far = self.far.chunks_exact(points * points);
        let mut centres = self.centres.iter();
        let mut means = Vec::with_capacity(self.len());
        let mut gradation = vec![0.0; self.side];
        for band in self.grid.bands() {
            for (j, value) in gradation.iter_mut().enumerate() {
                *value = sky.gradation(band.sample_z(j, self.side)) / per_patch;
            }
            let rings = band.ring_weights(self.rules, |z| sky.gradation(z));
            let patches = samples.by_ref().zip(far.by_ref()).zip(centres.by_ref()).take(band.count);
            means.extend(patches.map(|((samples, far), centre)| {
                // A Gauss rule with two azimuths does not cover the cap, which goes all round.
                if centre.dot(sun) > near_cos || band.count == 1 {
                    let rows = gradation.iter().zip(samples.chunks_exact(self.side));
                    rows.map(|(g, row)| g * row.iter().map(glow_at).sum::<f64>()).sum()
                } else {
                    let rows = rings.iter().zip(far.chunks_exact(points));
                    rows.map(|(w, row)| w * row.iter().map(glow_at).sum::<f64>()).sum::<f64>() / points as f64
                }
            }));
        }
        means
    }
}

/// Returns the points of each patch, `[patch][altitude][azimuth]`. `shares` place them: shares of
/// the patch's solid angle from its lower edge, and of its width.
fn points(bands: &[Band], shares: &[f64]) -> Vec<DVec3> {
    let mut found = Vec::new();
    for band in bands {
        for patch in 0..band.count {
            for altitude in shares {
                let z = band.low + (band.high - band.low) * altitude;
                let horizontal = (1.0 - z * z).max(0.0).sqrt();
                for inside in shares {
                    let (sin, cos) = (TAU * (patch as f64 + inside - 0.5) / band.count as f64).sin_cos();
                    found.push(DVec3::new(horizontal * sin, horizontal * cos, z));
                }
            }
        }
    }
    found
}

/// Returns the middle altitude and azimuth of each patch; the zenith for the cap.
fn centres(bands: &[Band]) -> Vec<DVec3> {
    let of_band = |band: &Band| -> Vec<DVec3> {
        let altitude = 0.5 * (band.low.clamp(0.0, 1.0).asin() + band.high.clamp(0.0, 1.0).asin());
        let (sin_altitude, cos_altitude) = altitude.sin_cos();
        let centre = |patch| {
            let (sin, cos) = (TAU * patch as f64 / band.count as f64).sin_cos();
            DVec3::new(cos_altitude * sin, cos_altitude * cos, sin_altitude)
        };
        if band.count == 1 { vec![DVec3::Z] } else { (0..band.count).map(centre).collect() }
    };
    bands.iter().flat_map(of_band).collect()
}

impl Band {
    /// Returns the sine of the altitude of the j-th of `side` sample rings of equal solid angle.
    fn sample_z(&self, j: usize, side: usize) -> f64 {
        self.low + (self.high - self.low) * (j as f64 + 0.5) / side as f64
    }

    /// Returns the weights of the rings of Gauss points. The weights of each pair of rings keep the
    /// mean of `gradation` over their part of the band, and the mean of `gradation` times the
    /// height above the part's middle. The sum of all weights is the band's mean.
    fn ring_weights(&self, rules: usize, gradation: impl Fn(f64) -> f64) -> Vec<f64> {
        const RINGS: usize = 8;
        let height = (self.high - self.low) / rules as f64;
        let pair = |rule: usize| {
            let (mut mean, mut moment) = (0.0, 0.0);
            for ring in 0..RINGS {
                let above = (ring as f64 + 0.5) / RINGS as f64 - 0.5;
                let value = gradation(self.low + height * (rule as f64 + 0.5 + above)) / RINGS as f64;
                mean += value;
                moment += value * above;
            }
            // The two weights solve w1 + w2 = mean and GAUSS (w2 - w1) = moment.
            [0.5 * mean - moment / (2.0 * GAUSS), 0.5 * mean + moment / (2.0 * GAUSS)].map(|w| w / rules as f64)
        };
        (0..rules).flat_map(pair).collect()
    }
}

#[cfg(test)]
#[path = "patches_tests.rs"]
mod tests;
