//! Rows of a map: texts, numbers and polygons of a place. In: a row. Out: bytes for a sorted run;
//! and a row from such bytes.

use std::io;
use std::path::Path;

use earcut::Earcut;
use glam::DVec3;

use heliotile_core::error::{Error, Result};

/// Largest distance to the wrong side at which a corner counts as in line, metres: corners are
/// rounded to mm.
const LEFT_M: f64 = 0.001;

/// Row of a map: a place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapRow {
    /// Texts in the order of the map's columns; empty if unknown.
    pub texts: Vec<String>,
    /// Numbers in the order of the map's columns; NaN if there is none.
    pub numbers: Vec<f32>,
    pub polygons: Vec<MapPolygon>,
}

/// Plane polygon: its outline, anticlockwise as seen from the front, and its holes, clockwise.
/// Corners are in scene coordinates, metres; rings do not repeat their first corner.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapPolygon {
    pub rings: Vec<Vec<DVec3>>,
}

impl MapPolygon {
    /// Returns a place without an extent.
    pub fn point(at: DVec3) -> Self {
        MapPolygon { rings: vec![vec![at]] }
    }

    /// Returns all corners, ring by ring.
    pub fn corners(&self) -> impl Iterator<Item = &DVec3> {
        self.rings.iter().flatten()
    }

    /// Returns twice the area times the normal (Newell; Tampieri, Graphics Gems III, 1992); holes
    /// have the opposite winding and count negative.
    fn across(&self) -> DVec3 {
        let of_ring = |ring: &Vec<DVec3>| -> DVec3 {
            // Coordinates are taken relative to a corner, as those of maps are large.
            let first = ring.first().copied().unwrap_or_default();
            let following = ring.iter().cycle().skip(1);
            ring.iter().zip(following).map(|(a, b)| (*a - first).cross(*b - first)).sum()
        };
        self.rings.iter().map(of_ring).sum()
    }

    /// Returns the unit normal; zero without area.
    pub fn normal(&self) -> DVec3 {
        self.across().normalize_or_zero()
    }

    /// Returns the area, m2.
    pub fn area_m2(&self) -> f64 {
        self.across().length() / 2.0
    }

    /// Returns triangles of the same area and winding, as indices into [`MapPolygon::corners`].
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let corners: Vec<DVec3> = self.corners().copied().collect();
        if corners.len() == 3 {
            return vec![[0, 1, 2]];
        }
        let (normal, first) = (self.normal(), corners.first().copied().unwrap_or_default());
        let frame = heliotile_core::hemisphere::Frame::new(if normal == DVec3::ZERO { DVec3::Z } else { normal });
        let flat: Vec<[f64; 2]> =
            corners.iter().map(|corner| frame.to_local(*corner - first)).map(|local| [local.x, local.y]).collect();
        let mut start = 0;
        let mut holes: Vec<u32> = Vec::new();
        for ring in &self.rings {
            holes.extend((start > 0).then_some(start));
            start += ring.len() as u32;
        }
        let mut cut: Vec<u32> = Vec::new();
        Earcut::new().earcut(flat.iter().copied(), &holes, &mut cut);
        let of_corner = |corner: &u32| flat.get(*corner as usize).copied().unwrap_or_default();
        let mut triangles: Vec<[u32; 3]> = cut.as_chunks().0.to_vec();
        for triangle in &mut triangles {
            let [a, b, c] = triangle.each_ref().map(of_corner);
            if (b[0] - a[0]) * (c[1] - a[1]) < (b[1] - a[1]) * (c[0] - a[0]) {
                triangle.reverse();
            }
        }
        triangles
    }

    /// Returns true if the polygon has one ring, which turns left at each corner.
    fn is_convex(&self) -> bool {
        let [ring] = self.rings.as_slice() else { return false };
        let (normal, count) = (self.normal(), ring.len());
        let at = |i: usize| ring.get(i % count).copied().unwrap_or_default();
        (0..count).all(|i| {
            let [before, after] = [at(i + 1) - at(i), at(i + 2) - at(i + 1)];
            before.cross(after).dot(normal) >= -LEFT_M * (before + after).length()
        })
    }

    /// Returns convex cells: the polygon itself if it is convex, or else triangles. VTK integrates
    /// over polygons as fans from their first corner, which is right for convex ones only.
    pub fn cells(&self) -> Vec<Vec<u32>> {
        match self.rings.as_slice() {
            [only] if self.is_convex() => vec![(0..only.len() as u32).collect()],
            _ => self.triangles().into_iter().map(|triangle| triangle.to_vec()).collect(),
        }
    }
}

impl MapRow {
    /// Returns the row as bytes.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let length = |bytes: &mut Vec<u8>, length: usize| bytes.extend((length as u32).to_le_bytes());
        length(&mut bytes, self.texts.len());
        for text in &self.texts {
            length(&mut bytes, text.len());
            bytes.extend(text.as_bytes());
        }
        length(&mut bytes, self.numbers.len());
        self.numbers.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        length(&mut bytes, self.polygons.len());
        for polygon in &self.polygons {
            length(&mut bytes, polygon.rings.len());
            for ring in &polygon.rings {
                length(&mut bytes, ring.len());
                ring.iter().flat_map(DVec3::to_array).for_each(|metres| bytes.extend(metres.to_le_bytes()));
            }
        }
        bytes
    }

    /// Reads a row from the bytes that [`MapRow::bytes`] gave; other bytes are an error.
    pub fn of_bytes(bytes: &[u8]) -> Result<MapRow> {
        Cursor(bytes).row().ok_or_else(|| {
            let damaged = io::Error::new(io::ErrorKind::InvalidData, "a row is not as it was written");
            Error::io(Path::new("a temporary file"), "read")(damaged)
        })
    }
}

/// Remaining bytes of a row.
struct Cursor<'a>(&'a [u8]);

impl Cursor<'_> {
    fn take(&mut self, length: usize) -> Option<&[u8]> {
        let (head, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(head)
    }

    fn length(&mut self) -> Option<usize> {
        let (head, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u32::from_le_bytes(*head) as usize)
    }

    fn text(&mut self) -> Option<String> {
        let length = self.length()?;
        String::from_utf8(self.take(length)?.to_vec()).ok()
    }

    fn number(&mut self) -> Option<f32> {
        let (head, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(f32::from_le_bytes(*head))
    }

    fn metres(&mut self) -> Option<f64> {
        let (head, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(f64::from_le_bytes(*head))
    }

    fn corner(&mut self) -> Option<DVec3> {
        Some(DVec3::new(self.metres()?, self.metres()?, self.metres()?))
    }

    fn ring(&mut self) -> Option<Vec<DVec3>> {
        (0..self.length()?).map(|_| self.corner()).collect()
    }

    fn polygon(&mut self) -> Option<MapPolygon> {
        Some(MapPolygon { rings: (0..self.length()?).map(|_| self.ring()).collect::<Option<_>>()? })
    }

    fn row(mut self) -> Option<MapRow> {
        Some(MapRow {
            texts: (0..self.length()?).map(|_| self.text()).collect::<Option<_>>()?,
            numbers: (0..self.length()?).map(|_| self.number()).collect::<Option<_>>()?,
            polygons: (0..self.length()?).map(|_| self.polygon()).collect::<Option<_>>()?,
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Returns a wall of 4 m x 3 m with a window of 1 m x 1 m, 85 km from the origin, that faces
    /// south.
    pub fn wall() -> MapPolygon {
        let at = |x: f64, z: f64| DVec3::new(85_000.0 + x, 446_000.0, 10.0 + z);
        let outline = vec![at(0.0, 0.0), at(4.0, 0.0), at(4.0, 3.0), at(0.0, 3.0)];
        let window = vec![at(1.0, 1.0), at(1.0, 2.0), at(2.0, 2.0), at(2.0, 1.0)];
        MapPolygon { rings: vec![outline, window] }
    }

    /// A wall of 12 m2 with a window of 1 m2 has 11 m2 and faces south, and its 8 triangles have
    /// the same area and winding.
    #[test]
    fn a_window_is_cut_out_of_its_wall() {
        let wall = wall();
        assert!((wall.area_m2() - 11.0).abs() < 1e-9 && (wall.normal() + DVec3::Y).length() < 1e-9);
        let corners: Vec<DVec3> = wall.corners().copied().collect();
        let across = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|corner| corners[corner as usize]);
            (b - a).cross(c - a) / 2.0
        };
        let triangles = wall.triangles();
        assert_eq!((triangles.len(), wall.cells().len()), (8, 8));
        assert!(triangles.iter().all(|triangle| across(triangle).y <= 0.0));
        assert!((triangles.iter().map(across).sum::<DVec3>().length() - 11.0).abs() < 1e-9);
    }

    /// A square is one cell; an L of 6 corners is 4 triangles.
    #[test]
    fn cells_are_convex() {
        let polygon = |corners: &[(f64, f64)]| MapPolygon {
            rings: vec![corners.iter().map(|(x, y)| DVec3::new(*x, *y, 3.0)).collect()],
        };
        let square = polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        let corner = polygon(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]);
        assert_eq!((square.cells().len(), corner.cells().len()), (1, 4));
    }

    /// A row is read back from its bytes; none of the more than 300 truncations of the bytes can be
    /// read.
    #[test]
    fn rows_come_back() {
        let row = MapRow {
            texts: vec!["wall".into(), String::new(), "fa\u{e7}ade".into()],
            numbers: vec![1.5, -0.0, 1e-30],
            polygons: vec![wall(), MapPolygon { rings: vec![vec![DVec3::X, DVec3::Y, DVec3::Z]] }],
        };
        let bytes = row.bytes();
        assert_eq!(MapRow::of_bytes(&bytes).expect("a row"), row);
        assert!(bytes.len() > 300 && (0..bytes.len()).all(|length| MapRow::of_bytes(&bytes[..length]).is_err()));
    }
}
