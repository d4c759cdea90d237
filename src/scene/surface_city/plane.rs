//! Planes through heights. In: places in plan with their heights, one after the other. Out: the
//! plane of least squares and the distances of the heights from it.

use std::ops::{Add, AddAssign};

use glam::DVec2;

/// Steepest slope of a roof, as a tangent (76 degrees): cells do not show the slope of steeper
/// ones.
const STEEPEST: f64 = 4.0;

/// A plane over the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    /// Place of a point of the plane.
    pub middle: DVec2,
    /// Height at that place, metres.
    pub height: f64,
    /// Rise a metre eastwards and northwards.
    pub slope: DVec2,
}

impl Plane {
    /// Returns the height of the plane at a place.
    #[inline]
    pub(super) fn at(&self, place: DVec2) -> f64 {
        self.height + self.slope.dot(place - self.middle)
    }

    /// Returns the cosine of the angle between two planes.
    pub(super) fn cosine(&self, other: &Plane) -> f64 {
        let normal = |plane: &Plane| (-plane.slope).extend(1.0).normalize();
        normal(self).dot(normal(other))
    }
}

/// Sums of places and heights, relative to an origin nearby.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pub count: f64,
    place: DVec2,
    height: f64,
    xx: f64,
    xy: f64,
    yy: f64,
    /// Sum of place times height.
    rise: DVec2,
    square: f64,
}

impl Sums {
    /// Adds a height at a place.
    pub(super) fn push(&mut self, place: DVec2, height: f64) {
        *self += Sums {
            count: 1.0,
            place,
            height,
            xx: place.x * place.x,
            xy: place.x * place.y,
            yy: place.y * place.y,
            rise: place * height,
            square: height * height,
        };
    }

    /// Returns the mean squares of places about their middle, and the mean product with heights.
    fn moments(&self, middle: DVec2, height: f64) -> ([f64; 3], DVec2) {
        let count = self.count.max(1.0);
        let (xx, yy) = (self.xx / count - middle.x * middle.x, self.yy / count - middle.y * middle.y);
        ([xx, yy, self.xy / count - middle.x * middle.y], self.rise / count - middle * height)
    }

    /// Returns the plane of least squares; a level plane if the places lie on a line or the slope
    /// would be too steep.
    pub(super) fn plane(&self) -> Plane {
        let count = self.count.max(1.0);
        let (middle, height) = (self.place / count, self.height / count);
        let ([xx, yy, xy], rise) = self.moments(middle, height);
        let turn = xx * yy - xy * xy;
        let slope = DVec2::new(rise.x * yy - rise.y * xy, rise.y * xx - rise.x * xy) / turn;
        // `turn` is the product of the variances along the two main axes. It is small beside their
        // sum squared where the places lie on a line, which tells nothing of the slope across.
        let is_one = self.count >= 4.0 && turn > 1e-3 * (xx + yy) * (xx + yy) && slope.length() <= STEEPEST;
        Plane { middle, height, slope: if is_one { slope } else { DVec2::ZERO } }
    }

    /// Returns the root mean square of the vertical distances of the heights from a plane.
    pub(super) fn rms(&self, plane: &Plane) -> f64 {
        // Mean of (h - H - s.(p - m))^2 about the mean place and height, both of which the plane
        // goes through.
        let count = self.count.max(1.0);
        let (middle, height) = (plane.middle, plane.height);
        let ([xx, yy, xy], rise) = self.moments(middle, height);
        let s = plane.slope;
        let square = self.square / count - height * height - 2.0 * s.dot(rise)
            + s.x * s.x * xx
            + 2.0 * s.x * s.y * xy
            + s.y * s.y * yy;
        square.max(0.0).sqrt()
    }
}

impl Add for Sums {
    type Output = Sums;

    fn add(mut self, other: Sums) -> Sums {
        self += other;
        self
    }
}

impl AddAssign for Sums {
    fn add_assign(&mut self, other: Sums) {
        self.count += other.count;
        self.place += other.place;
        self.height += other.height;
        self.xx += other.xx;
        self.xy += other.xy;
        self.yy += other.yy;
        self.rise += other.rise;
        self.square += other.square;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From 25 heights on a plane that rises 0.5 m a metre eastwards and falls 0.25 northwards the
    /// plane comes back within 1e-9, with heights 0 m off. With every other height 0.1 m higher and
    /// the rest 0.1 m lower, the heights are 0.1 m off within 0.2 %.
    #[test]
    fn a_plane_is_found_from_its_heights() {
        for noise in [0.0, 0.1] {
            let mut sums = Sums::default();
            for i in 0..25 {
                let place = DVec2::new(f64::from(i % 5), f64::from(i / 5));
                let off = if i % 2 == 0 { noise } else { -noise };
                sums.push(place, 7.0 + 0.5 * place.x - 0.25 * place.y + off);
            }
            let plane = sums.plane();
            assert!((plane.slope - DVec2::new(0.5, -0.25)).length() < 1e-9, "{plane:?}");
            assert!((sums.rms(&plane) - noise).abs() < 2e-3 * noise.max(1e-6), "{}", sums.rms(&plane));
        }
    }

    /// Places on one line, and a rise of 9 m a metre, make a level plane at their mean of 5 m.
    #[test]
    fn places_on_one_line_give_a_level_plane() {
        for steep in [false, true] {
            let mut sums = Sums::default();
            for i in 0..9 {
                let (x, y) = (f64::from(i % 3), f64::from(i / 3));
                let place = if steep { DVec2::new(x, y) } else { DVec2::new(x, x) };
                sums.push(place, 5.0 + 9.0 * (x - 1.0));
            }
            let plane = sums.plane();
            assert_eq!((plane.slope, plane.height), (DVec2::ZERO, 5.0));
        }
    }
}
