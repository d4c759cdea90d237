//! Places for modules on surfaces. In: receivers with their patches and sums. Out: the best places
//! of modules packed in rows.
//!
//! A module lies in the plane of its surface, with one side level. It fits where patches of that
//! plane lie below all of it. Each plane is packed in rows of one height, from its lower edge or a
//! part of a module above it, whichever holds most modules.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use heliotile_core::error::{Error, Result};
use heliotile_core::hemisphere::Frame;
use heliotile_core::site::patch::Patch;
use heliotile_core::text::message;

/// Receiver on a surface that may carry modules.
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

/// Place of a module.
#[derive(Clone, Debug, PartialEq)]
pub struct ModulePlace {
    /// Middle of the module on its surface, input coordinates, metres.
    pub middle: DVec3,
    /// Normal of the plane, unit length.
    pub normal: DVec3,
    /// Mean sum of the year over the module, kWh/m2.
    pub kwh_m2: f64,
    /// Mean cosine-weighted share of the hemisphere that is sky.
    pub sky_view: f64,
    /// Index of the receiver below the middle.
    pub candidate: usize,
}

/// Least cosine between the normals of faces of a building that lie in one plane; `SAME_PLANE_M` is
/// their largest distance.
const SAME_PLANE_COS: f64 = 0.999_8;
const SAME_PLANE_M: f64 = 0.05;
/// Cosine of the tilt below which a plane counts as flat: its modules follow its longest edge.
const FLAT_COS: f64 = 0.996;
/// Distance of the points of a module that must lie on patches, metres: narrower gaps may be
/// missed.
const PROBED_M: f64 = 0.2;
/// Steps up the plane between first rows that are tried, and along a row after a place where a
/// module does not fit, metres.
const ROW_STEP_M: f64 = 0.1;
const STEP_M: f64 = 0.05;
/// Width of gaps between neighbouring patches that are ignored, metres: patches are rounded to mm.
const GAP_M: f64 = 0.003;
/// Side of the squares of the spatial index of patches, metres.
const SQUARE_M: f64 = 2.0;
/// Number of steps of light, as a share of the most: modules in one step go row by row, since
/// smaller differences are noise.
const STEPS_OF_LIGHT: f64 = 1000.0;

/// Most places that are packed: each takes some 100 bytes.
const MAX_PLACES: u64 = 10_000_000;

/// Plane with its patches.
struct Plane {
    frame: Frame,
    origin: DVec3,
    /// Convex polygons of the patches, in the plane, with the index of their receiver.
    polygons: Vec<(usize, Vec<DVec2>)>,
    /// Indices of the polygons that reach into each square.
    squares: HashMap<[i64; 2], Vec<u32>>,
}

/// Returns the `count` best places of modules of `size` m, width and height: the most light first,
/// and row by row where it is equal. Fails if the surfaces may hold more than ten million.
pub fn best_places(candidates: &[PlaceCandidate], size: [f64; 2], count: usize) -> Result<Vec<ModulePlace>> {
    let size = DVec2::from(size);
    let planes = planes(candidates);
    let room = |plane: &Plane| {
        let [low, high] = plane.bounds();
        ((high - low) / size).max(DVec2::ZERO).element_product()
    };
    let value = planes.iter().map(room).sum::<f64>() as u64;
    if value > MAX_PLACES {
        let what = message!("the number of places on the chosen surfaces (a larger {{module}} has fewer)");
        return Err(Error::Limit { what, value, max: MAX_PLACES });
    }
    let mut found: Vec<ModulePlace> = planes.par_iter().flat_map_iter(|plane| plane.packed(size, candidates)).collect();
    let most = found.iter().map(|place| place.kwh_m2).fold(f64::MIN_POSITIVE, f64::max);
    let step = |place: &ModulePlace| (place.kwh_m2 / most * STEPS_OF_LIGHT).round();
    found.sort_by(|a, b| step(b).total_cmp(&step(a)));
    found.truncate(count);
    Ok(found)
}

/// Returns the planes of all candidates.
fn planes(candidates: &[PlaceCandidate]) -> Vec<Plane> {
    let mut members: Vec<(DVec3, DVec3, Vec<usize>)> = Vec::new();
    let mut of_face: HashMap<(&str, &str), Vec<usize>> = HashMap::new();
    for (index, candidate) in candidates.iter().enumerate() {
        let of_face = of_face.entry((&candidate.building, &candidate.face)).or_default();
        let holds = |(origin, normal, _): &(DVec3, DVec3, Vec<usize>)| {
            let off = normal.dot(candidate.position - origin).abs();
            normal.dot(candidate.normal) >= SAME_PLANE_COS && off <= SAME_PLANE_M
        };
        match of_face.iter().copied().find(|&number| holds(&members[number])) {
            Some(number) => members[number].2.push(index),
            None => {
                of_face.push(members.len());
                members.push((candidate.position, candidate.normal, vec![index]));
            }
        }
    }
    members.iter().map(|(origin, normal, of_plane)| Plane::new(*origin, *normal, of_plane, candidates)).collect()
}

/// Returns the square that a point lies in.
fn square_of(place: DVec2) -> [i64; 2] {
    (place / SQUARE_M).floor().to_array().map(|square| square as i64)
}

/// Returns the corners of the patches of a receiver, input coordinates.
fn corners(candidate: &PlaceCandidate) -> impl Iterator<Item = Vec<DVec3>> {
    let corner = |mm: &[i32; 3]| candidate.position + DVec3::from(mm.map(f64::from)) / 1e3;
    candidate.patch.polygons().iter().map(move |polygon| polygon.iter().map(corner).collect())
}

impl Plane {
    /// Returns the plane of some receivers.
    fn new(origin: DVec3, normal: DVec3, members: &[usize], candidates: &[PlaceCandidate]) -> Self {
        let polygons = || members.iter().flat_map(|&index| corners(&candidates[index]).map(move |ring| (index, ring)));
        let frame = match normal.z.abs() >= FLAT_COS {
            true => along_longest_edge(normal, polygons().map(|(_, ring)| ring)),
            false => Frame::new(normal),
        };
        let mut plane = Plane { frame, origin, polygons: Vec::new(), squares: HashMap::new() };
        for (index, ring) in polygons() {
            let flat: Vec<DVec2> = ring.into_iter().map(|corner| plane.flat(corner)).collect();
            let [low, high] = bounds(flat.iter().copied());
            let ([x0, y0], [x1, y1]) = (square_of(low - GAP_M), square_of(high + GAP_M));
            let number = plane.polygons.len() as u32;
            for (x, y) in (x0..=x1).flat_map(|x| (y0..=y1).map(move |y| (x, y))) {
                plane.squares.entry([x, y]).or_default().push(number);
            }
            plane.polygons.push((index, flat));
        }
        plane
    }

    /// Returns the lowest and the highest coordinates of the patches.
    fn bounds(&self) -> [DVec2; 2] {
        bounds(self.polygons.iter().flat_map(|(_, corners)| corners).copied())
    }

    fn flat(&self, p: DVec3) -> DVec2 {
        let from = p - self.origin;
        DVec2::new(self.frame.u.dot(from), self.frame.v.dot(from))
    }

    /// Returns the modules of the packing that holds most of them, row by row from below.
    fn packed(&self, size: DVec2, candidates: &[PlaceCandidate]) -> Vec<ModulePlace> {
        let [low, high] = self.bounds();
        let firsts = (0..).map(|step| f64::from(step) * ROW_STEP_M).take_while(|first| *first < size.y);
        let mut best: Vec<DVec2> = Vec::new();
        for first in firsts {
            let rows = (0..).map(|row| low.y + first + (f64::from(row) + 0.5) * size.y);
            let rows = rows.take_while(|middle| middle + 0.5 * size.y <= high.y + GAP_M);
            let found: Vec<DVec2> = rows.flat_map(|middle| self.row(middle, [low.x, high.x], size)).collect();
            if found.len() > best.len() {
                best = found;
            }
        }
        best.into_iter().filter_map(|middle| self.place(middle, size, candidates)).collect()
    }

    /// Returns the middles of the modules of a row, from the left.
    fn row(&self, y: f64, [left, right]: [f64; 2], size: DVec2) -> Vec<DVec2> {
        let (mut found, mut x) = (Vec::new(), left + 0.5 * size.x);
        while x + 0.5 * size.x <= right + GAP_M {
            let middle = DVec2::new(x, y);
            let fits = probes(middle, size).all(|point| self.below(point).is_some());
            if fits {
                found.push(middle);
            }
            x += if fits { size.x } else { STEP_M };
        }
        found
    }

    /// Returns the place of a module that fits.
    fn place(&self, middle: DVec2, size: DVec2, candidates: &[PlaceCandidate]) -> Option<ModulePlace> {
        // Points on the edges may lie on patches of neighbours.
        let inner = (size - PROBED_M).max(DVec2::ZERO);
        let below: Vec<&PlaceCandidate> =
            probes(middle, inner).filter_map(|point| Some(&candidates[self.below(point)?])).collect();
        let mean = |value: fn(&PlaceCandidate) -> f64| {
            below.iter().map(|one| value(one)).sum::<f64>() / below.len().max(1) as f64
        };
        Some(ModulePlace {
            middle: self.origin + middle.x * self.frame.u + middle.y * self.frame.v,
            normal: self.frame.n,
            kwh_m2: mean(|one| one.kwh_m2),
            sky_view: mean(|one| one.sky_view),
            candidate: self.below(middle)?,
        })
    }

    /// Returns the receiver whose patch a point lies on.
    fn below(&self, p: DVec2) -> Option<usize> {
        let here = self.squares.get(&square_of(p)).map_or(&[][..], Vec::as_slice);
        let polygons = here.iter().map(|&number| &self.polygons[number as usize]);
        polygons.filter(|(_, polygon)| holds_point(polygon, p)).map(|(index, _)| *index).next()
    }
}

/// Returns the lowest and the highest coordinates of some points.
fn bounds(points: impl Iterator<Item = DVec2>) -> [DVec2; 2] {
    points.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// Returns the frame of a flat plane whose rows follow its longest edge.
fn along_longest_edge(normal: DVec3, polygons: impl Iterator<Item = Vec<DVec3>>) -> Frame {
    let edges = polygons.flat_map(|ring| {
        let next = ring.clone().into_iter().cycle().skip(1);
        ring.into_iter().zip(next).map(|(a, b)| b - a).collect::<Vec<_>>()
    });
    let longest = edges.fold(DVec3::ZERO, |longest, edge| {
        // Edges of cells are equally long up to rounding: the first one counts.
        if edge.length() > longest.length() + GAP_M { edge } else { longest }
    });
    let v = normal.cross(longest).normalize_or_zero();
    if v == DVec3::ZERO { Frame::new(normal) } else { Frame { u: v.cross(normal), v, n: normal } }
}

/// Returns the points of a module that patches must lie below.
fn probes(middle: DVec2, size: DVec2) -> impl Iterator<Item = DVec2> {
    let steps = (size / PROBED_M).ceil().max(DVec2::ONE);
    let (columns, rows) = (steps.x as usize, steps.y as usize);
    let points = (0..=rows).flat_map(move |row| (0..=columns).map(move |column| (column, row)));
    points.map(move |(column, row)| {
        let share = DVec2::new(column as f64, row as f64) / steps - 0.5;
        middle + share * (size - 2.0 * GAP_M)
    })
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

    /// On 6 x 4 m, 12 modules of 1 x 2 m fit in two rows, the brightest first, and 10 of 1.1 x 1.8
    /// m. Two modules of 3 x 3 m fit, none of 7 x 1 m; no two places of 1.5 x 1.3 m overlap, and
    /// their light is the mean of the squares below them. Modules of 1 mm are too many.
    #[test]
    fn modules_are_packed_in_rows() {
        let all = roof(6);
        let packed = |size, count| best_places(&all, size, count).expect("few places");
        let count = |size| packed(size, 99).len();
        let sizes = [[1.0, 2.0], [1.1, 1.8], [3.0, 3.0], [7.0, 1.0]];
        assert_eq!(sizes.map(count), [12, 10, 2, 0]);
        let best = packed([1.0, 2.0], 3);
        let brightest = all.iter().map(|one| one.kwh_m2).fold(0.0, f64::max);
        assert_eq!(best.iter().map(|place| place.kwh_m2).collect::<Vec<_>>(), [brightest, brightest, brightest - 10.0]);
        assert!(best_places(&all, [0.001, 0.001], 3).is_err());
        let few = packed([1.5, 1.3], 99);
        assert_eq!(few.len(), 12);
        let Frame { u, v, .. } = Frame::new(all[0].normal);
        for (i, j) in (0..few.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let apart = few[i].middle - few[j].middle;
            assert!(u.dot(apart).abs() >= 1.5 - 1e-9 || v.dot(apart).abs() >= 1.3 - 1e-9);
        }
        let dark = few.iter().map(|place| place.kwh_m2).fold(f64::INFINITY, f64::min);
        let lowest = all.iter().map(|one| one.kwh_m2).fold(f64::INFINITY, f64::min);
        assert!(dark > lowest + 1.0 && dark < lowest + 5.0, "{dark} {lowest}");
    }

    /// A flat roof of 4 x 3 m that is turned by 30 degrees carries 12 modules of 1 x 1 m: rows
    /// follow its edges.
    #[test]
    fn rows_follow_the_edges_of_a_flat_roof() {
        let (u, v) = (DVec3::new(0.75_f64.sqrt(), 0.5, 0.0), DVec3::new(-0.5, 0.75_f64.sqrt(), 0.0));
        let mut all = roof(3);
        for (number, one) in all.iter_mut().enumerate() {
            (one.position, one.normal) = (u * (number % 4) as f64 + v * (number / 4) as f64, DVec3::Z);
            let corner = |x: f64, y: f64| u * x + v * y;
            let [a, b, c, d] = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| corner(x, y));
            one.patch = Patch::of_triangles(DVec3::ZERO, DVec3::Z, &[[a, b, c], [a, c, d]]);
        }
        assert_eq!(best_places(&all, [1.0, 1.0], 99).expect("few places").len(), 12);
    }

    /// Two places of 1.2 x 1 m reach over the middle column of three in each of four rows; with a
    /// gap of 0.3 m between patches there is none. Receivers without patches carry no module.
    #[test]
    fn no_module_reaches_over_a_gap() {
        let mut all = roof(3);
        let count = |all: &[PlaceCandidate], size| best_places(all, size, 99).expect("few places").len();
        assert_eq!(count(&all, [1.2, 1.0]), 8);
        let u = Frame::new(all[0].normal).u;
        all[4..].iter_mut().for_each(|candidate| candidate.position += u * 0.3);
        all[8..].iter_mut().for_each(|candidate| candidate.position += u * 0.3);
        assert_eq!(count(&all, [1.2, 1.0]), 0);
        all.iter_mut().for_each(|candidate| candidate.patch = Patch::default());
        assert_eq!(count(&all, [0.1, 0.1]), 0);
    }
}
