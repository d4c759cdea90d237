//! Views of a site on a page. In: points in scene coordinates. Out: points of the page, and their
//! depth towards the viewer.

use glam::{DVec2, DVec3};

use heliotile_core::site::north::North;
use heliotile_core::units::direction_from_degrees;

/// Altitude of the viewer of the second picture, degrees.
pub const ALTITUDE_DEG: f64 = 40.0;

/// Orthographic view: unit vectors in scene coordinates to the right and up on the page, and
/// towards the viewer.
#[derive(Clone, Copy, Debug)]
pub struct View {
    right: DVec3,
    up: DVec3,
    pub towards: DVec3,
}

impl View {
    /// Returns the view from above, true north up.
    pub fn above(north: North) -> Self {
        View { right: north.to_axes(DVec3::X), up: north.to_axes(DVec3::Y), towards: DVec3::Z }
    }

    /// Returns the view from the south-west.
    pub fn south_west(north: North) -> Self {
        let towards = north.to_axes(direction_from_degrees(225.0, ALTITUDE_DEG));
        let right = north.to_axes(direction_from_degrees(135.0, 0.0));
        View { right, up: towards.cross(right), towards }
    }

    /// Returns metres to the right and up, and towards the viewer.
    pub fn of(&self, point: DVec3) -> DVec3 {
        DVec3::new(point.dot(self.right), point.dot(self.up), point.dot(self.towards))
    }
}

/// Panel: a view on a part of the page.
#[derive(Clone, Copy, Debug)]
pub struct Panel {
    pub view: View,
    /// Lowest metres to the right and up that the panel shows.
    pub low: DVec2,
    /// Width and height of the panel in metres.
    pub size_m: DVec2,
    /// Scale, points a metre.
    pub scale: f64,
    /// Top left corner on the page, points.
    pub corner: DVec2,
}

impl Panel {
    /// Returns points of the page, x to the right and y down, and metres towards the viewer.
    pub fn place(&self, point: DVec3) -> DVec3 {
        let at = self.view.of(point);
        let x = self.corner.x + (at.x - self.low.x) * self.scale;
        let y = self.corner.y + (self.low.y + self.size_m.y - at.y) * self.scale;
        DVec3::new(x, y, at.z)
    }

    /// Returns width and height in whole points.
    pub fn whole_size(&self) -> [usize; 2] {
        (self.size_m * self.scale).to_array().map(|side| side.ceil().max(1.0) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From above, east is right and north is up. From the south-west, 40 degrees high, west walls
    /// face left and half towards the viewer, north walls away, and roofs towards the viewer by
    /// 0.643. Axes turned by 30 degrees still have true north up: 8 of 8 within 1e-9.
    #[test]
    fn from_above_east_is_right_and_north_is_up() {
        let [above, oblique] = [View::above, View::south_west].map(|view| view(North::default()));
        let near = |a: DVec3, b: [f64; 3]| assert!((a - DVec3::from_array(b)).length() < 1e-9, "{a}, not {b:?}");
        near(above.of(DVec3::new(3.0, 5.0, 7.0)), [3.0, 5.0, 7.0]);
        let half = 0.5_f64.sqrt();
        let (sin, cos) = 40_f64.to_radians().sin_cos();
        near(oblique.of(-DVec3::X), [-half, -half * sin, half * cos]);
        near(oblique.of(DVec3::Y), [-half, half * sin, -half * cos]);
        near(oblique.of(DVec3::Z), [0.0, cos, sin]);
        let turned = crate::outputs::shapes::picture::tests::turned(30.0);
        near(View::above(turned).of(turned.to_axes(DVec3::Y)), [0.0, 1.0, 0.0]);
        near(View::south_west(turned).of(turned.to_axes(-DVec3::X)), [-half, -half * sin, half * cos]);
        let panel = Panel {
            view: above,
            low: DVec2::new(100.0, 50.0),
            size_m: DVec2::new(20.0, 10.0),
            scale: 4.0,
            corner: DVec2::new(7.0, 9.0),
        };
        near(panel.place(DVec3::new(100.0, 60.0, 1.0)), [7.0, 9.0, 1.0]);
        near(panel.place(DVec3::new(120.0, 50.0, 1.0)), [87.0, 49.0, 1.0]);
    }
}
