//! Regions of a face. In: patches around receivers. Out: groups of patches that are connected by
//! their edges.

use glam::{DVec2, DVec3};

use heliotile_core::hemisphere::Frame;
use heliotile_core::site::patch::Patch;

/// Largest distance of edges that touch, mm: corners are rounded to whole mm on both sides, and
/// corners within 1 mm of a straight edge are left out.
const TOUCH_MM: f64 = 3.0;

/// Least length of a shared edge, mm; patches that share less only meet at a corner.
const SHARED_MM: f64 = 20.0;

/// Outlines of a patch in the plane of a face, mm.
struct Outline {
    polygons: Vec<Vec<DVec2>>,
    low: DVec2,
    high: DVec2,
}

/// Returns the index of the region of each patch, `[patch]`, counted from 0 in the order of first
/// patches. Each patch comes with its receiver's position, metres; `normal` is the unit normal of
/// the face.
pub fn regions(normal: DVec3, patches: &[(DVec3, &Patch)]) -> Vec<usize> {
    let origin = patches.first().map_or(DVec3::ZERO, |(place, _)| *place);
    let outlines: Vec<Outline> =
        patches.iter().map(|(place, patch)| Outline::new(normal, *place - origin, patch)).collect();
    let mut parents: Vec<usize> = (0..patches.len()).collect();
    let mut order: Vec<usize> = parents.clone();
    order.sort_by(|a, b| outlines[*a].low.x.total_cmp(&outlines[*b].low.x));
    for (i, a) in order.iter().enumerate() {
        let own = &outlines[*a];
        // Patches are sorted by their lowest x: once one begins beyond the end of this one, no
        // further one touches it.
        let near = order[i + 1..].iter().take_while(|b| outlines[**b].low.x <= own.high.x + TOUCH_MM);
        for b in near {
            let (roots, other) = ([*a, *b].map(|i| root(&mut parents, i)), &outlines[*b]);
            if roots[0] != roots[1] && own.is_near(other) && own.touches(other) {
                // The smaller index becomes the root.
                parents[roots[0].max(roots[1])] = roots[0].min(roots[1]);
            }
        }
    }
    let mut numbers = vec![None; patches.len()];
    let mut count = 0;
    let number = |i: usize| {
        let own = root(&mut parents, i);
        *numbers[own].get_or_insert_with(|| {
            count += 1;
            count - 1
        })
    };
    (0..patches.len()).map(number).collect()
}

/// Returns the root of a tree in a union-find forest, and shortens paths on the way.
fn root(parents: &mut [usize], mut i: usize) -> usize {
    while parents[i] != i {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    i
}

impl Outline {
    fn new(normal: DVec3, place: DVec3, patch: &Patch) -> Self {
        let Frame { u, v, .. } = Frame::new(normal);
        let flat = |corner: &[i32; 3]| {
            let corner = place * 1e3 + DVec3::from(corner.map(f64::from));
            DVec2::new(corner.dot(u), corner.dot(v))
        };
        let polygons: Vec<Vec<DVec2>> =
            patch.polygons().iter().map(|polygon| polygon.iter().map(flat).collect()).collect();
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        polygons.iter().flatten().for_each(|corner| (low, high) = (low.min(*corner), high.max(*corner)));
        Outline { polygons, low, high }
    }

    /// Returns true if the bounding boxes of both touch.
    fn is_near(&self, other: &Outline) -> bool {
        let gap = (other.low - self.high).max(self.low - other.high);
        gap.cmple(DVec2::splat(TOUCH_MM)).all()
    }

    fn edges(&self) -> impl Iterator<Item = [DVec2; 2]> {
        self.polygons.iter().flat_map(|polygon| {
            let next = polygon.iter().cycle().skip(1);
            polygon.iter().zip(next).map(|(from, to)| [*from, *to])
        })
    }

    fn touches(&self, other: &Outline) -> bool {
        self.edges().any(|a| other.edges().any(|b| share(a, b)))
    }
}

/// Returns true if two edges run along each other for more than a corner.
fn share([p, q]: [DVec2; 2], [r, s]: [DVec2; 2]) -> bool {
    let length = (q - p).length();
    let along = (q - p) / length;
    let [(x, y), (z, w)] = [r, s].map(|corner| ((corner - p).dot(along), (corner - p).perp_dot(along)));
    let (from, to) = (x.min(z).max(0.0), x.max(z).min(length));
    if length == 0.0 || to - from < SHARED_MM {
        return false;
    }
    let beside = |at: f64| (y + (w - y) * (at - x) / (z - x)).abs();
    beside(from) <= TOUCH_MM && beside(to) <= TOUCH_MM
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Patch {
        Patch::square(DVec3::Z, 1.0)
    }

    /// Squares side by side are one region. Squares that meet at a corner or lie 10 mm apart are
    /// not. A square beside two half-shifted ones is one region with both: 4 of 4, on level and on
    /// steep faces.
    #[test]
    fn squares_join_along_edges_not_at_corners() {
        let flat = square();
        for (places, expected) in [
            (&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)][..], &[0, 0, 0][..]),
            (&[(0.0, 0.0), (1.0, 1.0)], &[0, 1]),
            (&[(0.0, 0.0), (1.01, 0.0), (0.0, 1.002)], &[0, 1, 0]),
            (&[(0.0, 0.0), (1.0, 0.5), (1.0, -0.5), (5.0, 0.0)], &[0, 0, 0, 1]),
        ] {
            let patches: Vec<_> = places.iter().map(|(x, y)| (DVec3::new(*x, *y, 7.0), &flat)).collect();
            assert_eq!(regions(DVec3::Z, &patches), expected, "{places:?}");
        }
        let normal = DVec3::new(0.0, -0.8, 0.6);
        let steep = Patch::square(normal, 1.0);
        let up = Frame::new(normal).v;
        let patches = [DVec3::ZERO, up * 3.0, up, up * 2.0].map(|place| (place, &steep));
        assert_eq!(regions(normal, &patches), [0, 0, 0, 0]);
        assert!(regions(DVec3::Z, &[]).is_empty());
    }
}
