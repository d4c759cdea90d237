//! Overlapping footprints. In: blocks, each with its polygons and heights. Out: the blocks without
//! the room that another block fills, the free parts of their roofs and undersides, and the groups
//! of blocks that overlap.

use glam::DVec2;
use rayon::prelude::*;

use crate::footprint::PlanRing;
use crate::footprints::region::{area_m2, shared_m2, without};

/// Area that two footprints must share to overlap, m2 and as a share of the smaller one: less is
/// within the accuracy of surveys.
const OVERLAP_M2: f64 = 0.25;
const OVERLAP_SHARE: f64 = 0.002;

/// Difference below which heights are equal, metres.
const SAME_HEIGHT_M: f64 = 0.01;

/// Least share of a part that its outline covers.
const MAX: f64 = 0.5;

/// A prism: a footprint between two heights.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    pub polygons: Vec<Vec<PlanRing>>,
    pub foot_m: f64,
    pub roof_m: f64,
    pub is_part: bool,
    /// Part of the roof that is outdoors; `None` if all of it is.
    pub free_roof: Option<Vec<Vec<PlanRing>>>,
    /// Part of the underside that is outdoors; `None` if all of it is.
    pub free_underside: Option<Vec<Vec<PlanRing>>>,
}

/// Two blocks that overlap in plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Pair {
    pub first: usize,
    pub second: usize,
}

/// Returns the pairs of shapes that overlap in plan.
pub(super) fn overlapping(shapes: &[&[Vec<PlanRing>]]) -> Vec<Pair> {
    // Boxes sorted from the west leave few pairs of shapes to intersect.
    let boxes: Vec<[DVec2; 2]> = shapes.iter().map(|polygons| bounds(polygons)).collect();
    let mut order: Vec<usize> = (0..shapes.len()).collect();
    let west = |i: usize| boxes.get(i).map_or(f64::INFINITY, |[low, _]| low.x);
    order.sort_unstable_by(|&a, &b| west(a).total_cmp(&west(b)).then(a.cmp(&b)));
    let near: Vec<Pair> = order
        .par_iter()
        .enumerate()
        .flat_map_iter(|(rank, &i)| {
            let [low, high] = boxes.get(i).copied().unwrap_or_default();
            let after = order.get(rank + 1..).unwrap_or_default().iter().take_while(move |&&j| west(j) < high.x);
            let boxes = &boxes;
            after.filter_map(move |&j| {
                let [from, to] = boxes.get(j).copied()?;
                let shared = (high.min(to) - low.max(from)).max(DVec2::ZERO);
                (shared.x * shared.y > OVERLAP_M2).then(|| Pair { first: i.min(j), second: i.max(j) })
            })
        })
        .collect();
    let shape = |i: usize| shapes.get(i).copied().unwrap_or_default();
    let mut pairs: Vec<Pair> = near
        .into_par_iter()
        .filter(|pair| {
            let (first, second) = (shape(pair.first), shape(pair.second));
            let least = OVERLAP_M2.max(OVERLAP_SHARE * area_m2(first).min(area_m2(second)));
            shared_m2(first, second) > least
        })
        .collect();
    pairs.sort_unstable();
    pairs
}

fn bounds(polygons: &[Vec<PlanRing>]) -> [DVec2; 2] {
    let none = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    let outlines = polygons.iter().filter_map(|polygon| polygon.first()).flatten();
    outlines.fold(none, |[low, high], corner| [low.min(*corner), high.max(*corner)])
}

/// Returns the whole that each part lies in, and cuts the parts out of the outlines of their
/// wholes: a building with parts consists of its parts.
pub(super) fn outlines_without_parts(blocks: &mut [Block], pairs: &[Pair]) -> Vec<Option<usize>> {
    let mut wholes: Vec<Option<usize>> = vec![None; blocks.len()];
    let mut parts: Vec<Vec<usize>> = vec![Vec::new(); blocks.len()];
    for &Pair { first, second } in pairs {
        for (part, whole) in [(first, second), (second, first)] {
            let (Some(a), Some(b)) = (blocks.get(part), blocks.get(whole)) else { continue };
            if !a.is_part || b.is_part {
                continue;
            }
            if shared_m2(&a.polygons, &b.polygons) > MAX * area_m2(&a.polygons)
                && let Some(slot) = wholes.get_mut(part)
            {
                slot.get_or_insert(whole);
            }
            parts.get_mut(whole).into_iter().for_each(|list| list.push(part));
        }
    }
    for (whole, parts) in parts.into_iter().enumerate() {
        let covering: Vec<Vec<PlanRing>> =
            parts.iter().filter_map(|part| blocks.get(*part)).flat_map(|block| block.polygons.clone()).collect();
        if let Some(block) = blocks.get_mut(whole).filter(|_| !covering.is_empty()) {
            block.polygons = without(&block.polygons, &covering);
        }
    }
    wholes
}

/// Cuts out of each block the room that another block fills, and out of roofs and undersides the
/// area that another block covers. Returns the number of blocks that lost room.
pub(super) fn settle(blocks: &mut [Block], pairs: &[Pair]) -> usize {
    let mut changed = vec![false; blocks.len()];
    let mut open = Vec::new();
    for &Pair { first, second } in pairs {
        let (Some(a), Some(b)) = (blocks.get(first), blocks.get(second)) else { continue };
        // A block that its parts took over fills nothing.
        if a.polygons.is_empty() || b.polygons.is_empty() {
            continue;
        }
        let [inner, outer] = match (fills(a, b), fills(b, a)) {
            (true, _) => [second, first],
            (_, true) => [first, second],
            _ => {
                open.push(Pair { first, second });
                continue;
            }
        };
        let filled = blocks.get(outer).map(|block| block.polygons.clone()).unwrap_or_default();
        if let Some(block) = blocks.get_mut(inner).filter(|block| !block.polygons.is_empty()) {
            block.polygons = without(&block.polygons, &filled);
        }
        changed.get_mut(inner).into_iter().for_each(|flag| *flag = true);
    }
    for Pair { first, second } in open {
        for [lower, upper] in [[first, second], [second, first]] {
            let (Some(a), Some(b)) = (blocks.get(lower), blocks.get(upper)) else { continue };
            let is_roof_covered = b.foot_m <= a.roof_m + SAME_HEIGHT_M && b.roof_m > a.roof_m + SAME_HEIGHT_M;
            let is_underside_covered = is_roof_covered && b.foot_m >= a.foot_m - SAME_HEIGHT_M;
            let roof = is_roof_covered.then(|| without(a.free_roof.as_ref().unwrap_or(&a.polygons), &b.polygons));
            let underside =
                is_underside_covered.then(|| without(b.free_underside.as_ref().unwrap_or(&b.polygons), &a.polygons));
            if let (Some(roof), Some(block)) = (roof, blocks.get_mut(lower)) {
                block.free_roof = Some(roof);
            }
            if let (Some(underside), Some(block)) = (underside, blocks.get_mut(upper)) {
                block.free_underside = Some(underside);
            }
        }
    }
    changed.iter().filter(|changed| **changed).count()
}

/// Returns true if `outer` stands at all heights at which `inner` does.
fn fills(outer: &Block, inner: &Block) -> bool {
    outer.foot_m <= inner.foot_m + SAME_HEIGHT_M && outer.roof_m >= inner.roof_m - SAME_HEIGHT_M
}

/// Returns for each block the lowest index of all blocks connected to it by pairs.
pub(super) fn groups(count: usize, pairs: &[Pair]) -> Vec<usize> {
    let mut root: Vec<usize> = (0..count).collect();
    fn find(root: &mut [usize], mut i: usize) -> usize {
        while let Some(&above) = root.get(i)
            && above != i
        {
            // Halves the path for later searches.
            let next = root.get(above).copied().unwrap_or(above);
            if let Some(slot) = root.get_mut(i) {
                *slot = next;
            }
            i = next;
        }
        i
    }
    for &Pair { first, second } in pairs {
        let (a, b) = (find(&mut root, first), find(&mut root, second));
        if let Some(slot) = root.get_mut(a.max(b)) {
            *slot = a.min(b);
        }
    }
    (0..count).map(|i| find(&mut root, i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, side: f64) -> Vec<Vec<PlanRing>> {
        let at = |dx: f64, y: f64| DVec2::new(x + dx, y);
        vec![vec![vec![at(0., 0.), at(side, 0.), at(side, side), at(0., side)]]]
    }

    fn block(x: f64, side: f64, foot_m: f64, roof_m: f64) -> Block {
        Block { polygons: square(x, side), foot_m, roof_m, ..Block::default() }
    }

    /// A tower of 30 m through a podium of 100 m2 and 10 m takes its 25 m2 out of the podium. A
    /// tower that begins at 10 m leaves the podium whole, 75 m2 of its roof free and none of its
    /// own underside. Of two equal blocks one is left.
    #[test]
    fn a_tower_takes_its_area_from_the_podium() {
        let settled = |mut blocks: Vec<Block>| {
            let shapes: Vec<&[Vec<PlanRing>]> = blocks.iter().map(|block| block.polygons.as_slice()).collect();
            let pairs = overlapping(&shapes);
            assert_eq!(pairs, [Pair { first: 0, second: 1 }]);
            settle(&mut blocks, &pairs);
            blocks
        };
        let through = settled(vec![block(0., 10., 0., 10.), block(0., 5., 0., 30.)]);
        assert!((area_m2(&through[0].polygons) - 75.0).abs() < 1e-6 && through[0].free_roof.is_none());
        let upon = settled(vec![block(0., 10., 0., 10.), block(0., 5., 10., 30.)]);
        assert!((area_m2(&upon[0].polygons) - 100.0).abs() < 1e-6);
        assert!((area_m2(upon[0].free_roof.as_ref().expect("covered")) - 75.0).abs() < 1e-6);
        assert_eq!(upon[1].free_underside.as_ref().map(Vec::len), Some(0));
        let twins = settled(vec![block(0., 10., 0., 10.), block(0., 10., 0., 10.)]);
        assert!((area_m2(&twins[0].polygons) + area_m2(&twins[1].polygons) - 100.0).abs() < 1e-6);
    }

    /// An outline of 100 m2 with parts of 25 and 50 m2 keeps 25 m2, and both parts belong to it.
    /// Neighbours that touch are no pair.
    #[test]
    fn parts_take_the_place_of_outlines() {
        let part = |mut block: Block| {
            block.is_part = true;
            block
        };
        let mut half = part(block(0., 10., 0., 20.));
        half.polygons =
            vec![vec![[(0., 5.), (10., 5.), (10., 10.), (0., 10.)].map(|(x, y)| DVec2::new(x, y)).to_vec()]];
        let mut blocks = vec![block(0., 10., 0., 10.), part(block(0., 5., 0., 30.)), half, block(10., 10., 0., 10.)];
        let shapes: Vec<&[Vec<PlanRing>]> = blocks.iter().map(|block| block.polygons.as_slice()).collect();
        let pairs = overlapping(&shapes);
        assert_eq!(pairs.len(), 2);
        assert_eq!(outlines_without_parts(&mut blocks, &pairs), [None, Some(0), Some(0), None]);
        assert!((area_m2(&blocks[0].polygons) - 25.0).abs() < 1e-6);
        assert_eq!(groups(4, &pairs), [0, 0, 0, 3]);
    }
}
