//! Check for outlines that cross themselves. In: rings of pieces of roofs as they are drawn. Out:
//! the chains that make them cross.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;

use crate::plan::signed_area_m2;
use crate::surface_city::buildings::outline;
use crate::surface_city::lattice::Lattice;
use crate::surface_city::layers::Layers;
use crate::surface_city::outlines::{FIRST_ROOF, Link};
use crate::surface_city::straight::Polyline;

/// Least and largest area of a drawn piece, as shares of the area of its cells.
const MIN_AREA: f64 = 0.5;
const MAX_AREA: f64 = 1.6;

/// Rings by piece, and the number of cells of each piece.
pub(super) struct Rings<'a> {
    rings: &'a BTreeMap<u32, Vec<Vec<Link>>>,
    cells: BTreeMap<u32, usize>,
}

impl<'a> Rings<'a> {
    pub(super) fn new(rings: &'a BTreeMap<u32, Vec<Vec<Link>>>, pieces: &Lattice<u32>) -> Rings<'a> {
        let mut cells: BTreeMap<u32, usize> = BTreeMap::new();
        for piece in pieces.spots().map(|cell| pieces.at(cell)).filter(|piece| *piece >= FIRST_ROOF) {
            *cells.entry(piece).or_default() += 1;
        }
        Rings { rings, cells }
    }

    /// Returns the chains that cross others of their piece, and all chains of a piece that turns
    /// over or whose area differs too much from that of its cells.
    pub(super) fn crossed(&self, layers: &Layers, lines: &[Polyline]) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        for (piece, rings) in self.rings {
            let whole = self.cells.get(piece).copied().unwrap_or_default() as f64 * layers.cell_m2();
            let plans: Vec<Vec<DVec2>> = rings.iter().map(|ring| outline(lines, ring)).collect();
            let drawn: f64 = plans.iter().map(|plan| signed_area_m2(plan)).sum();
            let outlines = plans.iter().filter(|plan| signed_area_m2(plan) > 0.0).count();
            if !(MIN_AREA * whole..=MAX_AREA * whole).contains(&drawn) || outlines != 1 {
                found.extend(rings.iter().flatten().map(|link| link.chain));
                continue;
            }
            let sides = rings.iter().flatten().flat_map(|link| sides_of(lines, link.chain)).collect();
            found.extend(crossing(sides));
        }
        found
    }
}

/// A side of an outline, and the number of its chain.
struct Side {
    ends: [DVec2; 2],
    chain: usize,
}

/// Returns the sides of a chain as it is drawn.
fn sides_of(lines: &[Polyline], chain: usize) -> Vec<Side> {
    let points = lines.get(chain).map(|line| line.points.as_slice()).unwrap_or_default();
    points.array_windows().map(|ends| Side { ends: *ends, chain }).collect()
}

/// Returns the chains whose sides cross each other, or partly lie on each other.
fn crossing(mut sides: Vec<Side>) -> BTreeSet<usize> {
    let low = |side: &Side| side.ends[0].x.min(side.ends[1].x);
    let high = |side: &Side| side.ends[0].x.max(side.ends[1].x);
    sides.sort_by(|a, b| low(a).total_cmp(&low(b)));
    let mut found = BTreeSet::new();
    for (i, one) in sides.iter().enumerate() {
        let later = sides.iter().skip(i + 1).take_while(|other| low(other) <= high(one));
        for other in later.filter(|other| cross(&one.ends, &other.ends)) {
            found.extend([one.chain, other.chain]);
        }
    }
    found
}

/// Returns true if two sides have a point in common that is not a corner of both.
fn cross([a, b]: &[DVec2; 2], [c, d]: &[DVec2; 2]) -> bool {
    let shared = [c, d].into_iter().filter(|corner| *corner == a || *corner == b).count();
    let turn = |p: &DVec2, q: &DVec2, r: &DVec2| (*q - *p).perp_dot(*r - *p);
    let (one, two) = (turn(a, b, c), turn(a, b, d));
    let (three, four) = (turn(c, d, a), turn(c, d, b));
    if shared > 0 {
        // The second side may run back along the first one.
        let (corner, p) = if a == c || a == d { (a, b) } else { (b, a) };
        let q = if corner == c { d } else { c };
        let flat = turn(corner, p, q).abs() < 1e-9 * (*p - *corner).length() * (*q - *corner).length();
        return shared == 2 && a != b || flat && (*p - *corner).dot(*q - *corner) > 0.0;
    }
    one * two <= 0.0 && three * four <= 0.0 && (one != 0.0 || two != 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square and a square with a hole cross nothing; a bow tie and a square whose hole leaves it
    /// do: 2 of 4.
    #[test]
    fn only_bow_ties_and_leaving_holes_cross() {
        let ring = |corners: &[[f64; 2]]| corners.iter().map(|corner| DVec2::from(*corner)).collect::<Vec<_>>();
        let square = ring(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
        let hole = ring(&[[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]]);
        let out = ring(&[[1.0, 1.0], [1.0, 2.0], [5.0, 2.0], [5.0, 1.0]]);
        let tie = ring(&[[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]]);
        let crosses = |rings: Vec<Vec<DVec2>>| {
            let sides = |(chain, ring): (usize, Vec<DVec2>)| {
                let next: Vec<DVec2> = ring.iter().cycle().skip(1).take(ring.len()).copied().collect();
                ring.into_iter().zip(next).map(move |(a, b)| Side { ends: [a, b], chain }).collect::<Vec<_>>()
            };
            crossing(rings.into_iter().enumerate().flat_map(sides).collect()).len()
        };
        let found = [vec![square.clone()], vec![square.clone(), hole], vec![tie], vec![square, out]];
        assert_eq!(found.map(crosses), [0, 0, 1, 2]);
    }
}
