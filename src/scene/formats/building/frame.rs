//! In: the corners of a flat surface. Out: its area, its normal and axes of its own.

use glam::DVec3;

/// Normals this close to the vertical are of a level surface, whose azimuth its edges decide.
const LEVEL: f64 = 1e-9;

/// A rectangle's or a polygon's own axes: what windows, overhangs and fins are placed by.
#[derive(Clone, Copy, Debug)]
pub(in crate::formats) struct Frame {
    /// Lower left corner.
    pub origin: DVec3,
    /// Of the outward normal, degrees clockwise from north; of level surfaces that of their lower edge.
    pub azimuth_deg: f64,
    pub tilt_deg: f64,
    pub width: f64,
    pub height: f64,
}

impl Frame {
    /// Along the surface, to the right as seen from outside.
    pub(in crate::formats) fn right(&self) -> DVec3 {
        let (sin, cos) = self.azimuth_deg.to_radians().sin_cos();
        DVec3::new(-cos, sin, 0.0)
    }

    /// Along the surface, upwards.
    pub(in crate::formats) fn up(&self) -> DVec3 {
        let (sin, cos) = self.azimuth_deg.to_radians().sin_cos();
        let (sin_tilt, cos_tilt) = self.tilt_deg.to_radians().sin_cos();
        DVec3::new(-cos_tilt * sin, -cos_tilt * cos, sin_tilt)
    }

    /// Corners, upper left first; negative widths go to the left.
    pub(in crate::formats) fn corners(&self) -> Vec<DVec3> {
        let (right, up) = (self.width * self.right(), self.height * self.up());
        vec![self.origin + up, self.origin, self.origin + right, self.origin + right + up]
    }

    /// Of a polygon whose first corner is the upper left one.
    pub(in crate::formats) fn of(vertices: &[DVec3]) -> Option<Frame> {
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

/// Area times normal (Newell).
pub(in crate::formats) fn area_vector(vertices: &[DVec3]) -> DVec3 {
    let Some(&first) = vertices.first() else { return DVec3::ZERO };
    let after = vertices.iter().skip(1).chain([&first]);
    vertices.iter().zip(after).map(|(a, b)| 0.5 * (*a - first).cross(*b - first)).sum()
}
