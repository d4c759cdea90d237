//! Patches: the part of a surface that a receiver stands for, convex polygons around it. In:
//! triangles or a text. Out: polygons in mm around the receiver.

use std::fmt;
use std::str::FromStr;

use glam::DVec3;

use crate::hemisphere::Frame;

/// Optional column of the part of its surface that the receiver stands for, as in a `Patch`.
pub const PATCH: &str = "patch";

/// Largest number of polygons of a patch.
pub const MAX_POLYGONS: usize = 255;
/// Largest number of corners of a polygon.
pub const MAX_CORNERS: usize = 255;
/// Largest distance of a corner from its receiver along an axis, mm: as far as scenes reach.
pub const MAX_OFFSET_MM: i32 = 1 << 30;

/// Offset of a corner from the receiver, mm along x, y and z.
pub type Offset = [i32; 3];

/// Polygons that make up the part of a surface that a receiver stands for; none where that part is
/// unknown. Each is convex and turns anticlockwise as seen from in front, so it is the fan of
/// triangles from its first corner.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Patch {
    polygons: Vec<Vec<Offset>>,
}

impl Patch {
    /// Returns the patch of polygons; `None` if there are too many, or one has less than 3 corners,
    /// too many, or corners too far away.
    pub fn new(polygons: Vec<Vec<Offset>>) -> Option<Self> {
        let near = |corner: &Offset| corner.iter().all(|mm| mm.unsigned_abs() <= MAX_OFFSET_MM as u32);
        let good = |polygon: &Vec<Offset>| (3..=MAX_CORNERS).contains(&polygon.len()) && polygon.iter().all(near);
        (polygons.len() <= MAX_POLYGONS && polygons.iter().all(good)).then_some(Patch { polygons })
    }

    /// Returns the patch of triangles around a position, in its coordinates, metres. Neighbours in
    /// one plane become one polygon as long as that is convex, and corners on straight edges are
    /// removed. The patch is empty if there are too many of them.
    pub fn of_triangles(position: DVec3, normal: DVec3, triangles: &[[DVec3; 3]]) -> Self {
        let rounded = |corner: DVec3| ((corner - position) * 1e3).round().to_array().map(|mm| mm as i32);
        let mut polygons: Vec<Vec<Offset>> = Vec::new();
        for corners in triangles {
            let mut triangle = corners.map(rounded);
            let across = across(&triangle);
            if across == DVec3::ZERO {
                continue;
            }
            if across.dot(normal) < 0.0 {
                triangle.reverse();
            }
            if !polygons.iter_mut().rev().any(|polygon| joined(polygon, triangle)) {
                polygons.push(triangle.to_vec());
            }
        }
        polygons.iter_mut().for_each(straighten);
        Patch::new(polygons).unwrap_or_default()
    }

    /// Returns a square of an area in m2 that faces along a unit normal, two sides level. It is
    /// drawn for a receiver whose patch is unknown.
    pub fn square(normal: DVec3, area_m2: f64) -> Self {
        let half = area_m2.max(0.0).sqrt() / 2.0;
        let Frame { u, v, .. } = Frame::new(normal);
        let corner = |x: f64, y: f64| (u * x + v * y) * half;
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let [a, b, c, d] = corners;
        Patch::of_triangles(DVec3::ZERO, normal, &[[a, b, c], [a, c, d]])
    }

    /// Returns the polygons.
    pub fn polygons(&self) -> &[Vec<Offset>] {
        &self.polygons
    }

    /// Returns true if the patch is unknown.
    pub fn is_empty(&self) -> bool {
        self.polygons.is_empty()
    }

    /// Iterates over the triangles of the polygons.
    pub fn triangles(&self) -> impl Iterator<Item = [Offset; 3]> {
        self.polygons.iter().flat_map(|polygon| {
            let pairs = polygon.iter().skip(1).zip(polygon.iter().skip(2));
            polygon.first().into_iter().flat_map(move |first| pairs.clone().map(|(b, c)| [*first, *b, *c]))
        })
    }
}

/// Text of a patch in a table of receivers: `x y z` in mm, corners separated by `;`, polygons by
/// `|`.
impl fmt::Display for Patch {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for (i, polygon) in self.polygons.iter().enumerate() {
            for (k, [x, y, z]) in polygon.iter().enumerate() {
                let before = if k > 0 { ";" } else { ["", "|"][usize::from(i > 0)] };
                write!(f, "{before}{x} {y} {z}")?;
            }
        }
        Ok(())
    }
}

impl FromStr for Patch {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let corner = |text: &str| -> Option<Offset> {
            let mut numbers = text.split_ascii_whitespace().map(str::parse);
            let corner = [numbers.next()?.ok()?, numbers.next()?.ok()?, numbers.next()?.ok()?];
            numbers.next().is_none().then_some(corner)
        };
        let polygon = |text: &str| text.split(';').map(corner).collect::<Option<Vec<Offset>>>();
        let polygons = match text.trim() {
            "" => Some(Vec::new()),
            text => text.split('|').map(polygon).collect(),
        };
        let what = "not polygons of whole mm around the receiver, as in `-500 -500 0;500 -500 0;500 500 0`";
        polygons.and_then(Patch::new).ok_or_else(|| what.into())
    }
}

fn exact(offset: Offset) -> DVec3 {
    DVec3::from_array(offset.map(f64::from))
}

/// Returns twice the area of a triangle as a vector, mm2.
fn across([a, b, c]: &[Offset; 3]) -> DVec3 {
    (exact(*b) - exact(*a)).cross(exact(*c) - exact(*a))
}

/// Returns true if a polygon's corner turns to the left, or lies on the line through its neighbours
/// within 1 mm.
fn turns_left(before: Offset, corner: Offset, after: Offset, normal: DVec3) -> bool {
    let across = across(&[before, corner, after]).dot(normal);
    across >= -(exact(after) - exact(before)).length()
}

/// Adds a triangle that lies in a polygon's plane on the other side of one of its edges, if the two
/// are convex together. Returns true if it was added.
fn joined(polygon: &mut Vec<Offset>, triangle: [Offset; 3]) -> bool {
    let count = polygon.len();
    let at = |i: usize| polygon[i % count];
    let Ok(first) = <[Offset; 3]>::try_from(&polygon[..3]) else { return false };
    let normal = across(&first).normalize_or_zero();
    for edge in 0..count {
        for corner in 0..3 {
            let [p, q, apex] = [0, 1, 2].map(|k| triangle[(corner + k) % 3]);
            if (p, q) != (at(edge + 1), at(edge)) {
                continue;
            }
            let level = (exact(apex) - exact(p)).dot(normal).abs() <= 2.0;
            let convex = turns_left(at(edge + count - 1), at(edge), apex, normal)
                && turns_left(apex, at(edge + 1), at(edge + 2), normal);
            if level && convex && count < MAX_CORNERS {
                polygon.insert(edge + 1, apex);
                return true;
            }
        }
    }
    false
}

/// Removes corners on straight edges, within 1 mm.
fn straighten(polygon: &mut Vec<Offset>) {
    let mut i = 0;
    while polygon.len() > 3 && i < polygon.len() {
        let count = polygon.len();
        let [before, corner, after] = [count - 1, 0, 1].map(|k| polygon[(i + k) % count]);
        let across = across(&[before, corner, after]).length();
        if across <= (exact(after) - exact(before)).length() {
            polygon.remove(i);
        } else {
            i += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area_m2(patch: &Patch) -> f64 {
        patch.triangles().map(|triangle| across(&triangle).length()).sum::<f64>() / 2e6
    }

    /// Eight triangles of a square of 2 m, around its middle and with the middles of its sides,
    /// become two halves of a square of 4 m2. Two triangles at an angle stay two polygons. A ring
    /// around a hole of 1 m2 keeps its area of 3 m2.
    #[test]
    fn triangles_of_a_plane_become_one_polygon() {
        let at = DVec3::new(78_000.0, 457_000.0, 3.0);
        let round: Vec<DVec3> = [(-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0)]
            .map(|(x, y): (i32, i32)| at + DVec3::new(x.into(), y.into(), 0.0))
            .to_vec();
        let fan: Vec<[DVec3; 3]> = (0..8).map(|i| [round[(i + 1) % 8], round[i], at]).collect();
        let square = Patch::of_triangles(at, DVec3::Z, &fan);
        assert_eq!(square.polygons().iter().map(Vec::len).collect::<Vec<_>>(), [3, 3]);
        assert!((area_m2(&square) - 4.0).abs() < 1e-9);
        assert_eq!(Patch::square(DVec3::Z, 4.0).polygons()[0].len(), 4);
        let (a, b) = (DVec3::X, DVec3::Y);
        let bent = [[DVec3::ZERO, a, b], [a, DVec3::new(1.0, 1.0, 0.5), b]];
        assert_eq!(Patch::of_triangles(DVec3::ZERO, DVec3::Z, &bent).polygons().len(), 2);
        let corners =
            |half: f64| [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0) * half);
        let (outer, inner) = (corners(1.0), corners(0.5));
        let ring: Vec<[DVec3; 3]> = (0..4)
            .flat_map(|i| {
                let k = (i + 1) % 4;
                [[outer[i], outer[k], inner[k]], [outer[i], inner[k], inner[i]]]
            })
            .collect();
        assert!((area_m2(&Patch::of_triangles(DVec3::ZERO, DVec3::Z, &ring)) - 3.0).abs() < 1e-9);
    }

    /// Squares of 2.25 m2 have that area within 0.2 % and face along each of 4 normals.
    #[test]
    fn squares_face_along_normals() {
        for normal in [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(0.6, 0.0, 0.8)] {
            let patch = Patch::square(normal, 2.25);
            assert!((area_m2(&patch) - 2.25).abs() < 0.005, "{normal}");
            assert!(patch.triangles().all(|triangle| across(&triangle).normalize().dot(normal) > 0.999), "{normal}");
        }
    }

    /// Three of 3 texts come back. Seven texts that are no patches are refused.
    #[test]
    fn patches_come_back_from_their_texts() {
        for text in ["", "-500 -500 0;500 -500 0;500 500 -12", "0 0 0;1 0 0;0 1 0|5 5 5;6 5 5;5 6 5;4 5 5"] {
            assert_eq!(text.parse::<Patch>().map(|patch| patch.to_string()).as_deref(), Ok(text));
        }
        let far = format!("0 0 0;1 0 0;0 {} 0", MAX_OFFSET_MM + 1);
        let refused =
            ["0 0 0", "0 0 0;1 0 0", "0 0 0;1 0 0;0 1", "0 0 0;1 0 0;0 1 0;", "a", "0 0 0;1 0 0;0 1.5 0", &far];
        assert_eq!(refused.into_iter().filter(|text| text.parse::<Patch>().is_err()).count(), 7);
    }
}
