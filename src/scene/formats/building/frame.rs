//! In: the corners of a flat surface. Out: its area vector, and its own axes.

use glam::DVec3;

/// Horizontal part of a unit normal below which a surface is level; its edges decide its azimuth.
const LEVEL: f64 = 1e-9;

/// Axes and size of a rectangle or polygon; windows, overhangs and fins are placed by them.
#[derive(Clone, Copy, Debug)]
pub(in crate::formats) struct Frame {
    /// Lower left corner.
    pub origin: DVec3,
    /// Azimuth of the outward normal, degrees clockwise from north; of a level surface, the azimuth
    /// that its lower edge gives.
    pub azimuth_deg: f64,
    pub tilt_deg: f64,
    pub width: f64,
    pub height: f64,
}

impl Frame {
    /// Returns the unit vector along the surface, to the right as seen from outside.
    pub(in crate::formats) fn right(&self) -> DVec3 {
        let (sin, cos) = self.azimuth_deg.to_radians().sin_cos();
        DVec3::new(-cos, sin, 0.0)
    }

    /// Returns the unit vector along the surface, upwards.
    pub(in crate::formats) fn up(&self) -> DVec3 {
        let (sin, cos) = self.azimuth_deg.to_radians().sin_cos();
        let (sin_tilt, cos_tilt) = self.tilt_deg.to_radians().sin_cos();
        DVec3::new(-cos_tilt * sin, -cos_tilt * cos, sin_tilt)
    }

    /// Returns the four corners, upper left first. A negative width goes to the left.
    pub(in crate::formats) fn corners(&self) -> Vec<DVec3> {
        let (right, up) = (self.width * self.right(), self.height * self.up());
        vec![self.origin + up, self.origin, self.origin + right, self.origin + right + up]
    }

    /// Returns the frame of a polygon whose first corner is the upper left one.
    pub(in crate::formats) fn new(vertices: &[DVec3]) -> Option<Frame> {
        let &[first, second, third, ..] = vertices else { return None };
        let normal = area_vector(vertices).normalize_or_zero();
        let level = normal.x.hypot(normal.y) <= LEVEL;
        let right = if level { third - second } else { DVec3::Z.cross(normal) };
        Some(Frame {
            origin: second,
            azimuth_deg: right.y.atan2(-right.x).to_degrees(),
            tilt_deg: normal.z.clamp(-1.0, 1.0).acos().to_degrees(),
            width: (third - second).length(),
            height: (second - first).length(),
        })
    }
}

/// Returns the area of a polygon times its normal (Newell).
pub(in crate::formats) fn area_vector(vertices: &[DVec3]) -> DVec3 {
    let Some(&first) = vertices.first() else { return DVec3::ZERO };
    let after = vertices.iter().skip(1).chain([&first]);
    vertices.iter().zip(after).map(|(a, b)| 0.5 * (*a - first).cross(*b - first)).sum()
}
