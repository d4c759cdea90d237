//! Sky of the reference path tracer: its continuous radiance, tabulated far finer than it varies,
//! and its suns. In: a condition, a sky model. Out: radiances, W/m2/sr, and points of the sun.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::random::Random;
use heliotile_core::error::{Error, Result};
use heliotile_core::hemisphere::{Frame, cosine_direction_of, texel_direction, texel_of};
use heliotile_core::sky::model::SkyModel;
use heliotile_core::units::SUN_RADIUS_RAD;
use heliotile_core::weather::conditions::Condition;

/// Steps by altitude and azimuth of the integral that sets a sky's level, exact to 1e-5 of it.
const STEPS: [usize; 2] = [96, 192];

/// Cells per side of the square of radiances: 1.2 degrees, over which no sky departs from linear by
/// more than 1e-3.
const SIDE: usize = 128;

/// Cells per side for the many skies of a sum, which leave an error of 1e-3; [`COARSE_STEPS`] are
/// the steps for the level of these skies.
const COARSE_SIDE: usize = 32;
const COARSE_STEPS: [usize; 2] = [24, 48];

/// Number of conditions of a sum that one thread adds up.
const AT_ONCE: usize = 64;

/// Sky and suns of one condition, or of a sum of conditions.
pub struct ReferenceSky {
    /// Radiance in the middle of each cell of the sky, W/m2/sr.
    radiances: Vec<f32>,
    /// Irradiance normal to the sun, W/m2.
    pub(super) dni_w_m2: f64,
    /// Running sums of the weights of the suns, and frames about them.
    suns: Vec<(f64, Frame)>,
}

impl ReferenceSky {
    /// Creates the sky of a condition in the axes of the site. Fails for a sky model with a band at
    /// the horizon, which has no radiance.
    pub fn new(condition: &Condition, model: SkyModel) -> Result<Self> {
        check(model)?;
        let radiances = radiances(condition, model, SIDE, STEPS).map(|radiance| radiance as f32).collect();
        let mut sky = ReferenceSky { radiances, dni_w_m2: condition.dni_w_m2, suns: Vec::new() };
        sky.add_suns(condition, 0.0, 1.0);
        Ok(sky)
    }

    /// Creates the sum over conditions in the axes of the site, weighted by the hours that each
    /// lasts, so that results are in kWh/m2. Fails as [`new`](Self::new) does.
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
        // The parts are added one after the other, so that the sum does not depend on the number of
        // threads.
        let parts: Vec<Vec<f64>> = conditions.par_chunks(AT_ONCE).map(added).collect();
        let mut coarse = vec![0.0; COARSE_SIDE * COARSE_SIDE];
        parts.iter().for_each(|part| coarse.iter_mut().zip(part).for_each(|(sum, part)| *sum += part));
        let scale = SIDE / COARSE_SIDE;
        let of_cell = |cell: usize| coarse[cell / SIDE / scale * COARSE_SIDE + cell % SIDE / scale] as f32;
        let mut sum =
            ReferenceSky { radiances: (0..SIDE * SIDE).map(of_cell).collect(), dni_w_m2: 0.0, suns: Vec::new() };
        for condition in conditions.iter().filter(|condition| !condition.suns.is_empty()) {
            let part = weight(condition) * condition.dni_w_m2;
            sum.add_suns(condition, sum.dni_w_m2, part);
            sum.dni_w_m2 += part;
        }
        Ok(sum)
    }

    /// Adds the suns of a condition after those whose weights sum to `before`; their own weights
    /// sum to `part`.
    fn add_suns(&mut self, condition: &Condition, before: f64, part: f64) {
        let whole: f64 = condition.suns.iter().map(|instant| instant.weight).sum();
        let mut sum = 0.0;
        for instant in &condition.suns {
            sum += instant.weight;
            self.suns.push((before + part * sum / whole.max(f64::MIN_POSITIVE), Frame::new(instant.sun)));
        }
    }

    /// Returns the radiance at a place of the sky, W/m2/sr.
    pub(super) fn radiance(&self, place: SkyPlace) -> f64 {
        f64::from(self.radiances[place.0])
    }

    /// Returns a random point of the sun's disc above the horizon; `None` without sun. The first
    /// numbers choose one of the suns and the point, `others` are drawn if that point is below the
    /// horizon.
    pub(super) fn sun(&self, [which, mut across, mut along]: [f64; 3], others: &mut Random) -> Option<DVec3> {
        let total = self.suns.last().map(|sun| sun.0).filter(|total| *total > 0.0 && self.dni_w_m2 > 0.0)?;
        let at = self.suns.partition_point(|sun| sun.0 <= which * total).min(self.suns.len() - 1);
        let frame = &self.suns[at].1;
        loop {
            // Cosine-weighted directions, projected to the disc, are uniform on it.
            let point = cosine_direction_of(DVec2::new(across, along)).truncate() * SUN_RADIUS_RAD;
            let point = frame.to_world(point.extend(1.0)).normalize();
            // The centre of the sun is above the horizon, and so is at least half of the disc.
            if point.z > 0.0 {
                return Some(point);
            }
            [across, along] = others.many();
        }
    }

    /// Creates an open sky, under which the irradiance of a receiver is its sky view: the
    /// cosine-weighted share of its hemisphere that is sky.
    pub fn open() -> Self {
        let level = std::f64::consts::FRAC_1_PI as f32;
        ReferenceSky { radiances: vec![level; SIDE * SIDE], dni_w_m2: 0.0, suns: Vec::new() }
    }

    /// Returns the mean of skies. Each sun counts for its share of the time.
    pub fn mean(skies: &[ReferenceSky]) -> ReferenceSky {
        let share = 1.0 / skies.len().max(1) as f64;
        let mut mean = ReferenceSky { radiances: vec![0.0; SIDE * SIDE], dni_w_m2: 0.0, suns: Vec::new() };
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

/// Refuses a sky model that has no radiance everywhere.
fn check(model: SkyModel) -> Result<()> {
    if model.brightens() {
        let hint = "give perez, uniform or cie:N";
        return Err(Error::argument(
            "sky",
            "has an infinitely narrow bright band at the horizon, which the reference path tracer cannot sample",
            hint,
        ));
    }
    Ok(())
}

/// Returns the radiances in the middles of `side` x `side` cells, W/m2/sr. The last argument gives
/// the steps of the integral that sets their level.
fn radiances(
    condition: &Condition,
    model: SkyModel,
    side: usize,
    [rows, columns]: [usize; 2],
) -> impl Iterator<Item = f64> {
    let (distribution, sun) = (model.distribution(condition), condition.sky_sun);
    // Even in the square of the sine of the altitude, so that each point stands for an equal part
    // of a horizontal receiver's light.
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

/// Place of the sky: one cell of its radiances.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkyPlace(usize);

impl SkyPlace {
    /// Returns the place in a direction; `None` below the horizon.
    pub fn new(direction: DVec3) -> Option<Self> {
        (direction.z > 0.0).then(|| {
            let (column, row) = texel_of(direction, SIDE);
            SkyPlace(row * SIDE + column)
        })
    }
}

/// Returns the unit direction at an azimuth from x and a height z.
fn around(azimuth: f64, z: f64) -> DVec3 {
    (DVec2::from_angle(azimuth) * (1.0 - z * z).max(0.0).sqrt()).extend(z)
}

/// Returns a cosine-weighted direction about an axis.
pub(super) fn cosine(frame: &Frame, [a, b]: [f64; 2]) -> DVec3 {
    frame.to_world(cosine_direction_of(DVec2::new(a, b)))
}
