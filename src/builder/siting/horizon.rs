//! Horizon of a point. In: a point. Out: the altitude of the scene in the directions around it.

use glam::DVec3;
use rayon::prelude::*;

use super::Siting;
use crate::trace::Ray;
use heliotile_core::units::direction_from_degrees;

/// Step of the altitudes at which the lowest sky is looked for, degrees. Narrower gaps may be
/// missed.
const SCAN_DEG: f64 = 0.25;

/// Width to which the edge of the sky is then bisected, degrees.
const EDGE_DEG: f64 = 1e-3;

/// Altitudes of a horizon.
#[derive(Clone, Debug, PartialEq)]
pub struct HorizonLine {
    /// Degrees above the level, `[azimuth]` at equal distances, clockwise from the first one; 0
    /// where nothing stands higher.
    pub altitudes_deg: Vec<f64>,
}

impl Siting<'_> {
    /// Returns the horizon of a point (input coordinates) in `count` directions, the first of them
    /// `first_deg` clockwise from y. Each altitude is that of the lowest visible sky, or 90 degrees
    /// if none is visible. What hides sky above that, such as a balcony overhead, is not part of
    /// the horizon.
    pub fn horizon(&self, point: DVec3, count: usize, first_deg: f64) -> HorizonLine {
        let tracer = &self.prepared.tracer;
        let origin = tracer.grid().lifted(point, DVec3::Z);
        let ray = |azimuth_deg: f64, altitude_deg: f64| Ray {
            origin,
            direction: direction_from_degrees(azimuth_deg, altitude_deg).as_vec3().to_array(),
        };
        let scan: Vec<f64> = (0..=(90.0 / SCAN_DEG) as usize).map(|i| i as f64 * SCAN_DEG).collect();
        let of = |i: usize| {
            let azimuth_deg = first_deg + 360.0 * i as f64 / count as f64;
            let rays: Vec<Ray> = scan.iter().map(|altitude| ray(azimuth_deg, *altitude)).collect();
            let met = tracer.occluded_many(&rays);
            let Some(free) = met.iter().position(|met| !met) else { return 90.0 };
            let Some(mut low) = free.checked_sub(1).map(|last| scan[last]) else { return 0.0 };
            let mut high = scan[free];
            while high - low > EDGE_DEG {
                let middle = 0.5 * (low + high);
                let side = if tracer.occluded(ray(azimuth_deg, middle)) { &mut low } else { &mut high };
                *side = middle;
            }
            let altitude = 0.5 * (low + high);
            // A plane that goes on for 20 km ends a little below the level.
            if altitude < EDGE_DEG { 0.0 } else { altitude }
        };
        HorizonLine { altitudes_deg: (0..count).into_par_iter().map(of).collect() }
    }
}
