//! Whether windows fit into a wall. In: outlines in space. Out: for each window whether it may be a hole of the wall.

use glam::{DVec2, DVec3};

use crate::formats::energyplus::place::{Frame, area_vector};

/// Windows this far off their wall or over its edge are taken for rounded coordinates, metres (EnergyPlus merges vertices closer
/// than this).
const ROUNDED_M: f64 = 0.01;
/// Comparisons of a wall's edges with its windows' beyond which no wall of a building goes.
const MOST_COMPARISONS: usize = 20_000_000;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Fit {
    /// A hole of the wall, moved onto its edge where it reaches over it by a hair.
    Hole(Vec<DVec3>),
    /// Takes up the whole wall.
    Whole,
    /// Reaches over the wall's edge, lies off its plane or over another window.
    Beyond,
}

/// How each opening fits into a wall.
pub(super) fn fit(wall: &[DVec3], frame: &Frame, openings: &[&[DVec3]]) -> Vec<Fit> {
    let (right, up) = (frame.right(), frame.up());
    let flat = |p: &DVec3| DVec2::new((*p - frame.origin).dot(right), (*p - frame.origin).dot(up));
    let outline: Vec<DVec2> = wall.iter().map(flat).collect();
    let corners: usize = openings.iter().map(|opening| opening.len()).sum();
    if corners.saturating_mul(wall.len() + corners) > MOST_COMPARISONS {
        return vec![Fit::Beyond; openings.len()];
    }
    let normal = right.cross(up);
    let area = area_vector(wall).length();
    let mut taken: Vec<Vec<DVec2>> = Vec::new();
    openings
        .iter()
        .map(|opening| {
            let ring: Vec<DVec2> = opening.iter().map(flat).collect();
            let on_plane = opening.iter().all(|p| (*p - frame.origin).dot(normal).abs() <= ROUNDED_M);
            let nearest: Vec<DVec2> =
                ring.iter().map(|&p| if contains(&outline, p) { p } else { nearest(&outline, p) }).collect();
            let off = ring.iter().zip(&nearest).map(|(p, near)| *near - *p);
            let inside = off.clone().all(|off| off.length() <= ROUNDED_M);
            let moved = opening.iter().zip(off).map(|(p, off)| *p + off.x * right + off.y * up).collect();
            if !on_plane || !inside || cross(&outline, &ring) || taken.iter().any(|other| overlap(other, &ring)) {
                return Fit::Beyond;
            }
            let share = area_vector(opening).length() / area;
            taken.push(ring);
            // Less than a millimetre in a metre is left of the wall.
            if share > 0.999 { Fit::Whole } else { Fit::Hole(moved) }
        })
        .collect()
}

fn edges(ring: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

/// By the number of edges to the right of a point.
fn contains(ring: &[DVec2], p: DVec2) -> bool {
    let crossed =
        |(a, b): &(DVec2, DVec2)| (a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x;
    edges(ring).filter(crossed).count() % 2 == 1
}

/// The point of a ring's edges that is next to a point.
fn nearest(ring: &[DVec2], p: DVec2) -> DVec2 {
    let on_edge = |(a, b): (DVec2, DVec2)| {
        let along = b - a;
        let share = (p - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        a + share.clamp(0.0, 1.0) * along
    };
    let closer = |a: &DVec2, b: &DVec2| a.distance_squared(p).total_cmp(&b.distance_squared(p));
    edges(ring).map(on_edge).min_by(closer).unwrap_or(DVec2::INFINITY)
}

/// Whether an edge of one ring crosses one of another by more than what rounding explains.
fn cross(a: &[DVec2], b: &[DVec2]) -> bool {
    edges(a).any(|(p, q)| edges(b).any(|(r, s)| crosses(p, q, r, s)))
}

fn crosses(p: DVec2, q: DVec2, r: DVec2, s: DVec2) -> bool {
    // Distance of a point from the line through two others, with its side.
    let side = |a: DVec2, b: DVec2, c: DVec2| (b - a).normalize_or_zero().perp_dot(c - a);
    let apart = |x: f64, y: f64| x.min(y) < -ROUNDED_M && x.max(y) > ROUNDED_M;
    apart(side(p, q, r), side(p, q, s)) && apart(side(r, s, p), side(r, s, q))
}

/// Whether two windows cover a common area.
fn overlap(a: &[DVec2], b: &[DVec2]) -> bool {
    let deep = |ring: &[DVec2], p: DVec2| contains(ring, p) && nearest(ring, p).distance(p) > ROUNDED_M;
    let middle = |ring: &[DVec2]| ring.iter().sum::<DVec2>() / ring.len().max(1) as f64;
    cross(a, b)
        || b.iter().any(|&p| deep(a, p))
        || a.iter().any(|&p| deep(b, p))
        || deep(a, middle(b))
        || deep(b, middle(a))
}
