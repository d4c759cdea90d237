//! True north in a site's coordinates. In: the place of the site. Out: directions turned between
//! true north, which suns refer to, and the y axis, which geometry refers to.

use glam::DVec3;

use crate::site::place::Place;
use crate::units::tilt_and_azimuth;

/// Direction of a site's y axis clockwise from true north, as seen from above. Zero where no place
/// is known: y is then taken for north.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct North {
    y_deg: f64,
}

impl North {
    /// Returns the north of a place; y is north without one.
    pub fn new(place: Option<&Place>) -> North {
        North { y_deg: place.map_or(0.0, |place| place.convergence_deg) }
    }

    /// Returns the direction of y clockwise from true north, degrees.
    pub fn y_deg(self) -> f64 {
        self.y_deg
    }

    /// Returns true if y is true north: directions then stay as they are, to the bit.
    pub fn is_y(self) -> bool {
        self.y_deg == 0.0
    }

    /// Returns a direction given by true east, true north and up, in the site's axes.
    pub fn to_axes(self, direction: DVec3) -> DVec3 {
        // The axes lie clockwise of true north, so directions turn counterclockwise.
        self.turned(direction, self.y_deg)
    }

    /// Returns a direction given in the site's axes, by true east, true north and up.
    pub fn to_true(self, direction: DVec3) -> DVec3 {
        self.turned(direction, -self.y_deg)
    }

    /// Returns the azimuth of a direction in the site's axes, degrees clockwise from true north,
    /// 0..360; 0 for a vertical one.
    pub fn azimuth_deg(self, direction: DVec3) -> f64 {
        tilt_and_azimuth(self.to_true(direction)).1
    }

    fn turned(self, direction: DVec3, counterclockwise_deg: f64) -> DVec3 {
        if self.is_y() {
            return direction;
        }
        let (sin, cos) = counterclockwise_deg.to_radians().sin_cos();
        let DVec3 { x, y, z } = direction;
        DVec3::new(x * cos - y * sin, x * sin + y * cos, z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::direction_from_degrees;

    fn north(convergence_deg: f64) -> North {
        North::new(Some(&Place { latitude_deg: 50.0, longitude_deg: 9.0, convergence_deg, epsg: None }))
    }

    /// With y 30 degrees clockwise of north (a building's north axis of 30), the sun in the south
    /// (180) stands at 150 from y, and back. A normal along x has azimuth 120. Height and length
    /// stay, to 1e-15.
    #[test]
    fn turned_axes_move_the_sun_and_normals() {
        let sun = direction_from_degrees(180.0, 40.0);
        let seen = north(30.0).to_axes(sun);
        assert!((seen - direction_from_degrees(150.0, 40.0)).length() < 1e-15, "{seen}");
        assert!((north(30.0).to_true(seen) - sun).length() < 1e-15);
        assert!((north(30.0).azimuth_deg(DVec3::X) - 120.0).abs() < 1e-12);
        assert!((north(-2.0).azimuth_deg(DVec3::Y) - 358.0).abs() < 1e-12);
        assert_eq!(north(0.0).to_axes(sun), sun);
        assert_eq!(North::new(None).azimuth_deg(DVec3::NEG_X), 270.0);
    }
}
