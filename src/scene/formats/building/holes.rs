//! Fit of windows into a wall. In: outlines in space. Out: for each window, how it fits: as a hole,
//! as the whole wall, or not.

use glam::{DVec2, DVec3};

use crate::formats::building::frame::{Frame, area_vector};

/// Distance from a wall's plane or edge that is taken for rounding of a window's coordinates,
/// metres (EnergyPlus merges vertices closer than this).
pub(in crate::formats) const ROUNDED_M: f64 = 0.01;
/// Most comparisons of edges of a wall and its windows; no real wall needs more, and windows of a
/// wall that does are left out.
const MAX_COMPARISONS: usize = 20_000_000;

#[derive(Clone, Debug, PartialEq)]
pub(in crate::formats) enum Fit {
    /// A hole of the wall, moved onto the wall's edge where it reaches over it within rounding.
    Hole(Vec<DVec3>),
    /// An opening that takes up the whole wall.
    Whole,
    /// An opening that reaches over the wall's edge, lies off its plane or overlaps another window.
    Beyond,
}

/// A wall from which windows are cut.
pub(in crate::formats) struct Wall<'w> {
    pub outline: &'w [DVec3],
    /// Outlines that are cut out of it already.
    pub holes: &'w [Vec<DVec3>],
    /// Frame of its plane.
    pub frame: Frame,
    /// Error that coordinates may have, metres: at least [`ROUNDED_M`].
    pub rounded_m: f64,
}

/// Returns how each opening fits into a wall.
pub(in crate::formats) fn fit(wall: &Wall, openings: &[&[DVec3]]) -> Vec<Fit> {
    let (frame, rounded_m) = (&wall.frame, wall.rounded_m);
    let (right, up) = (frame.right(), frame.up());
    let flat = |p: &DVec3| DVec2::new((*p - frame.origin).dot(right), (*p - frame.origin).dot(up));
    let outline: Vec<DVec2> = wall.outline.iter().map(flat).collect();
    let taken_corners: usize = wall.holes.iter().map(Vec::len).sum();
    let corners = taken_corners + openings.iter().map(|opening| opening.len()).sum::<usize>();
    if corners.saturating_mul(wall.outline.len() + corners) > MAX_COMPARISONS {
        return vec![Fit::Beyond; openings.len()];
    }
    let normal = right.cross(up);
    let taken_area: f64 = wall.holes.iter().map(|hole| area_vector(hole).length()).sum();
    let area = area_vector(wall.outline).length() - taken_area;
    let mut taken: Vec<Vec<DVec2>> = wall.holes.iter().map(|hole| hole.iter().map(flat).collect()).collect();
    openings
        .iter()
        .map(|opening| {
            let ring: Vec<DVec2> = opening.iter().map(flat).collect();
            let on_plane = opening.iter().all(|p| (*p - frame.origin).dot(normal).abs() <= rounded_m);
            let nearest: Vec<DVec2> =
                ring.iter().map(|&p| if contains(&outline, p) { p } else { nearest(&outline, p) }).collect();
            let off = ring.iter().zip(&nearest).map(|(p, near)| *near - *p);
            let inside = off.clone().all(|off| off.length() <= rounded_m);
            let moved = opening.iter().zip(off).map(|(p, off)| *p + off.x * right + off.y * up).collect();
            let over = |other: &Vec<DVec2>| overlap(other, &ring, rounded_m);
            if !on_plane || !inside || cross(&outline, &ring, rounded_m) || taken.iter().any(over) {
                return Fit::Beyond;
            }
            // Avoids dividing by the area of a wall that has none; such a wall is not written.
            let share = area_vector(opening).length() / area.max(f64::MIN_POSITIVE);
            taken.push(ring);
            // Beyond this share, less than a millimetre in a metre is left of the wall.
            if share > 0.999 { Fit::Whole } else { Fit::Hole(moved) }
        })
        .collect()
}

fn edges(ring: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

/// Returns true if `p` lies inside a ring, by the number of edges to its right.
fn contains(ring: &[DVec2], p: DVec2) -> bool {
    let crossed =
        |(a, b): &(DVec2, DVec2)| (a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x;
    edges(ring).filter(crossed).count() % 2 == 1
}

/// Returns the point on the edges of a ring that is nearest to `p`.
fn nearest(ring: &[DVec2], p: DVec2) -> DVec2 {
    let on_edge = |(a, b): (DVec2, DVec2)| {
        let along = b - a;
        let share = (p - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        a + share.clamp(0.0, 1.0) * along
    };
    let closer = |a: &DVec2, b: &DVec2| a.distance_squared(p).total_cmp(&b.distance_squared(p));
    edges(ring).map(on_edge).min_by(closer).unwrap_or(DVec2::INFINITY)
}

/// Returns true if an edge of one ring crosses an edge of another by more than rounding explains.
fn cross(a: &[DVec2], b: &[DVec2], rounded_m: f64) -> bool {
    edges(a).any(|(p, q)| edges(b).any(|(r, s)| crosses([p, q], [r, s], rounded_m)))
}

fn crosses([p, q]: [DVec2; 2], [r, s]: [DVec2; 2], rounded_m: f64) -> bool {
    // Signed distance of `c` from the line through `a` and `b`.
    let side = |a: DVec2, b: DVec2, c: DVec2| (b - a).normalize_or_zero().perp_dot(c - a);
    let apart = |x: f64, y: f64| x.min(y) < -rounded_m && x.max(y) > rounded_m;
    apart(side(p, q, r), side(p, q, s)) && apart(side(r, s, p), side(r, s, q))
}

/// Returns true if two windows overlap.
fn overlap(a: &[DVec2], b: &[DVec2], rounded_m: f64) -> bool {
    let deep = |ring: &[DVec2], p: DVec2| contains(ring, p) && nearest(ring, p).distance(p) > rounded_m;
    let middle = |ring: &[DVec2]| ring.iter().sum::<DVec2>() / ring.len().max(1) as f64;
    cross(a, b, rounded_m)
        || b.iter().any(|&p| deep(a, p))
        || a.iter().any(|&p| deep(b, p))
        || deep(a, middle(b))
        || deep(b, middle(a))
}
