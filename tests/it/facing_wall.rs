//! Facing wall, a scene whose answer is known. In: its size and distance. Out: its form factor from
//! a point in front of it.

use std::f64::consts::PI;

use glam::DVec2;

/// Rectangle at y = `distance_m`, its centre at x = z = 0. Receivers lie at y = 0 and look along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Width along x, metres.
    pub width_m: f64,
    /// Height along z, metres.
    pub height_m: f64,
    /// Distance between receivers and wall along y, metres; above 0.
    pub distance_m: f64,
}

impl Wall {
    /// Returns the form factor from an element at (x, 0, z), `at` = (x, z), metres. It is the sum
    /// of four rectangles with a corner opposite to the element; their signs take care of elements
    /// beside the wall. Differential element to parallel rectangle: Siegel and Howell, "Thermal
    /// Radiation Heat Transfer", configuration factors, any distance above 0.
    pub fn form_factor(&self, at: DVec2) -> f64 {
        let (left, right) = (self.width_m / 2.0 + at.x, self.width_m / 2.0 - at.x);
        let (down, up) = (self.height_m / 2.0 + at.y, self.height_m / 2.0 - at.y);
        let quarter =
            |width_m: f64, height_m: f64| corner_form_factor(width_m / self.distance_m, height_m / self.distance_m);
        quarter(left, down) + quarter(left, up) + quarter(right, down) + quarter(right, up)
    }
}

/// Returns the form factor of a rectangle from an element opposite to its corner. Sides are in
/// units of the distance; the result is odd in both.
fn corner_form_factor(x: f64, y: f64) -> f64 {
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / p * (y / p).atan() + y / q * (x / q).atan()) / (2.0 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(distance_m: f64) -> Wall {
        Wall { width_m: 10.0, height_m: 10.0, distance_m }
    }

    /// A wall that touches the receiver fills its view (1 within 1e-3 at 1 mm); one at 50 m has
    /// area / (pi d^2) within 1.5 %.
    #[test]
    fn a_wall_that_touches_fills_the_view() {
        assert!((wall(0.001).form_factor(DVec2::ZERO) - 1.0).abs() < 1e-3);
        let far = 100.0 / (PI * 2500.0);
        assert!((wall(50.0).form_factor(DVec2::ZERO) / far - 1.0).abs() < 0.015);
    }

    /// Two halves sum to the whole within 1e-12, from 3 places in front of the wall and beside it.
    #[test]
    fn two_halves_of_a_wall_sum_to_the_whole() {
        for at in [DVec2::ZERO, DVec2::new(2.0, -3.5), DVec2::new(30.0, 7.0)] {
            let half = Wall { width_m: 5.0, ..wall(4.0) };
            let parts = [-2.5, 2.5].map(|x| half.form_factor(at - DVec2::new(x, 0.0)));
            assert!((parts[0] + parts[1] - wall(4.0).form_factor(at)).abs() < 1e-12, "{at}");
        }
    }
}
