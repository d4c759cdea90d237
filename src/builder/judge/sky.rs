//! A sky as the judge sees it: its radiance in any direction, and its suns. In: a condition, a model. Out: W/m2/sr, points of the sun.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::random::Random;
use heliotile_core::error::{Error, Result};
use heliotile_core::hemisphere::Frame;
use heliotile_core::sky::distribution::Distribution;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::units::SUN_RADIUS_RAD;
use heliotile_core::weather::conditions::Condition;

/// Steps by height and around of the integral that sets a sky's level: 1e-5 of it.
const STEPS: [usize; 2] = [96, 192];

/// One condition.
pub struct JudgedSky {
    distribution: Distribution,
    sun: DVec3,
    /// W/m2/sr at relative radiance 1.
    level: f64,
    /// Normal to the sun, W/m2.
    pub(super) dni_w_m2: f64,
    /// Running sums of the weights of the suns, and frames about them.
    suns: Vec<(f64, Frame)>,
}

impl JudgedSky {
    /// A condition in the axes of the site. An error: a sky with a band at the horizon, which has no radiance.
    pub fn new(condition: &Condition, model: SkyModel) -> Result<Self> {
        if model.brightens() {
            let hint = "judge by perez, uniform or cie:N";
            return Err(Error::argument("--sky", "has a band at the horizon that is infinitely narrow", hint));
        }
        let (distribution, sun) = (model.distribution(condition), condition.sky_sun);
        let [rows, columns] = STEPS;
        // Even in the square of the sine of the altitude, so that each point stands for as much of a horizontal receiver's light.
        let at = |i: usize| {
            let z = (((i / columns) as f64 + 0.5) / rows as f64).sqrt();
            let azimuth = TAU * ((i % columns) as f64 + 0.5) / columns as f64;
            distribution.relative_radiance(around(azimuth, z), sun)
        };
        let mean = (0..rows * columns).map(at).sum::<f64>() / (rows * columns) as f64;
        let level = if mean > 0.0 { condition.dhi_w_m2 / (PI * mean) } else { 0.0 };
        let mut sum = 0.0;
        let suns = condition.suns.iter().map(|instant| {
            sum += instant.weight;
            (sum, Frame::of(instant.sun))
        });
        Ok(JudgedSky { distribution, sun, level, dni_w_m2: condition.dni_w_m2, suns: suns.collect() })
    }

    /// Radiance in a direction above the horizon, W/m2/sr.
    pub(super) fn radiance(&self, direction: DVec3) -> f64 {
        self.level * self.distribution.relative_radiance(direction, self.sun)
    }

    /// A point of the sun's disc above the horizon, by numbers for which of the suns and where, and others should that lie below; `None`
    /// without sun.
    pub(super) fn sun(&self, [which, mut radius, mut angle]: [f64; 3], others: &mut Random) -> Option<DVec3> {
        let total = self.suns.last().map(|sun| sun.0).filter(|total| *total > 0.0 && self.dni_w_m2 > 0.0)?;
        let at = self.suns.partition_point(|sun| sun.0 <= which * total).min(self.suns.len() - 1);
        let frame = &self.suns[at].1;
        loop {
            let offset = DVec2::from_angle(TAU * angle) * (SUN_RADIUS_RAD * radius.sqrt());
            let point = frame.to_world(offset.extend(1.0)).normalize();
            // Its middle is above, and so is half of it at least.
            if point.z > 0.0 {
                return Some(point);
            }
            [radius, angle] = others.many();
        }
    }
}

/// Unit direction at an azimuth from x, of height z.
fn around(azimuth: f64, z: f64) -> DVec3 {
    (DVec2::from_angle(azimuth) * (1.0 - z * z).max(0.0).sqrt()).extend(z)
}

/// A cosine-distributed direction about an axis (Malley 1988).
pub(super) fn cosine(frame: &Frame, [a, b]: [f64; 2]) -> DVec3 {
    frame.to_world((DVec2::from_angle(TAU * b) * a.sqrt()).extend((1.0 - a).max(0.0).sqrt()))
}
