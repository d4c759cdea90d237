//! Outlines that cross themselves. In: outlines. Out: outlines that crossed themselves once, their
//! corners reordered so that they do not.
//!
//! An outline in which two neighbouring corners changed places crosses itself at one point.
//! Reversing the corners between the two crossing edges repairs it, and for four corners nothing
//! else does (the 2-opt move of Croes, Operations Research 6, 1958).

use glam::{DVec2, DVec3};

use crate::geometry::Geometry;

/// Most corners of an outline that is searched: comparing all edges costs the square of this.
const MAX_CORNERS: usize = 64;
/// Share of the outline's size squared below which crossing edges count as touching.
const TOUCHING: f64 = 1e-9;

/// Reorders the corners of outlines that cross themselves once; returns the numbers of their faces.
pub(super) fn uncross(geometry: &mut Geometry) -> Vec<usize> {
    let mut found = Vec::new();
    for face in geometry.faces() {
        let outline = face.rings().next().unwrap_or_default();
        if (4..=MAX_CORNERS).contains(&outline.len())
            && let Some(order) = uncrossed(outline, &geometry.vertices)
        {
            found.push((face.number, order));
        }
    }
    for (face, order) in &found {
        geometry.reorder_outline(*face, order);
    }
    found.into_iter().map(|(face, _)| face).collect()
}

fn uncrossed(outline: &[u32], vertices: &[DVec3]) -> Option<Vec<u32>> {
    let points: Vec<DVec3> =
        outline.iter().map(|&corner| vertices.get(corner as usize).copied().unwrap_or_default()).collect();
    let flat = flattened(&points)?;
    if is_convex(&flat) {
        return None;
    }
    let [crossing] = crossings(&flat)[..] else { return None };
    let mut order: Vec<usize> = (0..outline.len()).collect();
    let (first, second) = crossing;
    order.get_mut(first + 1..=second)?.reverse();
    let sorted: Vec<DVec2> = order.iter().filter_map(|&i| flat.get(i).copied()).collect();
    if !crossings(&sorted).is_empty() {
        return None;
    }
    order.iter().map(|&i| outline.get(i).copied()).collect()
}

/// Projects corners to the plane of the largest triangle that they span; `None` if they span none.
/// The mean normal would not do: for a crossed outline it may be zero.
fn flattened(points: &[DVec3]) -> Option<Vec<DVec2>> {
    let (&first, rest) = points.split_first()?;
    let arms: Vec<DVec3> = rest.iter().map(|point| *point - first).collect();
    let mut normal = DVec3::ZERO;
    for (i, a) in arms.iter().enumerate() {
        for b in arms.iter().skip(i + 1) {
            let cross = a.cross(*b);
            if cross.length_squared() > normal.length_squared() {
                normal = cross;
            }
        }
    }
    let normal = normal.try_normalize()?;
    let (u, v) = normal.any_orthonormal_pair();
    Some(points.iter().map(|point| DVec2::new((*point - first).dot(u), (*point - first).dot(v))).collect())
}

/// Returns the corner at a place; the one after the last is the first.
fn corner(flat: &[DVec2], place: usize) -> DVec2 {
    flat.get(place % flat.len().max(1)).copied().unwrap_or_default()
}

/// Returns true for a quadrilateral that turns one way at all corners. Outlines of more corners may
/// turn one way and still go round twice.
fn is_convex(flat: &[DVec2]) -> bool {
    let turn = |i: usize| {
        let (a, b, c) = (corner(flat, i), corner(flat, i + 1), corner(flat, i + 2));
        (b - a).perp_dot(c - b)
    };
    flat.len() == 4 && ((0..4).all(|i| turn(i) > 0.0) || (0..4).all(|i| turn(i) < 0.0))
}

/// Returns the pairs of edges that cross, each edge by the number of the corner where it begins.
fn crossings(flat: &[DVec2]) -> Vec<(usize, usize)> {
    let count = flat.len();
    let size = flat.iter().map(|point| point.length()).fold(0.0, f64::max);
    let nothing = TOUCHING * size * size;
    let apart = |x: f64, y: f64| x.min(y) < -nothing && x.max(y) > nothing;
    let cross = |i: usize, j: usize| {
        let [p, q, r, s] = [corner(flat, i), corner(flat, i + 1), corner(flat, j), corner(flat, j + 1)];
        let side = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
        apart(side(p, q, r), side(p, q, s)) && apart(side(r, s, p), side(r, s, q))
    };
    let mut found = Vec::new();
    for i in 0..count {
        // Neighbouring edges share a corner.
        found.extend((i + 2..count).filter(|&j| (j + 1) % count != i && cross(i, j)).map(|j| (i, j)));
    }
    found
}
