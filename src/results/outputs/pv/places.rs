//! Places for modules on surfaces. In: receivers with their patches and sums. Out: the best places
//! on which a module fits beside those before.
//!
//! A module lies in the plane of its surface with its middle on a receiver and one side horizontal.
//! It fits if the patches of that plane lie below all of it.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use heliotile_core::hemisphere::Frame;
use heliotile_core::site::patch::Patch;

/// Receiver that the middle of a module may lie on.
#[derive(Clone, Debug)]
pub struct PlaceCandidate {
    /// Position in input coordinates, metres.
    pub position: DVec3,
    /// Normal of unit length.
    pub normal: DVec3,
    /// Part of the surface that the receiver stands for.
    pub patch: Patch,
    /// Sum of the year, kWh/m2.
    pub kwh_m2: f64,
    /// Cosine-weighted share of the hemisphere that is sky.
    pub sky_view: f64,
    pub receiver: String,
    pub face: String,
    pub building: String,
}

/// Least cosine between the normals of faces of a building that lie in one plane; `SAME_PLANE_M` is
/// their largest distance.
const SAME_PLANE_COS: f64 = 0.999_8;
const SAME_PLANE_M: f64 = 0.05;
/// Distance of the points of a module that must lie on patches, metres: narrower gaps may be
/// missed.
const PROBED_M: f64 = 0.2;
/// Width of gaps between neighbouring patches that are ignored, metres: patches are rounded to mm.
const GAP_M: f64 = 0.003;
/// Side of the squares of the spatial index of patches, metres.
const SQUARE_M: f64 = 2.0;

/// Plane with its patches and modules.
struct Plane {
    frame: Frame,
    origin: DVec3,
    /// Convex polygons of the patches, in the plane.
    polygons: Vec<Vec<DVec2>>,
    /// Indices of the polygons that reach into each square.
    squares: HashMap<[i64; 2], Vec<u32>>,
    /// Middles of modules that are placed there.
    taken: Vec<DVec2>,
}

/// Returns the `count` best places of modules of `size` m, width and height, the best first.
pub fn best_places(candidates: &[PlaceCandidate], size: [f64; 2], count: usize) -> Vec<usize> {
    let (mut planes, of_candidate) = planes(candidates);
    let mut order: Vec<usize> = (0..candidates.len()).collect();
    let key = |i: usize| &candidates[i];
    order.sort_by(|&a, &b| key(b).kwh_m2.total_cmp(&key(a).kwh_m2).then(key(a).receiver.cmp(&key(b).receiver)));
    let size = DVec2::from(size);
    let mut found = Vec::new();
    for i in order {
        if found.len() == count {
            break;
        }
        let plane = &mut planes[of_candidate[i]];
        let middle = plane.flat(candidates[i].position);
        let is_free = plane.taken.iter().all(|other| ((middle - other).abs() - size).max_element() >= -1e-9);
        if is_free && plane.carries(middle, size) {
            plane.taken.push(middle);
            found.push(i);
        }
    }
    found
}

/// Returns the planes of all candidates, and the index of each candidate's plane.
fn planes(candidates: &[PlaceCandidate]) -> (Vec<Plane>, Vec<usize>) {
    let mut planes: Vec<Plane> = Vec::new();
    let mut of_face: HashMap<(&str, &str), Vec<usize>> = HashMap::new();
    let mut of_candidate = Vec::with_capacity(candidates.len());
    for candidate in candidates {
        let of_face = of_face.entry((&candidate.building, &candidate.face)).or_default();
        let number = of_face.iter().copied().find(|&number| planes[number].holds(candidate)).unwrap_or_else(|| {
            let (frame, origin) = (Frame::new(candidate.normal), candidate.position);
            planes.push(Plane { frame, origin, polygons: Vec::new(), squares: HashMap::new(), taken: Vec::new() });
            of_face.push(planes.len() - 1);
            planes.len() - 1
        });
        planes[number].add(candidate);
        of_candidate.push(number);
    }
    (planes, of_candidate)
}

/// Returns the square that a point lies in.
fn square_of(place: DVec2) -> [i64; 2] {
    (place / SQUARE_M).floor().to_array().map(|square| square as i64)
}

impl Plane {
    fn flat(&self, p: DVec3) -> DVec2 {
        let from = p - self.origin;
        DVec2::new(self.frame.u.dot(from), self.frame.v.dot(from))
    }

    fn holds(&self, candidate: &PlaceCandidate) -> bool {
        let off = self.frame.n.dot(candidate.position - self.origin).abs();
        self.frame.n.dot(candidate.normal) >= SAME_PLANE_COS && off <= SAME_PLANE_M
    }

    fn add(&mut self, candidate: &PlaceCandidate) {
        for polygon in candidate.patch.polygons() {
            let corner = |mm: &[i32; 3]| self.flat(candidate.position + DVec3::from(mm.map(f64::from)) / 1e3);
            let corners: Vec<DVec2> = polygon.iter().map(corner).collect();
            let low = corners.iter().fold(DVec2::INFINITY, |low, p| low.min(*p)) - GAP_M;
            let high = corners.iter().fold(DVec2::NEG_INFINITY, |high, p| high.max(*p)) + GAP_M;
            let ([x0, y0], [x1, y1]) = (square_of(low), square_of(high));
            let number = self.polygons.len() as u32;
            for (x, y) in (x0..=x1).flat_map(|x| (y0..=y1).map(move |y| (x, y))) {
                self.squares.entry([x, y]).or_default().push(number);
            }
            self.polygons.push(corners);
        }
    }

    /// Returns true if patches lie below all of a module.
    fn carries(&self, middle: DVec2, size: DVec2) -> bool {
        let steps = (size / PROBED_M).ceil().max(DVec2::ONE);
        let (columns, rows) = (steps.x as usize, steps.y as usize);
        let mut points = (0..=rows).flat_map(|row| (0..=columns).map(move |column| (column, row)));
        points.all(|(column, row)| {
            let share = DVec2::new(column as f64, row as f64) / steps - 0.5;
            self.is_covered(middle + share * (size - 2.0 * GAP_M))
        })
    }

    fn is_covered(&self, p: DVec2) -> bool {
        let here = self.squares.get(&square_of(p)).map_or(&[][..], Vec::as_slice);
        here.iter().any(|&number| holds_point(&self.polygons[number as usize], p))
    }
}

/// Returns true if a point lies in a convex anticlockwise polygon, or within the gap around it.
fn holds_point(polygon: &[DVec2], p: DVec2) -> bool {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).all(|(a, b)| {
        let along = *b - *a;
        along.perp_dot(p - *a) >= -GAP_M * along.length()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a roof of `columns` x 4 squares of 1 m on a slope of 30 degrees to the south,
    /// brighter towards the east.
    fn roof(columns: usize) -> Vec<PlaceCandidate> {
        let normal = DVec3::new(0.0, -0.5, 0.75_f64.sqrt());
        let Frame { u, v, .. } = Frame::new(normal);
        let candidate = |column: usize, row: usize| PlaceCandidate {
            position: DVec3::new(100.0, 200.0, 10.0) + u * column as f64 + v * row as f64,
            normal,
            patch: Patch::square(normal, 1.0),
            kwh_m2: 1000.0 + 10.0 * u.x.signum() * column as f64,
            sky_view: 1.0,
            receiver: format!("{column}/{row}"),
            face: "roof".into(),
            building: "b".into(),
        };
        (0..columns).flat_map(|column| (0..4).map(move |row| (column, row))).map(|(c, r)| candidate(c, r)).collect()
    }

    /// On 6 x 4 m, 6 modules of 1 x 2 m fit, with their middles on the two inner rows and the
    /// brightest first; none fits above another. Two modules of 3 x 3 m fit, none of 7 x 1 m, and
    /// no two places of 1.5 x 1.5 m overlap.
    #[test]
    fn modules_fit_without_overlap() {
        let all = roof(6);
        let names = |size, count| -> Vec<String> {
            best_places(&all, size, count).into_iter().map(|i| all[i].receiver.clone()).collect()
        };
        let ends = names([1.0, 2.0], 99);
        assert_eq!(ends.len(), 6);
        let brightest =
            all.iter().max_by(|a, b| a.kwh_m2.total_cmp(&b.kwh_m2)).map_or("", |found| &found.receiver[..1]);
        assert!(ends[0].starts_with(brightest) && ends.iter().all(|name| name.ends_with("/1") || name.ends_with("/2")));
        assert_eq!((names([3.0, 3.0], 99).len(), names([7.0, 1.0], 99).len(), names([1.0, 2.0], 2).len()), (2, 0, 2));
        let few = best_places(&all, [1.5, 1.5], 99);
        let Frame { u, v, .. } = Frame::new(all[0].normal);
        for (a, b) in few.iter().flat_map(|a| few.iter().map(move |b| (a, b))).filter(|(a, b)| a != b) {
            let apart = all[*a].position - all[*b].position;
            assert!(u.dot(apart).abs().max(v.dot(apart).abs()) >= 1.5 - 1e-9);
        }
    }

    /// Receivers without patches carry no module. 4 places reach over both sides of the middle
    /// column; with a gap of 0.3 m between patches there is none.
    #[test]
    fn no_module_reaches_over_a_gap() {
        let mut all = roof(3);
        assert_eq!(best_places(&all, [1.2, 1.0], 99).len(), 4);
        let u = Frame::new(all[0].normal).u;
        all[8..].iter_mut().for_each(|candidate| candidate.position += u * 0.3);
        assert!(best_places(&all, [1.2, 1.0], 99).is_empty());
        all.iter_mut().for_each(|candidate| candidate.patch = Patch::default());
        assert!(best_places(&all, [0.1, 0.1], 99).is_empty());
    }
}
