//! Triangulation of faces. In: polygons with holes, flat or nearly so, convex or not. Out:
//! triangles of the same area, winding and corners.

use earcut::Earcut;
use glam::{DVec2, DVec3};

use crate::geometry::{Geometry, Polygon};
use crate::large_polygon;
use crate::mesh::{NO_AREA, RawTriangle};
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::morton::lexicographic;

/// Most corners of a face.
const MAX_CORNERS: usize = 65_536;

/// Corners of a face beyond which ears are not clipped: that costs up to the square of their
/// number, 26 s for a spiral of [`MAX_CORNERS`].
const MANY_CORNERS: usize = 4096;

/// Most corners of a face that crosses itself, for which only clipping of ears is left: 3 s for a
/// tangle of this many.
const MAX_CROSSING: usize = 16_384;

/// Largest difference between the areas of the triangles and of their ring, as a share; beyond it
/// the ring counts as crossing itself.
const AREA_TOLERANCE: f64 = 1e-6;

/// Distance of a corner from the mean plane of its face, metres, beyond which a warning counts the
/// face.
pub(super) const OFF_PLANE_M: f64 = 0.05;

#[derive(Debug, Default)]
pub(super) struct Triangulation {
    pub triangles: Vec<RawTriangle>,
    /// Object of each triangle.
    pub objects: Vec<u32>,
    /// Number of the face that each triangle is cut from.
    pub faces: Vec<u32>,
    pub concave_faces: usize,
    /// Faces with fewer than three distinct corners or without area.
    pub degenerate_faces: usize,
    /// Count of faces whose outline crosses itself or its holes, and the first of them.
    pub crossing_faces: Option<(usize, FaceLocation)>,
    /// Count of faces with a corner more than [`OFF_PLANE_M`] off their mean plane, and the largest
    /// distance in metres.
    pub off_plane: (usize, f64),
}

/// Face that a message is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FaceLocation {
    /// Line of the file; 0 if the format has no lines.
    pub line: usize,
    pub object: u32,
}

/// Triangulates every face of a file, in file order.
pub(super) fn triangulate(geometry: &Geometry) -> Result<Triangulation> {
    let mut done = Triangulation::default();
    let mut rings = Rings::default();
    for face in geometry.faces() {
        let corners = face.corners();
        // Triangles need no projection and no cut.
        if let (&[a, b, c], false) = (corners, face.has_holes()) {
            done.triangles.push(RawTriangle { corners: [a, b, c], material: face.material, object: 0 });
            done.objects.push(face.object);
            done.faces.push(face.number as u32);
            continue;
        }
        let beyond = |what: &str, max: usize| {
            let place = match face.line {
                0 => format!("a face of {}", object_name(geometry, face.object)),
                line => format!("the face in line {line}"),
            };
            let what = format!("the number of corners of {place}{what}");
            Error::Limit { what: what.into(), value: corners.len() as u64, max: max as u64 }
        };
        if corners.len() > MAX_CORNERS {
            return Err(beyond("", MAX_CORNERS));
        }
        rings.fill(&face, &geometry.vertices);
        if !rings.cut(&face, &mut done) {
            return Err(beyond(", which crosses itself", MAX_CROSSING));
        }
        done.objects.resize(done.triangles.len(), face.object);
        done.faces.resize(done.triangles.len(), face.number as u32);
    }
    Ok(done)
}

/// Returns the corners of the triangles that one face is cut into.
pub(super) fn triangles_of(geometry: &Geometry, number: usize) -> Vec<[DVec3; 3]> {
    let Some(face) = geometry.polygon(number) else { return Vec::new() };
    let position = |corner: u32| geometry.vertices.get(corner as usize).copied().unwrap_or_default();
    if let (&[a, b, c], false) = (face.corners(), face.has_holes()) {
        return vec![[a, b, c].map(position)];
    }
    let (mut done, mut rings) = (Triangulation::default(), Rings::default());
    rings.fill(&face, &geometry.vertices);
    rings.cut(&face, &mut done);
    done.triangles.iter().map(|triangle| triangle.corners.map(position)).collect()
}

/// Returns the area vector of a face, m2: its length is the area without the holes, its direction
/// the normal (Newell).
pub(super) fn area_vector_of(face: &Polygon, vertices: &[DVec3]) -> DVec3 {
    let position = |corner: &u32| vertices.get(*corner as usize).copied().unwrap_or_default();
    let mut area = DVec3::ZERO;
    for (i, ring) in face.rings().enumerate() {
        let from = ring.first().map(position).unwrap_or_default();
        let after = ring.iter().cycle().skip(1);
        let of_ring: DVec3 =
            ring.iter().zip(after).map(|(a, b)| 0.5 * (position(a) - from).cross(position(b) - from)).sum();
        // Holes may turn either way.
        area += if i == 0 || of_ring.dot(area) < 0.0 { of_ring } else { -of_ring };
    }
    area
}

/// Returns the name of an object as messages quote it.
pub(super) fn object_name(geometry: &Geometry, object: u32) -> String {
    let name = geometry.objects.as_slice().get(object as usize);
    format!("`{}`", excerpt(name.map_or("", String::as_str).as_bytes()))
}

/// Scratch space for one face after another: outline, then holes.
#[derive(Default)]
struct Rings {
    corners: Vec<u32>,
    /// Beginnings of holes in `corners`.
    holes: Vec<usize>,
    /// Positions relative to the first corner, metres.
    positions: Vec<DVec3>,
    /// Positions in the coordinate plane in which the outline is largest, counter-clockwise.
    flat: Vec<[f64; 2]>,
    earcut: Option<Earcut<f64>>,
    cut: Vec<u32>,
}

impl Rings {
    /// Takes the face's corners without repetitions. Each ring begins at its least vertex, and
    /// holes are sorted by that vertex: the start of a ring in the file must not decide which
    /// diagonals are cut.
    fn fill(&mut self, face: &Polygon, vertices: &[DVec3]) {
        let position = |corner: u32| vertices.get(corner as usize).copied().unwrap_or_default();
        self.corners.clear();
        self.holes.clear();
        let mut rings = face.rings().map(|ring| begin_at_least(ring, position));
        self.corners.extend(rings.next().unwrap_or_default());
        let mut holes: Vec<Vec<u32>> = rings.filter(|ring| ring.len() > 2).collect();
        let least = |ring: &Vec<u32>| ring.first().map_or(DVec3::ZERO, |&corner| position(corner));
        holes.sort_by(|a, b| lexicographic(least(a), least(b)));
        for hole in holes {
            self.holes.push(self.corners.len());
            self.corners.extend(hole);
        }
        let first = self.corners.first().map_or(DVec3::ZERO, |&corner| position(corner));
        self.positions.clear();
        self.positions.extend(self.corners.iter().map(|&corner| position(corner) - first));
    }

    /// Returns the number of corners of the outline.
    fn outline(&self) -> usize {
        self.holes.first().copied().unwrap_or(self.corners.len())
    }

    /// Adds the triangles of a face. Returns false if it crosses itself and has too many corners.
    fn cut(&mut self, face: &Polygon, done: &mut Triangulation) -> bool {
        let normal = self.newell_normal();
        let extent = self.positions.iter().fold(0.0, |far: f64, p| far.max(p.length_squared()));
        // The length of Newell's vector is twice the area.
        if self.outline() < 3 || normal.length() <= 2.0 * NO_AREA * extent {
            done.degenerate_faces += 1;
            return true;
        }
        self.note_bend(normal.normalize_or_zero(), done);
        self.project(normal);
        let turns = self.turns();
        if turns == Turns::Concave || !self.holes.is_empty() {
            done.concave_faces += 1;
        }
        self.cut.clear();
        match (self.corners.len(), turns, self.holes.is_empty()) {
            (3, _, true) => self.cut.extend([0, 1, 2]),
            (4, Turns::Convex, true) => self.cut.extend([0, 1, 2, 0, 2, 3]),
            (count, ..) if count > MANY_CORNERS && self.cut_many() => {}
            (MAX_CROSSING.., ..) => return false,
            _ => {
                let earcut = self.earcut.get_or_insert_with(Earcut::new);
                let holes: Vec<u32> = self.holes.iter().map(|&start| start as u32).collect();
                earcut.earcut_slice(&self.flat, &holes, &mut self.cut);
            }
        }
        let covered = self.push_triangles(face.material, &mut done.triangles);
        let area = self.area();
        if (covered - area).abs() > AREA_TOLERANCE * area {
            let first = FaceLocation { line: face.line, object: face.object };
            let (count, place) = done.crossing_faces.unwrap_or((0, first));
            done.crossing_faces = Some((count + 1, place));
        }
        true
    }

    /// Cuts a ring of many corners; returns false if it crosses itself.
    fn cut_many(&mut self) -> bool {
        let cut = large_polygon::cut(&self.flat, &self.holes);
        cut.map(|triangles| self.cut = triangles).is_some()
    }

    /// Counts the face if it is not flat.
    fn note_bend(&self, normal: DVec3, done: &mut Triangulation) {
        let heights = self.positions.iter().map(|p| p.dot(normal));
        let mean = heights.clone().sum::<f64>() / self.positions.len().max(1) as f64;
        let off = heights.fold(0.0, |off: f64, height| off.max((height - mean).abs()));
        if off > OFF_PLANE_M {
            done.off_plane = (done.off_plane.0 + 1, done.off_plane.1.max(off));
        }
    }

    /// Returns the area of the outline without its holes, in the plane of projection.
    fn area(&self) -> f64 {
        let ends = self.holes.iter().copied().skip(1).chain([self.flat.len()]);
        let holes = self.holes.iter().zip(ends).map(|(&start, end)| self.flat.get(start..end).unwrap_or_default());
        let outline = self.flat.get(..self.outline()).unwrap_or_default();
        signed_area(outline) - holes.map(|hole| signed_area(hole).abs()).sum::<f64>()
    }

    /// Returns twice the area times the mean normal (Newell; Tampieri, Graphics Gems III, 1992);
    /// robust for rings that are not flat.
    fn newell_normal(&self) -> DVec3 {
        let outline = self.positions.get(..self.outline()).unwrap_or_default();
        let following = outline.iter().cycle().skip(1);
        let edges = outline.iter().zip(following);
        edges.map(|(a, b)| a.cross(*b)).sum()
    }

    /// Projects the corners by dropping the axis nearest to the normal, which keeps points in line
    /// exactly in line.
    fn project(&mut self, normal: DVec3) {
        let size = normal.abs();
        let flat = |p: &DVec3| {
            if size.z >= size.x && size.z >= size.y {
                (normal.z, p.x, p.y)
            } else if size.y >= size.x {
                (normal.y, p.z, p.x)
            } else {
                (normal.x, p.y, p.z)
            }
        };
        self.flat.clear();
        self.flat.extend(self.positions.iter().map(|p| match flat(p) {
            (along, u, v) if along > 0.0 => [u, v],
            (_, u, v) => [v, u],
        }));
    }

    fn turns(&self) -> Turns {
        let points = self.flat.iter().take(self.outline()).map(|&p| DVec2::from(p));
        let following = points.clone().cycle().skip(1);
        let after = points.clone().cycle().skip(2);
        let mut turns = Turns::Convex;
        for ((a, b), c) in points.zip(following).zip(after) {
            let (before, behind) = (b - a, c - b);
            let turn = before.perp_dot(behind);
            let nothing = NO_AREA * before.length() * behind.length();
            if turn < -nothing {
                return Turns::Concave;
            }
            if turn <= nothing {
                turns = Turns::Straight;
            }
        }
        turns
    }

    fn at(&self, place: u32) -> Option<(u32, [f64; 2])> {
        let place = place as usize;
        self.corners.get(place).copied().zip(self.flat.get(place).copied())
    }

    /// Appends the triangles in the winding of the ring; returns the flat area that they cover.
    fn push_triangles(&self, material: u32, triangles: &mut Vec<RawTriangle>) -> f64 {
        let mut covered = 0.0;
        for triple in self.cut.chunks_exact(3) {
            let &[a, b, c] = triple else { continue };
            let (Some((ca, pa)), Some((cb, pb)), Some((cc, pc))) = (self.at(a), self.at(b), self.at(c)) else {
                continue;
            };
            let area = signed_area(&[pa, pb, pc]);
            covered += area.abs();
            // The library chooses a winding of its own.
            let (cb, cc) = if area < 0.0 { (cc, cb) } else { (cb, cc) };
            let corners = [ca, cb, cc];
            triangles.push(RawTriangle { corners, material, object: 0 });
        }
        covered
    }
}

/// Returns a ring without repeated corners, rotated so that its least vertex is first.
fn begin_at_least(ring: &[u32], position: impl Fn(u32) -> DVec3) -> Vec<u32> {
    let mut corners = ring.to_vec();
    corners.dedup_by_key(|corner| position(*corner).to_array());
    while let [first, .., last] = corners.as_slice()
        && position(*first) == position(*last)
    {
        corners.pop();
    }
    let least = (0..corners.len()).zip(&corners).min_by(|(_, a), (_, b)| lexicographic(position(**a), position(**b)));
    if let Some((start, _)) = least {
        corners.rotate_left(start);
    }
    corners
}

/// Turns of a ring, seen against its normal.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Turns {
    /// Left at every corner.
    Convex,
    /// Left or straight on.
    Straight,
    /// Right at some corner.
    Concave,
}

/// Returns the signed area of a ring, positive if counter-clockwise.
fn signed_area(ring: &[[f64; 2]]) -> f64 {
    let following = ring.iter().cycle().skip(1);
    let twice: f64 = ring.iter().zip(following).map(|(a, b)| DVec2::from(*a).perp_dot(DVec2::from(*b))).sum();
    0.5 * twice
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangulates one face and returns it with the sum of its triangles' area vectors.
    fn face(points: &[[f64; 3]]) -> (Triangulation, DVec3) {
        with_holes(&[points])
    }

    /// Triangulates an outline with its holes and returns it with the sum of its triangles' area
    /// vectors.
    fn with_holes(rings: &[&[[f64; 3]]]) -> (Triangulation, DVec3) {
        let mut obj = Geometry::default();
        for (i, ring) in rings.iter().enumerate() {
            if i > 0 {
                obj.begin_hole();
            }
            for &point in *ring {
                obj.push_corner(obj.vertices.len() as u32);
                obj.vertices.push(DVec3::from(point));
            }
        }
        obj.end_face(0, 0, 6);
        let done = triangulate(&obj).expect("within limits");
        let area = done.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.corners.map(|corner| obj.vertices[corner as usize]);
            0.5 * (b - a).cross(c - a)
        });
        let area = area.sum();
        (done, area)
    }

    /// Returns true if every corner of the face is a corner of some triangle, so that no crack
    /// opens beside a neighbour.
    fn uses_all(done: &Triangulation, corners: usize) -> bool {
        (0..corners as u32).all(|corner| done.triangles.iter().any(|triangle| triangle.corners.contains(&corner)))
    }

    /// A square is two triangles of its area and winding, in every plane and both windings.
    #[test]
    fn a_square_is_two_triangles_of_its_area() {
        for turn in 0..3 {
            let place = |u: f64, v: f64| {
                let mut p = [u, v, 5.0];
                p.rotate_right(turn);
                p
            };
            let mut ring = vec![place(1.0, 1.0), place(3.0, 1.0), place(3.0, 3.0), place(1.0, 3.0)];
            let mut expected = [0.0, 0.0, 4.0];
            expected.rotate_right(turn);
            let (done, area) = face(&ring);
            assert_eq!((done.triangles.len(), done.concave_faces), (2, 0));
            assert_eq!(area, DVec3::from(expected));
            ring.reverse();
            assert_eq!(face(&ring).1, -DVec3::from(expected));
        }
    }

    /// A concave L keeps its area of 3 m2 and its winding wherever its ring starts, also on a slope
    /// and on a wall.
    #[test]
    fn a_concave_face_keeps_its_area() {
        let ell = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        for start in 0..6 {
            for slope in [0.0, 1.0, 50.0] {
                let mut ring = ell.map(|[u, v]| [u, v, slope * u]);
                ring.rotate_left(start);
                let (done, area) = face(&ring);
                assert_eq!((done.triangles.len(), done.concave_faces), (4, 1));
                assert!((area - 3.0 * DVec3::new(-slope, 0.0, 1.0)).length() < 1e-12 * area.length());
                assert_eq!(done.crossing_faces, None);
                ring.reverse();
                assert!(face(&ring).1.z < 0.0);
            }
        }
    }

    /// Points in line on the edges survive as corners, whichever of them the ring starts at.
    #[test]
    fn points_in_line_survive_as_corners() {
        let mut ring = vec![];
        for side in 0..4 {
            for step in 0..5 {
                let along = f64::from(step) * 0.2;
                let (u, v) = [(along, 0.0), (1.0, along), (1.0 - along, 1.0), (0.0, 1.0 - along)][side];
                ring.push([78_000.0 + u, 457_000.0 + v, 3.0]);
            }
        }
        for _ in 0..ring.len() {
            ring.rotate_left(1);
            let (done, area) = face(&ring);
            assert!(uses_all(&done, ring.len()), "{:?}", done.triangles);
            assert!((area.z - 1.0).abs() < 1e-9, "{area}");
        }
        let (done, area) = face(&[[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [0., 2., 0.]]);
        assert!(uses_all(&done, 4));
        assert_eq!((area.z, done.concave_faces), (2.0, 0));
    }

    /// A courtyard cut in through a slit is triangulated to outline minus courtyard, 16 - 4 = 12
    /// m2.
    #[test]
    fn a_slit_hole_is_left_out_of_the_area() {
        let (done, area) = face(&[
            [0., 0., 0.],
            [4., 0., 0.],
            [4., 4., 0.],
            [0., 4., 0.],
            [0., 0., 0.], //
            [1., 1., 0.],
            [1., 3., 0.],
            [3., 3., 0.],
            [3., 1., 0.],
            [1., 1., 0.],
        ]);
        assert_eq!((area.z, done.crossing_faces), (12.0, None));
    }

    /// Faces that repeat corners, have two of them or no area are counted and leave no triangle.
    #[test]
    fn degenerate_faces_leave_no_triangle() {
        for ring in [
            &[[0., 0., 0.], [1., 0., 0.]][..],
            &[[0., 0., 0.]],
            &[[0., 0., 0.], [1., 0., 0.], [1., 0., 0.], [0., 0., 0.]],
            &[[0., 0., 0.], [1., 1., 1.], [2., 2., 2.], [3., 3., 3.]],
            &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.]],
        ] {
            let (done, _) = face(ring);
            assert_eq!((done.degenerate_faces, done.triangles.len()), (1, 0), "{ring:?}");
        }
        let closed = face(&[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 0., 0.]]);
        assert_eq!((closed.0.degenerate_faces, closed.1.z), (0, 0.5));
    }

    /// A square with two holes has 16 - 1 - 1 = 14 m2 in two planes, whichever way the holes turn
    /// and wherever rings start.
    #[test]
    fn holes_are_left_out_of_the_area() {
        let square = |low: f64, high: f64, across: f64| {
            vec![[low, across, 0.], [high, across, 0.], [high, across + high - low, 0.], [low, across + high - low, 0.]]
        };
        let (outline, mut one, mut two) = (square(0., 4., 0.), square(1., 2., 1.), square(2.5, 3.5, 2.5));
        let mut found: Option<Vec<RawTriangle>> = None;
        for turn in 0..4 {
            one.rotate_left(1);
            if turn % 2 == 1 {
                two.reverse();
            }
            let (done, area) = with_holes(&[&outline, &one, &two]);
            assert_eq!((done.crossing_faces, done.concave_faces), (None, 1));
            assert!((area - DVec3::new(0., 0., 14.)).length() < 1e-12, "{area}");
            assert_eq!(done.triangles.len(), 14);
            assert_eq!(found.get_or_insert(done.triangles.clone()).len(), done.triangles.len());
        }
        let upright = |ring: &Vec<[f64; 3]>| ring.iter().map(|[x, y, _]| [7., *x, *y]).collect::<Vec<_>>();
        let (_, area) = with_holes(&[&upright(&outline), &upright(&one), &upright(&two)]);
        assert!((area - DVec3::new(14., 0., 0.)).length() < 1e-12, "{area}");
        // A hole of two corners is ignored.
        assert_eq!(with_holes(&[&outline, &[[1., 1., 0.], [2., 2., 0.]]]).1.z, 16.0);
    }

    /// A hole that reaches out of its outline is reported, and so is a face with a corner 0.4 m off
    /// its mean plane.
    #[test]
    fn holes_beyond_outlines_are_reported() {
        let outline = [[0., 0., 0.], [4., 0., 0.], [4., 4., 0.], [0., 4., 0.]];
        let (done, _) = with_holes(&[&outline, &[[3., 3., 0.], [6., 3., 0.], [6., 3.5, 0.]]]);
        assert_eq!(done.crossing_faces, Some((1, FaceLocation { line: 6, object: 0 })));
        let (done, _) = face(&[[0., 0., 0.], [4., 0., 0.], [4., 4., 1.6], [0., 4., 0.]]);
        assert_eq!(done.off_plane.0, 1);
        assert!((0.3..0.8).contains(&done.off_plane.1), "{}", done.off_plane.1);
    }

    /// An outline that crosses itself is reported with its line, and one beyond the limit is
    /// refused with its size.
    #[test]
    fn crossed_outlines_are_reported_by_line() {
        let (done, _) = face(&[[0., 0., 0.], [3., 0., 0.], [3., 3., 0.], [1., -1., 0.], [0., 3., 0.]]);
        assert_eq!(done.crossing_faces, Some((1, FaceLocation { line: 6, object: 0 })));

        let mut obj = Geometry::default();
        obj.vertices.push(DVec3::ZERO);
        (0..=MAX_CORNERS).for_each(|_| obj.push_corner(0));
        obj.end_face(0, 0, 2);
        let message = triangulate(&obj).expect_err("too large").to_string();
        assert!(message.contains("line 2 is 65537, the limit is 65536"), "{message}");
    }
}
