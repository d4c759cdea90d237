//! Sets of orientations. In: limits, steps. Out: tilts and azimuths that lie evenly on the sphere.

use glam::DVec3;

use crate::units::{direction_from_degrees, tilt_and_azimuth};

/// Orientation of a surface: tilt 0 up, 90 level, 180 down; azimuth clockwise from true north, 180
/// is south. Degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orientation {
    /// Tilt, 0..=180.
    pub tilt_deg: f64,
    /// Azimuth, 0 up to 360.
    pub azimuth_deg: f64,
}

impl Orientation {
    /// Orientation of a surface that faces straight up.
    pub const FLAT: Orientation = Orientation { tilt_deg: 0.0, azimuth_deg: 0.0 };

    /// Returns the orientation of a unit normal by true east, true north and up.
    pub fn new(normal: DVec3) -> Orientation {
        let (tilt_deg, azimuth_deg) = tilt_and_azimuth(normal);
        Orientation { tilt_deg, azimuth_deg }
    }

    /// Returns the unit normal by true east, true north and up. Straight up and down are exact at
    /// any azimuth.
    pub fn normal(self) -> DVec3 {
        match self.tilt_deg {
            0.0 => DVec3::Z,
            180.0 => DVec3::NEG_Z,
            tilt => direction_from_degrees(self.azimuth_deg, 90.0 - tilt).normalize(),
        }
    }
}

/// Limits of allowed orientations, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientationLimits {
    /// Least and greatest tilt, within 0..=180.
    pub tilts_deg: [f64; 2],
    /// First and last azimuth, clockwise: the last is not below the first, and at most 360 beyond
    /// it.
    pub azimuths_deg: [f64; 2],
}

/// Largest effect of rounding on an angle, degrees.
const ROUNDING_DEG: f64 = 1e-6;

impl OrientationLimits {
    /// Returns true if all azimuths are allowed.
    pub fn is_full_circle(&self) -> bool {
        self.azimuths_deg[1] - self.azimuths_deg[0] >= 360.0 - ROUNDING_DEG
    }

    /// Returns true if an orientation keeps within the limits. Straight up or down has all
    /// azimuths.
    pub fn allow(&self, turn: Orientation) -> bool {
        let [least, most] = self.tilts_deg;
        let level = turn.tilt_deg.to_radians().sin() > 1e-9;
        let beyond = (turn.azimuth_deg - self.azimuths_deg[0] + ROUNDING_DEG).rem_euclid(360.0);
        let in_sector =
            self.is_full_circle() || beyond <= self.azimuths_deg[1] - self.azimuths_deg[0] + 2.0 * ROUNDING_DEG;
        (least - ROUNDING_DEG..=most + ROUNDING_DEG).contains(&turn.tilt_deg) && (in_sector || !level)
    }

    /// Returns rings of orientations about `step_deg` degrees apart, with the limits themselves
    /// among them.
    pub fn rings(&self, step_deg: f64) -> Vec<Ring> {
        let [least, most] = self.tilts_deg;
        let parts = ((most - least) / step_deg - ROUNDING_DEG).ceil().max(0.0);
        let tilt = |i: usize| if parts == 0.0 { least } else { least + (most - least) * i as f64 / parts };
        (0..=parts as usize)
            .map(|i| Ring { tilt_deg: tilt(i), azimuths_deg: self.azimuths(tilt(i), step_deg) })
            .collect()
    }

    fn azimuths(&self, tilt_deg: f64, step_deg: f64) -> Vec<f64> {
        let [first, last] = self.azimuths_deg;
        let along = (last - first) * tilt_deg.to_radians().sin();
        let parts = (along / step_deg - ROUNDING_DEG).ceil().max(0.0) as usize;
        // A level surface has no azimuth, so one orientation stands for the whole ring.
        if tilt_deg.to_radians().sin() < 1e-9 {
            return vec![first.rem_euclid(360.0)];
        }
        // A full circle begins where it ends.
        let (parts, count) = if self.is_full_circle() { (parts.max(4), parts.max(4)) } else { (parts, parts + 1) };
        let part = (last - first) / parts.max(1) as f64;
        (0..count).map(|i| (first + part * i as f64).rem_euclid(360.0)).collect()
    }
}

/// Orientations of one tilt.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// Tilt of the ring, degrees.
    pub tilt_deg: f64,
    /// Azimuths of the ring, degrees.
    pub azimuths_deg: Vec<f64>,
}

impl Ring {
    /// Iterates over the orientations of the ring.
    pub fn turns(&self) -> impl Iterator<Item = Orientation> + '_ {
        self.azimuths_deg.iter().map(|&azimuth_deg| Orientation { tilt_deg: self.tilt_deg, azimuth_deg })
    }
}

/// Returns orientations around one, in `circles` circles out to a radius, degrees: 1 in the middle,
/// 6 on the first circle, 12 on the second and so on.
pub fn around(middle: Orientation, radius_deg: f64, circles: usize) -> Vec<Orientation> {
    let plane = TangentPlane::at(middle);
    let circle = |ring: usize| {
        let off = radius_deg * ring as f64 / circles.max(1) as f64;
        (0..6 * ring).map(move |i| {
            let angle = std::f64::consts::TAU * (i as f64 + 0.5 * (ring % 2) as f64) / (6 * ring) as f64;
            (off * angle.sin(), off * angle.cos())
        })
    };
    let offs = (1..=circles).flat_map(circle);
    std::iter::once(middle).chain(offs.map(|(a, b)| plane.turn(a, b))).collect()
}

/// Plane of orientations near one, by two coordinates in degrees off it: level to the side, and up
/// the surface. Distances from the middle are true angles.
#[derive(Clone, Copy, Debug)]
pub struct TangentPlane {
    middle: DVec3,
    side: DVec3,
    up: DVec3,
}

impl TangentPlane {
    /// Returns the plane of an orientation; for straight up or down the azimuth gives the axes.
    pub fn at(turn: Orientation) -> Self {
        let (sin, cos) = turn.azimuth_deg.to_radians().sin_cos();
        let (middle, side) = (turn.normal(), DVec3::new(-cos, sin, 0.0));
        TangentPlane { middle, side, up: middle.cross(side) }
    }

    /// Returns the orientation at a place of the plane.
    pub fn turn(&self, a_deg: f64, b_deg: f64) -> Orientation {
        let off = a_deg.hypot(b_deg);
        if off == 0.0 {
            return Orientation::new(self.middle);
        }
        let (sin, cos) = off.to_radians().sin_cos();
        let way = (self.side * a_deg + self.up * b_deg) / off;
        Orientation::new((self.middle * cos + way * sin).normalize())
    }

    /// Returns the place of an orientation in the plane, degrees.
    pub fn place(&self, turn: Orientation) -> [f64; 2] {
        let normal = turn.normal();
        let [a, b] = [self.side.dot(normal), self.up.dot(normal)];
        let sin = a.hypot(b);
        if sin == 0.0 {
            return [0.0, 0.0];
        }
        let off = sin.atan2(self.middle.dot(normal)).to_degrees();
        [a / sin * off, b / sin * off]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: OrientationLimits = OrientationLimits { tilts_deg: [0.0, 90.0], azimuths_deg: [0.0, 360.0] };

    /// Rings 10 degrees apart over the upper half are 10 rings and 229 orientations. One of them is
    /// up, and none is nearer than 6 degrees to another or outside the limits. With one azimuth
    /// there are 10.
    #[test]
    fn rings_cover_the_half_sphere_evenly() {
        let rings = ALL.rings(10.0);
        let turns: Vec<Orientation> = rings.iter().flat_map(Ring::turns).collect();
        assert_eq!((rings.len(), turns.len(), rings[0].azimuths_deg.len()), (10, 229, 1));
        assert!(turns.iter().all(|turn| ALL.allow(*turn)));
        for (i, a) in turns.iter().enumerate() {
            let near = turns[..i].iter().map(|b| a.normal().angle_between(b.normal()).to_degrees());
            assert!(near.fold(180.0, f64::min) > 6.0, "{a:?}");
        }
        let south = OrientationLimits { azimuths_deg: [180.0, 180.0], ..ALL };
        let turns: Vec<Orientation> = south.rings(10.0).iter().flat_map(Ring::turns).collect();
        assert!(turns.len() == 10 && turns.iter().all(|turn| turn.azimuth_deg == 180.0), "{turns:?}");
    }

    /// Limits from 300 over north to 60 degrees allow 350 and 10, not 180, and flat. A ring has
    /// both ends.
    #[test]
    fn limits_over_north_allow_their_azimuths() {
        let limits = OrientationLimits { tilts_deg: [0.0, 30.0], azimuths_deg: [300.0, 420.0] };
        let allowed = |azimuth_deg, tilt_deg| limits.allow(Orientation { tilt_deg, azimuth_deg });
        assert_eq!([350.0, 10.0, 60.0, 180.0].map(|a| allowed(a, 20.0)), [true, true, true, false]);
        assert!(allowed(180.0, 0.0) && !allowed(10.0, 31.0));
        let last = limits.rings(10.0).pop().expect("a ring");
        assert_eq!((last.azimuths_deg.first(), last.azimuths_deg.last()), (Some(&300.0), Some(&60.0)));
    }

    /// None of 37 orientations within 12 degrees of three others, up among them, is farther than
    /// that, and each comes back from its place in the plane within 1e-7 radians.
    #[test]
    fn near_orientations_come_back_from_their_plane() {
        for middle in [
            Orientation::FLAT,
            Orientation { tilt_deg: 35.0, azimuth_deg: 180.0 },
            Orientation { tilt_deg: 90.0, azimuth_deg: 15.0 },
        ] {
            let turns = around(middle, 12.0, 3);
            assert_eq!(turns.len(), 37);
            let plane = TangentPlane::at(middle);
            for turn in turns {
                let off = middle.normal().angle_between(turn.normal()).to_degrees();
                let [a, b] = plane.place(turn);
                assert!(off < 12.0 + 1e-6 && (a.hypot(b) - off).abs() < 1e-5, "{turn:?} {off}");
                let again = plane.turn(a, b).normal().angle_between(turn.normal());
                assert!(again < 1e-7, "{turn:?} {again}");
            }
        }
    }
}
