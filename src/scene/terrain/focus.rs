//! Focus: the box from which a horizon is seen. In: the box of all other geometry in plan. Out:
//! distances from it, and the lowering of far ground by the Earth's curvature.

use glam::DVec2;

/// Margin of the focus around other geometry, metres: receivers in gardens see full resolution at
/// their feet.
const MARGIN_M: f64 = 50.0;

/// Mean radius of the Earth, metres (IUGG 1980, R1 rounded).
const EARTH_RADIUS_M: f64 = 6_371_000.0;
/// Share of the curvature that refraction compensates: Gauss' mean value for light near the ground
/// (Torge and Mueller 2012, Geodesy, section 5.1), the usual one of viewshed programs.
const REFRACTION: f64 = 0.13;

/// A box in plan from which terrain is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Focus {
    low: DVec2,
    high: DVec2,
}

impl Focus {
    /// Returns the focus of geometry between two corners.
    pub(crate) fn around(low: DVec2, high: DVec2) -> Focus {
        Focus { low: low - MARGIN_M, high: high + MARGIN_M }
    }

    /// Returns the focus grown by `by` on all sides.
    pub(super) fn grown(&self, by: DVec2) -> Focus {
        Focus { low: self.low - by, high: self.high + by }
    }

    /// Returns the square of a place's distance from the box; 0 inside.
    #[inline]
    pub(super) fn distance_squared(&self, place: DVec2) -> f64 {
        (self.low - place).max(place - self.high).max(DVec2::ZERO).length_squared()
    }

    /// Returns the distance of the farthest place of a box.
    pub(super) fn reach(&self, low: DVec2, high: DVec2) -> f64 {
        let away = (self.low - low).max(high - self.high).max(DVec2::ZERO);
        away.length()
    }
}

/// Returns the apparent depth of the ground below a horizontal plane at a distance, metres: (1 - k)
/// d^2 / 2R.
pub(super) fn curvature_drop(distance_squared: f64) -> f64 {
    (1.0 - REFRACTION) * distance_squared / (2.0 * EARTH_RADIUS_M)
}

/// Returns the words of a note about [`curvature_drop`].
pub(super) fn curvature_words() -> String {
    format!("lowered by the Earth's curvature, refraction {REFRACTION}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The focus is 50 m wider than the geometry in it; 20 km away the ground is 27.3 m lower, and
    /// within the box 0 m.
    #[test]
    fn the_ground_is_lowered_only_beyond_the_focus() {
        let focus = Focus::around(DVec2::ZERO, DVec2::new(10.0, 20.0));
        assert_eq!(focus.distance_squared(DVec2::new(60.0, -50.0)), 0.0);
        assert_eq!(focus.distance_squared(DVec2::new(63.0, -54.0)), 25.0);
        assert_eq!(focus.reach(DVec2::new(-53.0, 0.0), DVec2::new(10.0, 74.0)), 5.0);
        assert!((curvature_drop(20_000.0_f64.powi(2)) - 27.31).abs() < 0.01);
        assert_eq!(curvature_drop(0.0), 0.0);
    }
}
