//! Solids that stand twice in one object, cut into other faces. In: the shells of an object. Out:
//! the faces of the second copy.
//!
//! A solid stands twice if the faces in each of its planes are two sets, none of which overlaps
//! itself and both of which cover the same area. Equal faces are found by `twins`.

use std::collections::HashMap;

use glam::DVec3;

use super::shells::{Shell, pairs_of_one_edge};
use super::twins;
use crate::geometry::Geometry;
use crate::polygon::triangles_of;
use heliotile_core::site::morton::lexicographic;

/// Largest distance of a corner from the plane of another face in which it lies, metres.
const FLAT_M: f64 = 1e-3;
/// Least cosine of the angle between normals of one plane.
const PARALLEL: f64 = 0.999;
/// Error of sums of areas that is a rounding error, as a share.
const ROUNDING: f64 = 1e-6;
/// Most faces of a solid whose copies are searched: pairs of faces are compared.
const MAX_FACES: usize = 2000;

/// Returns the faces of second copies among the shells of an object.
pub(super) fn second_copies(geometry: &Geometry, welded: &[u32], shells: &[Shell]) -> Vec<usize> {
    // Copies that share no edge are shells of their own with one bounding box.
    let mut by_box: HashMap<[[i64; 3]; 2], Vec<&Shell>> = HashMap::new();
    for shell in shells.iter().filter(|shell| shell.is_balanced) {
        let key = [shell.low, shell.high].map(|corner| (corner / FLAT_M).round().to_array().map(|steps| steps as i64));
        by_box.entry(key).or_default().push(shell);
    }
    let groups = by_box.into_values().filter(|group| group.len() > 1 || group.iter().any(|shell| shell.is_crowded));
    let mut found: Vec<usize> = groups.flat_map(|group| second_copy(geometry, welded, &group)).collect();
    // The map has no order of its own.
    found.sort_unstable();
    found
}

/// A face in its plane.
struct Flat {
    number: usize,
    triangles: Vec<[DVec3; 3]>,
    normal: DVec3,
    area_m2: f64,
    /// Least corner of its bounding box, and the greatest one.
    bounds: [DVec3; 2],
}

/// Returns the faces of the second copy of a solid; none if the solid does not stand twice.
fn second_copy(geometry: &Geometry, welded: &[u32], shells: &[&Shell]) -> Vec<usize> {
    let mut numbers: Vec<usize> = shells.iter().flat_map(|shell| shell.faces.iter().copied()).collect();
    numbers.sort_unstable();
    if numbers.len() > MAX_FACES || 2 * twins::within(geometry, welded, &numbers).len() == numbers.len() {
        return Vec::new();
    }
    let mut planes: Vec<Vec<Flat>> = Vec::new();
    for face in numbers.iter().filter_map(|number| flat_face(geometry, *number)) {
        let plane = planes.iter_mut().find(|plane| plane.first().is_some_and(|first| lies_in(&face, first)));
        match plane {
            Some(plane) => plane.push(face),
            None => planes.push(vec![face]),
        }
    }
    let second = planes.iter().map(|plane| second_cover(geometry, welded, plane));
    second.collect::<Option<Vec<_>>>().unwrap_or_default().concat()
}

/// Returns a face in its plane; `None` for one without an area.
fn flat_face(geometry: &Geometry, number: usize) -> Option<Flat> {
    let triangles = triangles_of(geometry, number);
    let area: DVec3 = triangles.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a)).sum();
    let (low, high) = crate::mesh::bounds(triangles.iter().flatten().copied());
    let normal = area.try_normalize()?;
    Some(Flat { number, triangles, normal, area_m2: area.length(), bounds: [low, high] })
}

fn lies_in(face: &Flat, other: &Flat) -> bool {
    let from = other.triangles.first().map_or(DVec3::ZERO, |[a, ..]| *a);
    let off_m = |corner: &DVec3| (*corner - from).dot(other.normal).abs();
    face.normal.dot(other.normal) > PARALLEL && face.triangles.iter().flatten().all(|corner| off_m(corner) < FLAT_M)
}

/// Returns the faces of the second of two sets that cover the same area of a plane; `None` if the
/// faces are no such sets.
fn second_cover(geometry: &Geometry, welded: &[u32], plane: &[Flat]) -> Option<Vec<usize>> {
    let all_m2: f64 = plane.iter().map(|face| face.area_m2).sum();
    let is_same = |a: f64, b: f64| (a - b).abs() <= ROUNDING * all_m2;
    // Faces that meet at an edge of their own belong to one copy.
    let numbers: Vec<usize> = plane.iter().map(|face| face.number).collect();
    let mut set_of: Vec<usize> = (0..plane.len()).collect();
    for (a, b) in pairs_of_one_edge(geometry, welded, &numbers) {
        let (Some(&one), Some(&other)) = (set_of.get(a), set_of.get(b)) else { continue };
        set_of.iter_mut().filter(|set| **set == other).for_each(|set| *set = one);
    }
    let mut sets: HashMap<usize, Vec<&Flat>> = HashMap::new();
    for (face, set) in plane.iter().zip(&set_of) {
        sets.entry(*set).or_default().push(face);
    }
    let mut sets: Vec<Vec<&Flat>> = sets.into_values().collect();
    // The order of the file decides nothing.
    sets.iter_mut().for_each(|set| set.sort_by(|a, b| lexicographic(middle(a), middle(b))));
    sets.sort_by(|a, b| {
        let first = |set: &[&Flat]| set.first().map_or(DVec3::ZERO, |face| middle(face));
        lexicographic(first(a), first(b))
    });
    let (mut kept, mut second): (Vec<&Flat>, Vec<&Flat>) = (Vec::new(), Vec::new());
    for set in sets {
        let is_free = shared_m2(&kept, &set) <= ROUNDING * all_m2;
        if is_free { kept.extend(set) } else { second.extend(set) }
    }
    let area = |faces: &[&Flat]| faces.iter().map(|face| face.area_m2).sum::<f64>();
    let is_cover = |faces: &[&Flat]| is_same(2.0 * area(faces), all_m2) && is_same(overlap_m2(faces), 0.0);
    let is_twice = is_cover(&kept) && is_cover(&second) && is_same(2.0 * shared_m2(&kept, &second), all_m2);
    is_twice.then(|| second.iter().map(|face| face.number).collect())
}

fn middle(face: &Flat) -> DVec3 {
    face.triangles.iter().flatten().sum::<DVec3>() / (3 * face.triangles.len()).max(1) as f64
}

/// Returns the area that faces of one plane share with each other, m2.
fn overlap_m2(faces: &[&Flat]) -> f64 {
    let later = |i: usize| faces.get(i + 1..).unwrap_or_default();
    faces.iter().enumerate().map(|(i, face)| shared_m2(&[*face], later(i))).sum()
}

/// Returns the area that two sets of faces of one plane share, m2, counted for each pair of faces.
fn shared_m2(faces: &[&Flat], others: &[&Flat]) -> f64 {
    let meets = |[low, high]: [DVec3; 2], [other_low, other_high]: [DVec3; 2]| {
        low.cmple(other_high + FLAT_M).all() && other_low.cmple(high + FLAT_M).all()
    };
    let pairs = faces.iter().flat_map(|face| others.iter().map(move |other| (face, other)));
    let near = pairs.filter(|(face, other)| meets(face.bounds, other.bounds));
    let of_pair = |(face, other): (&&Flat, &&Flat)| -> f64 {
        let triangles = face.triangles.iter().flat_map(|one| other.triangles.iter().map(move |two| (one, two)));
        triangles.map(|(one, two)| common_m2(*one, *two, face.normal)).sum()
    };
    near.map(of_pair).sum()
}

/// Returns the area that two triangles of a plane share, m2: the first one cut along each side of
/// the second (Sutherland and Hodgman, "Reentrant polygon clipping", 1974).
fn common_m2(one: [DVec3; 3], two: [DVec3; 3], normal: DVec3) -> f64 {
    let mut left = one.to_vec();
    let [a, b, c] = two;
    for (from, to) in [(a, b), (b, c), (c, a)] {
        let inwards = normal.cross(to - from);
        let within = |corner: DVec3| (corner - from).dot(inwards);
        let mut cut = Vec::with_capacity(left.len() + 1);
        for (this, next) in left.iter().zip(left.iter().cycle().skip(1)) {
            let (here, there) = (within(*this), within(*next));
            if here >= 0.0 {
                cut.push(*this);
            }
            if here * there < 0.0 {
                cut.push(this.lerp(*next, here / (here - there)));
            }
        }
        left = cut;
    }
    let from = left.first().copied().unwrap_or_default();
    let area: DVec3 = left.array_windows::<2>().map(|[a, b]| 0.5 * (*a - from).cross(*b - from)).sum();
    area.dot(normal).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Halves of a square of 100 m2 along its two diagonals share 25 m2, the halves of one diagonal
    /// nothing, and a half shares 50 m2 with itself.
    #[test]
    fn halves_of_a_square_share_a_quarter() {
        let [a, b, c, d] = [(0., 0.), (10., 0.), (10., 10.), (0., 10.)].map(|(x, y)| DVec3::new(x, y, 3.0));
        for (one, two, expected) in
            [([a, b, c], [a, b, d], 25.0), ([a, b, c], [a, c, d], 0.0), ([a, b, c], [a, b, c], 50.0)]
        {
            assert!((common_m2(one, two, DVec3::Z) - expected).abs() < 1e-9);
        }
    }
}
