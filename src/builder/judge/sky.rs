//! A sky as the judge sees it: its continuous radiance, tabled far finer than it bends, and its suns. In: a condition, a model. Out: W/m2/sr,
//! points of the sun.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::random::Random;
use heliotile_core::error::{Error, Result};
use heliotile_core::hemisphere::{Frame, cosine_direction_of, texel_direction, texel_of};
use heliotile_core::sky::model::SkyModel;
use heliotile_core::units::SUN_RADIUS_RAD;
use heliotile_core::weather::conditions::Condition;

/// Steps by height and around of the integral that sets a sky's level: 1e-5 of it.
const STEPS: [usize; 2] = [96, 192];

/// Cells to a side of the square that radiances are tabled on: 1.2 degrees, over which no sky bends by more than 1e-3.
const SIDE: usize = 128;

/// The same for the many skies of a sum, over which what is left of the bends is 1e-3, and for the level.
const COARSE_SIDE: usize = 32;
const COARSE_STEPS: [usize; 2] = [24, 48];

/// Conditions of a sum that are added up by one thread.
const AT_ONCE: usize = 64;

/// One condition.
pub struct JudgedSky {
    /// Radiance in the middle of each cell of the sky, W/m2/sr.
    radiances: Vec<f32>,
    /// Normal to the sun, W/m2.
    pub(super) dni_w_m2: f64,
    /// Running sums of the weights of the suns, and frames about them.
    suns: Vec<(f64, Frame)>,
}

impl JudgedSky {
    /// A condition in the axes of the site. An error: a sky with a band at the horizon, which has no radiance.
    pub fn new(condition: &Condition, model: SkyModel) -> Result<Self> {
        check(model)?;
        let radiances = radiances(condition, model, SIDE, STEPS).map(|radiance| radiance as f32).collect();
        let mut sky = JudgedSky { radiances, dni_w_m2: condition.dni_w_m2, suns: Vec::new() };
        sky.add_suns(condition, 0.0, 1.0);
        Ok(sky)
    }

    /// The sum over conditions in the axes of the site, for the hours that each lasts: with it, the judge speaks of kWh/m2. An error: as [`new`](Self::new).
    pub fn sum(conditions: &[Condition], model: SkyModel) -> Result<Self> {
        check(model)?;
        let weight = |condition: &Condition| condition.stamp.map_or(1.0, |stamp| stamp.hours) / 1000.0;
        let added = |some: &[Condition]| {
            let mut sums = vec![0.0; COARSE_SIDE * COARSE_SIDE];
            for condition in some {
                let here = radiances(condition, model, COARSE_SIDE, COARSE_STEPS);
                sums.iter_mut().zip(here).for_each(|(sum, radiance)| *sum += weight(condition) * radiance);
            }
            sums
        };
        // One after the other in the end, so that the sum does not depend on the number of threads.
        let parts: Vec<Vec<f64>> = conditions.par_chunks(AT_ONCE).map(added).collect();
        let mut coarse = vec![0.0; COARSE_SIDE * COARSE_SIDE];
        parts.iter().for_each(|part| coarse.iter_mut().zip(part).for_each(|(sum, part)| *sum += part));
        let scale = SIDE / COARSE_SIDE;
        let of_cell = |cell: usize| coarse[cell / SIDE / scale * COARSE_SIDE + cell % SIDE / scale] as f32;
        let mut sum = JudgedSky { radiances: (0..SIDE * SIDE).map(of_cell).collect(), dni_w_m2: 0.0, suns: Vec::new() };
        for condition in conditions.iter().filter(|condition| !condition.suns.is_empty()) {
            let part = weight(condition) * condition.dni_w_m2;
            sum.add_suns(condition, sum.dni_w_m2, part);
            sum.dni_w_m2 += part;
        }
        Ok(sum)
    }

    /// Lists the suns of a condition behind those whose weights sum to `before`; their own sum to `part`.
    fn add_suns(&mut self, condition: &Condition, before: f64, part: f64) {
        let whole: f64 = condition.suns.iter().map(|instant| instant.weight).sum();
        let mut sum = 0.0;
        for instant in &condition.suns {
            sum += instant.weight;
            self.suns.push((before + part * sum / whole.max(f64::MIN_POSITIVE), Frame::of(instant.sun)));
        }
    }

    /// Radiance at a place of the sky, W/m2/sr.
    pub(super) fn radiance(&self, place: SkyPlace) -> f64 {
        f64::from(self.radiances[place.0])
    }

    /// A point of the sun's disc above the horizon, by numbers for which of the suns and where, and others should that lie below; `None`
    /// without sun.
    pub(super) fn sun(&self, [which, mut across, mut along]: [f64; 3], others: &mut Random) -> Option<DVec3> {
        let total = self.suns.last().map(|sun| sun.0).filter(|total| *total > 0.0 && self.dni_w_m2 > 0.0)?;
        let at = self.suns.partition_point(|sun| sun.0 <= which * total).min(self.suns.len() - 1);
        let frame = &self.suns[at].1;
        loop {
            // Level parts of cosine-distributed directions are points of a disc, all alike.
            let point = cosine_direction_of(DVec2::new(across, along)).truncate() * SUN_RADIUS_RAD;
            let point = frame.to_world(point.extend(1.0)).normalize();
            // Its middle is above, and so is half of it at least.
            if point.z > 0.0 {
                return Some(point);
            }
            [across, along] = others.many();
        }
    }

    /// An open sky, of which a receiver gets its sky view: the cosine-weighted share of its hemisphere that is sky.
    pub fn open() -> Self {
        let level = std::f64::consts::FRAC_1_PI as f32;
        JudgedSky { radiances: vec![level; SIDE * SIDE], dni_w_m2: 0.0, suns: Vec::new() }
    }

    /// The mean of skies: their suns, each for its share of the time.
    pub fn mean(skies: &[JudgedSky]) -> JudgedSky {
        let share = 1.0 / skies.len().max(1) as f64;
        let mut mean = JudgedSky { radiances: vec![0.0; SIDE * SIDE], dni_w_m2: 0.0, suns: Vec::new() };
        let mut sums = vec![0.0_f64; SIDE * SIDE];
        for sky in skies {
            sums.iter_mut().zip(&sky.radiances).for_each(|(sum, radiance)| *sum += share * f64::from(*radiance));
            let whole = sky.suns.last().map_or(0.0, |sun| sun.0);
            if whole > 0.0 {
                let before = mean.dni_w_m2;
                let part = share * sky.dni_w_m2;
                mean.suns.extend(sky.suns.iter().map(|sun| (before + part * sun.0 / whole, sun.1)));
                mean.dni_w_m2 += part;
            }
        }
        mean.radiances.iter_mut().zip(sums).for_each(|(radiance, sum)| *radiance = sum as f32);
        mean
    }
}

/// An error for a sky that has no radiance everywhere.
fn check(model: SkyModel) -> Result<()> {
    if model.brightens() {
        let hint = "judge by perez, uniform or cie:N";
        return Err(Error::argument("sky", "has a band at the horizon that is infinitely narrow", hint));
    }
    Ok(())
}

/// Radiances in the middles of so many cells to a side, W/m2/sr; steps of the integral that sets their level.
fn radiances(
    condition: &Condition,
    model: SkyModel,
    side: usize,
    [rows, columns]: [usize; 2],
) -> impl Iterator<Item = f64> {
    let (distribution, sun) = (model.distribution(condition), condition.sky_sun);
    // Even in the square of the sine of the altitude, so that each point stands for as much of a horizontal receiver's light.
    let at = |i: usize| {
        let z = (((i / columns) as f64 + 0.5) / rows as f64).sqrt();
        let azimuth = TAU * ((i % columns) as f64 + 0.5) / columns as f64;
        distribution.relative_radiance(around(azimuth, z), sun)
    };
    let mean = (0..rows * columns).map(at).sum::<f64>() / (rows * columns) as f64;
    let level = if mean > 0.0 { condition.dhi_w_m2 / (PI * mean) } else { 0.0 };
    let middle = move |cell: usize| texel_direction(cell % side, cell / side, side, DVec2::splat(0.5));
    (0..side * side).map(move |cell| level * distribution.relative_radiance(middle(cell), sun))
}

/// A place of the sky.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkyPlace(usize);

impl SkyPlace {
    /// In a direction; `None` below the horizon.
    pub fn of(direction: DVec3) -> Option<Self> {
        (direction.z > 0.0).then(|| {
            let (column, row) = texel_of(direction, SIDE);
            SkyPlace(row * SIDE + column)
        })
    }
}

/// Unit direction at an azimuth from x, of height z.
fn around(azimuth: f64, z: f64) -> DVec3 {
    (DVec2::from_angle(azimuth) * (1.0 - z * z).max(0.0).sqrt()).extend(z)
}

/// A cosine-distributed direction about an axis.
pub(super) fn cosine(frame: &Frame, [a, b]: [f64; 2]) -> DVec3 {
    frame.to_world(cosine_direction_of(DVec2::new(a, b)))
}
