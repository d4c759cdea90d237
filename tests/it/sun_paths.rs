//! Another sun algorithm and plain geometry, for tests of sunlight and of the sun in mirrors;
//! tables by their rows.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::DVec3;

use crate::cli::{Folder, stderr, stdout};

/// Returns the direction of the sun, by "Low accuracy" of Jean Meeus, Astronomical Algorithms
/// (1998), chapter 25: 0.01 degrees. `day` is in March to December 2017, as days since 2017-01-01
/// 00:00 UTC.
pub fn sun(day: f64, latitude_deg: f64, longitude_deg: f64) -> DVec3 {
    // The epoch 2017-01-01 00:00 is JD 2457754.5; delta T is 69 s.
    let julian = 2_457_754.5 + day;
    let t = (julian + 69.0 / 86_400.0 - 2_451_545.0) / 36_525.0;
    let mean_longitude = 280.46646 + 36_000.769_83 * t + 0.000_303_2 * t * t;
    let anomaly = (357.52911 + 35_999.050_29 * t - 0.000_153_7 * t * t).to_radians();
    let centre = (1.914602 - 0.004817 * t) * anomaly.sin()
        + (0.019993 - 0.000101 * t) * (2.0 * anomaly).sin()
        + 0.000289 * (3.0 * anomaly).sin();
    let node = (125.04 - 1934.136 * t).to_radians();
    let longitude = (mean_longitude + centre - 0.00569 - 0.00478 * node.sin()).to_radians();
    let obliquity = (23.439291 - 0.0130042 * t + 0.00256 * node.cos()).to_radians();
    let right_ascension = (obliquity.cos() * longitude.sin()).atan2(longitude.cos());
    let declination = (obliquity.sin() * longitude.sin()).asin();
    let sidereal_deg = 280.46061837 + 360.98564736629 * (julian - 2_451_545.0) - 0.0038 * node.sin();
    let hour_angle = ((sidereal_deg + longitude_deg).to_radians() - right_ascension).rem_euclid(TAU);
    let latitude = latitude_deg.to_radians();
    // East, north, up.
    DVec3::new(
        -declination.cos() * hour_angle.sin(),
        declination.sin() * latitude.cos() - declination.cos() * hour_angle.cos() * latitude.sin(),
        declination.sin() * latitude.sin() + declination.cos() * hour_angle.cos() * latitude.cos(),
    )
}

/// A rectangle: a corner and two edges.
#[derive(Clone, Copy)]
pub struct Rectangle(pub DVec3, pub DVec3, pub DVec3);

impl Rectangle {
    /// Returns true if a ray meets the rectangle.
    pub fn stops(&self, origin: DVec3, direction: DVec3) -> bool {
        self.stops_before(origin, direction, f64::INFINITY)
    }

    /// Returns true if a ray meets the rectangle within a distance.
    pub fn stops_before(&self, origin: DVec3, direction: DVec3, most: f64) -> bool {
        let Rectangle(corner, a, b) = *self;
        let normal = a.cross(b);
        let t = normal.dot(corner - origin) / normal.dot(direction);
        let at = origin + t * direction - corner;
        let within = |edge: DVec3| (0.0..=edge.length_squared()).contains(&at.dot(edge));
        t > 1e-6 && t < most && within(a) && within(b)
    }

    pub fn obj(&self) -> String {
        let Rectangle(p, a, b) = *self;
        let corners = [p, p + a, p + a + b, p + b].map(|c| format!("v {} {} {}\n", c.x, c.y, c.z));
        format!("{}f -4 -3 -2 -1\n", corners.concat())
    }
}

pub const GROUND: &str =
    "v -20000 -20000 0\nv 20000 -20000 0\nv 20000 20000 0\nv -20000 20000 0\nusemtl ground\nf 1 2 3 4\nusemtl wall\n";

/// Returns the rows of a table by their first two cells, the others by the names of their columns.
pub fn rows(text: &str) -> BTreeMap<(String, String), BTreeMap<String, String>> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let row = |line: &str| {
        let cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        let others = header.iter().zip(&cells).skip(2).map(|(name, cell)| ((*name).to_owned(), cell.clone()));
        ((cells[0].clone(), cells[1].clone()), others.collect())
    };
    lines.map(row).collect()
}

pub fn run(folder: &Folder, arguments: &str) -> String {
    let output = folder.run(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments}: {}", stderr(&output));
    stdout(&output)
}
