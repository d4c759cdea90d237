//! Areas in plan. In: polygons from files, which may cross themselves. Out: sound polygons, their
//! area, and their differences; the crate `i_overlay` does the geometry.

use glam::DVec2;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::simplify::SimplifyShape;
use i_overlay::float::single::SingleFloatOverlay;

use crate::footprint::PlanRing;
use crate::plan::{sides, signed_area_m2};

/// Area of a sliver, m2: outlines that agree except for rounding leave slivers.
pub(super) const SLIVER_M2: f64 = 0.05;

/// Width of a sliver, metres.
const THIN_M: f64 = 0.03;

/// Most corners of a polygon whose sides are compared one by one.
const FEW_CORNERS: usize = 128;

type Flat = Vec<Vec<Vec<[f64; 2]>>>;

/// Returns the area of polygons, m2.
pub(super) fn area_m2(polygons: &[Vec<PlanRing>]) -> f64 {
    polygons.iter().flatten().map(|ring| signed_area_m2(ring)).sum()
}

/// Returns a polygon with its outline anticlockwise and its holes clockwise, without repeated
/// corners; `None` if the outline has fewer than three corners.
pub(crate) fn oriented(rings: Vec<PlanRing>) -> Option<Vec<PlanRing>> {
    let mut turned = Vec::with_capacity(rings.len());
    for (number, mut ring) in rings.into_iter().enumerate() {
        ring.dedup();
        while ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        let area = signed_area_m2(&ring);
        if ring.len() < 3 || area == 0.0 {
            if number == 0 && ring.len() < 3 {
                return None;
            }
            // An outline that crosses itself may have two halves of equal size.
            if number > 0 {
                continue;
            }
        }
        if (area < 0.0) != (number > 0) {
            ring.reverse();
        }
        turned.push(ring);
    }
    Some(turned)
}

/// Returns true if sides of a polygon cross each other, or if its area is not positive.
pub(crate) fn is_crossed(polygon: &[PlanRing]) -> bool {
    let sides: Vec<[DVec2; 2]> = polygon.iter().flat_map(|ring| sides(ring)).collect();
    if sides.len() > FEW_CORNERS {
        let whole: f64 = area_m2(&[polygon.to_vec()]);
        return (area_m2(&repaired(polygon)) - whole).abs() > 1e-6 * whole.abs();
    }
    let is_left = |[a, b]: [DVec2; 2], p: DVec2| (b - a).perp_dot(p - a);
    sides.iter().enumerate().any(|(i, first)| {
        sides.iter().skip(i + 1).any(|second| {
            let [a, b] = second.map(|corner| is_left(*first, corner));
            let [c, d] = first.map(|corner| is_left(*second, corner));
            a * b < 0.0 && c * d < 0.0
        })
    }) || area_m2(&[polygon.to_vec()]) <= 0.0
}

/// Returns polygons that do not cross themselves, of the area that an odd number of the polygon's
/// rings encloses.
pub(crate) fn repaired(polygon: &[PlanRing]) -> Vec<Vec<PlanRing>> {
    let from = origin_of(polygon);
    lifted(flat(std::slice::from_ref(&polygon.to_vec()), from).concat().simplify_shape(FillRule::EvenOdd), from)
}

/// Returns the area that at least one of some polygons covers, as polygons that do not overlap;
/// `None` if they do not overlap as they are.
pub(crate) fn united(polygons: &[Vec<PlanRing>]) -> Option<Vec<Vec<PlanRing>>> {
    if polygons.len() < 2 {
        return None;
    }
    let united = overlaid(polygons, &[], OverlayRule::Union);
    (area_m2(polygons) - area_m2(&united) > SLIVER_M2).then_some(united)
}

/// Returns the polygons without the area of others.
pub(super) fn without(polygons: &[Vec<PlanRing>], others: &[Vec<PlanRing>]) -> Vec<Vec<PlanRing>> {
    overlaid(polygons, others, OverlayRule::Difference)
}

/// Returns the area that two sets of polygons share, m2.
pub(super) fn shared_m2(polygons: &[Vec<PlanRing>], others: &[Vec<PlanRing>]) -> f64 {
    area_m2(&overlaid(polygons, others, OverlayRule::Intersect))
}

fn overlaid(polygons: &[Vec<PlanRing>], others: &[Vec<PlanRing>], rule: OverlayRule) -> Vec<Vec<PlanRing>> {
    // Thousands of outlines may be stacked upon each other: each pair would cost microseconds.
    match rule {
        _ if polygons.is_empty() => return Vec::new(),
        OverlayRule::Difference if polygons == others => return Vec::new(),
        OverlayRule::Intersect if polygons == others => return polygons.to_vec(),
        _ => {}
    }
    let from = polygons.first().map_or(DVec2::ZERO, |polygon| origin_of(polygon));
    lifted(flat(polygons, from).overlay(&flat(others, from), rule, FillRule::NonZero), from)
}

fn origin_of(polygon: &[PlanRing]) -> DVec2 {
    polygon.first().and_then(|ring| ring.first()).copied().unwrap_or_default()
}

/// Returns the polygons relative to a corner, because national coordinates are large.
fn flat(polygons: &[Vec<PlanRing>], from: DVec2) -> Flat {
    let ring = |ring: &PlanRing| ring.iter().map(|corner| (*corner - from).to_array()).collect();
    polygons.iter().map(|polygon| polygon.iter().map(ring).collect()).collect()
}

/// Returns shapes at their place in the scene, without slivers.
fn lifted(shapes: Flat, from: DVec2) -> Vec<Vec<PlanRing>> {
    let ring = |ring: &Vec<[f64; 2]>| -> PlanRing { ring.iter().map(|corner| DVec2::from(*corner) + from).collect() };
    let polygons = shapes.iter().map(|shape| shape.iter().map(ring).collect::<Vec<PlanRing>>());
    polygons
        .filter_map(oriented)
        .map(|mut polygon| {
            let mut number = 0;
            polygon.retain(|ring| {
                number += 1;
                number == 1 || !is_sliver(ring)
            });
            polygon
        })
        .filter(|polygon| polygon.first().is_some_and(|outline| !is_sliver(outline)))
        .collect()
}

fn is_sliver(ring: &[DVec2]) -> bool {
    let area = signed_area_m2(ring).abs();
    let length: f64 = sides(ring).map(|[a, b]| a.distance(b)).sum();
    area < SLIVER_M2 || area < 0.5 * THIN_M * length
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(corners: &[(f64, f64)]) -> PlanRing {
        corners.iter().map(|(x, y)| DVec2::new(500_000.0 + x, 5_000_000.0 + y)).collect()
    }

    /// A bow tie of two triangles of 25 m2 is recognised as crossed and becomes 50 m2. A square
    /// with a hole drawn in the same direction has 96 m2.
    #[test]
    fn a_bow_tie_and_a_turned_hole_are_repaired() {
        let tie = vec![ring(&[(0., 0.), (10., 10.), (10., 0.), (0., 10.)])];
        let tie = oriented(tie).expect("a ring");
        assert!(is_crossed(&tie));
        let repaired = repaired(&tie);
        assert!((area_m2(&repaired) - 50.0).abs() < 1e-6 && repaired.len() == 2, "{repaired:?}");
        let square = ring(&[(0., 0.), (10., 0.), (10., 10.), (0., 10.), (0., 0.)]);
        let hole = ring(&[(4., 4.), (6., 4.), (6., 6.), (4., 6.)]);
        let polygon = oriented(vec![square, hole]).expect("rings");
        assert!(!is_crossed(&polygon) && (area_m2(&[polygon]) - 96.0).abs() < 1e-6);
        assert!(oriented(vec![ring(&[(0., 0.), (1., 0.), (0., 0.)])]).is_none());
    }

    /// A square of 100 m2 without one that covers 30 m2 of it leaves 70 m2, and without one that is
    /// 1 mm smaller nothing. Two that share 50 m2 cover 150 m2 together.
    #[test]
    fn a_covered_area_is_cut_away() {
        let square = |x: f64, side: f64| vec![vec![ring(&[(x, 0.), (x + side, 0.), (x + side, side), (x, side)])]];
        assert!((area_m2(&without(&square(0., 10.), &square(7., 10.))) - 70.0).abs() < 1e-6);
        assert!((shared_m2(&square(0., 10.), &square(7., 10.)) - 30.0).abs() < 1e-6);
        assert!(without(&square(0., 10.), &square(0., 9.999)).is_empty());
        let both = [square(0., 10.), square(5., 10.)].concat();
        assert!((area_m2(&united(&both).expect("overlapping")) - 150.0).abs() < 1e-6);
        assert!(united(&[square(0., 10.), square(10., 10.)].concat()).is_none());
    }
}
