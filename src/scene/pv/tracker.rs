//! Single-axis trackers with level axes: angles by the sun, modules turned about their axis. In:
//! the direction of the axes, limits, the sun. Out: angles, turned modules.
//!
//! Angles are those of pvlib's `tracking.singleaxis`: 0 is level, positive is clockwise as seen
//! along `axis_azimuth`, so with axes to the south negative angles face east.

use glam::DVec3;

use super::layout::Module;
use heliotile_core::orientation::fan::Orientation;
use heliotile_core::site::north::North;

/// Trackers of some rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracker {
    /// Direction of the axes, degrees clockwise from true north.
    pub axis_deg: f64,
    /// Height of the axes above the surface below, metres.
    pub hub_m: f64,
    /// Largest angle from level, degrees.
    pub max_deg: f64,
    /// True if rows turn back so far that they do not shade each other.
    pub backtracks: bool,
    /// Largest difference of neighbouring angles that are traced, degrees.
    pub step_deg: f64,
}

impl Tracker {
    /// Returns the angle for a unit vector towards the sun, by true east, true north and up,
    /// degrees; `cover` is the height of modules over the pitch.
    ///
    /// Source: Anderson and Mikofski, "Slope-aware backtracking for single-axis trackers",
    /// NREL/TP-5K00-76626 (2020), for level axes on level ground.
    pub fn angle_deg(&self, sun: DVec3, cover: f64) -> f64 {
        let (sin, cos) = self.axis_deg.to_radians().sin_cos();
        // The sun across the axis: 0 above it.
        let ideal = (sun.x * cos - sun.y * sin).atan2(sun.z);
        // The share of a row that light between two rows covers is this one.
        let gap = (ideal.cos() / cover).abs();
        let back = if self.backtracks && gap < 1.0 { gap.acos() } else { 0.0 };
        (ideal - ideal.signum() * back).to_degrees().clamp(-self.max_deg, self.max_deg)
    }

    /// Returns the angles that are traced, degrees, evenly from the one end to the other; level is
    /// among them.
    pub fn angles_deg(&self) -> Vec<f64> {
        let side = (self.max_deg / self.step_deg - 1e-9).ceil().max(1.0);
        (0..=2 * side as usize).map(|i| (i as f64 - side) * self.max_deg / side).collect()
    }

    /// Returns the orientation of fronts at an angle.
    pub fn turn(&self, angle_deg: f64) -> Orientation {
        let faces_deg = self.axis_deg + if angle_deg < 0.0 { -90.0 } else { 90.0 };
        Orientation { tilt_deg: angle_deg.abs(), azimuth_deg: faces_deg.rem_euclid(360.0) }
    }

    /// Returns the axis and the direction from the lower edge of a level module to the upper one,
    /// at an angle, unit vectors in the scene's axes.
    pub(super) fn axes(&self, angle_deg: f64, north: North) -> [DVec3; 2] {
        let upright = |azimuth_deg| Orientation { tilt_deg: 90.0, azimuth_deg };
        let axis = north.to_axes(upright(self.axis_deg).normal());
        let normal = north.to_axes(self.turn(angle_deg).normal());
        [axis, normal.cross(axis)]
    }

    /// Returns a level module turned to an angle about its middle.
    pub fn turned(&self, module: &Module, angle_deg: f64, north: North) -> Module {
        let [axis, level_up] = self.axes(0.0, north);
        let [_, up] = self.axes(angle_deg, north);
        let middle = module.middle();
        let front = module.front.map(|corner| {
            let off = corner - middle;
            middle + axis * off.dot(axis) + up * off.dot(level_up)
        });
        Module { front, normal: axis.cross(up), ..module.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::units::direction_from_degrees;

    /// Returns a tracker whose axes have a direction.
    fn tracker(axis_deg: f64, max_deg: f64, backtracks: bool) -> Tracker {
        Tracker { axis_deg, hub_m: 1.5, max_deg, backtracks, step_deg: 10.0 }
    }

    /// Ten angles are those of pvlib 0.16.1, `tracking.singleaxis`, to 0.0001 degrees.
    #[test]
    fn angles_are_those_of_pvlib() {
        for (axis, [azimuth, altitude], cover, max, backtracks, expected) in [
            (180.0, [110.0, 30.0], 0.4, 60.0, true, -58.4333),
            (180.0, [100.0, 10.0], 0.4, 60.0, true, -15.9918),
            (180.0, [100.0, 10.0], 0.4, 60.0, false, -60.0000),
            (180.0, [260.0, 5.0], 0.35, 50.0, true, 9.5682),
            (180.0, [170.0, 60.0], 0.4, 60.0, true, -5.7251),
            (0.0, [95.0, 15.0], 0.5, 60.0, true, 16.2428),
            (155.0, [240.0, 20.0], 0.45, 55.0, true, 29.6242),
            (155.0, [240.0, 20.0], 0.45, 80.0, false, 69.9297),
            (200.0, [80.0, 2.0], 0.3, 60.0, true, -5.4091),
            (90.0, [150.0, 25.0], 0.4, 60.0, true, 60.0000),
        ] {
            let sun = direction_from_degrees(azimuth, altitude);
            let found = tracker(axis, max, backtracks).angle_deg(sun, cover);
            assert!((found - expected).abs() < 1e-4, "{axis} {azimuth} {altitude}: {found} {expected}");
        }
    }

    /// Fronts face the side that their angle says, and traced angles are 10 degrees apart or less,
    /// level among them.
    #[test]
    fn fronts_face_the_sun() {
        let south = tracker(180.0, 60.0, true);
        assert_eq!((south.turn(30.0).azimuth_deg, south.turn(-30.0).azimuth_deg), (270.0, 90.0));
        assert_eq!(tracker(0.0, 60.0, true).turn(30.0).azimuth_deg, 90.0);
        assert_eq!((south.angles_deg().len(), south.angles_deg()[6]), (13, 0.0));
        let odd = tracker(180.0, 52.0, true).angles_deg();
        assert!(odd.len() == 13 && (odd[0] + 52.0).abs() < 1e-9 && odd[1] - odd[0] < 10.0, "{odd:?}");
    }
}
