//! Lines between pieces in plan. In: the piece of each cell. Out: chains of sides of cells from one
//! junction to the next, each with the pieces to its left and right.

use std::collections::{BTreeMap, BTreeSet};

use crate::surface_city::lattice::{Lattice, STEPS, Spot, beside};

/// Number of the piece without a value in the raster.
pub(super) const OUTSIDE: u32 = 0;
/// Number of the piece of ground.
pub(super) const GROUND: u32 = 1;
/// Number of the first piece of a roof.
pub(super) const FIRST_ROOF: u32 = 2;

/// Consecutive sides of cells between the same two pieces.
#[derive(Clone, Debug)]
pub(super) struct Chain {
    /// Corners of cells; in a closed chain the first one is the last one.
    pub corners: Vec<Spot>,
    /// Number of the piece to the left of its direction.
    pub left: u32,
    /// Number of the piece to the right.
    pub right: u32,
}

/// Returns the pieces to the left and to the right of the side that leaves a corner in a direction
/// of [`STEPS`].
fn pieces_of_side(pieces: &Lattice<u32>, [column, row]: Spot, direction: usize) -> [u32; 2] {
    let (north_west, north_east) = ([column - 1, row - 1], [column, row - 1]);
    let (south_west, south_east) = ([column - 1, row], [column, row]);
    let [left, right] = match direction {
        0 => [north_east, south_east],
        1 => [south_east, south_west],
        2 => [south_west, north_west],
        _ => [north_west, north_east],
    };
    [pieces.at(left), pieces.at(right)]
}

/// Returns the directions in which lines leave a corner.
fn lines_at(pieces: &Lattice<u32>, corner: Spot) -> impl Iterator<Item = usize> + '_ {
    (0..STEPS.len()).filter(move |direction| {
        let [left, right] = pieces_of_side(pieces, corner, *direction);
        left != right && left.max(right) >= FIRST_ROOF
    })
}

fn stepped(corner: Spot, direction: usize) -> Spot {
    STEPS.get(direction).map_or(corner, |step| beside(corner, *step))
}

/// Returns true if lines meet, end or change their pieces at a corner.
fn is_junction(pieces: &Lattice<u32>, corner: Spot) -> bool {
    let found: Vec<usize> = lines_at(pieces, corner).collect();
    let pair = |direction: usize| {
        let [left, right] = pieces_of_side(pieces, corner, direction);
        [left.min(right), left.max(right)]
    };
    match found.as_slice() {
        [one, other] => pair(*one) != pair(*other),
        _ => true,
    }
}

/// Returns all chains at roofs.
pub(super) fn chains(pieces: &Lattice<u32>) -> Vec<Chain> {
    // Sides walked so far, by their western or northern corner, and true if they run south.
    let mut walked: BTreeSet<(Spot, bool)> = BTreeSet::new();
    let side = |corner: Spot, direction: usize| match direction {
        0 | 1 => (corner, direction == 1),
        _ => (stepped(corner, direction), direction == 3),
    };
    let mut chains = Vec::new();
    let corners = || {
        let (columns, rows) = (pieces.columns as i64, pieces.rows as i64);
        (0..=rows).flat_map(move |row| (0..=columns).map(move |column| [column, row]))
    };
    for only_junctions in [true, false] {
        for corner in corners() {
            if only_junctions && !is_junction(pieces, corner) {
                continue;
            }
            for direction in lines_at(pieces, corner).collect::<Vec<_>>() {
                if walked.contains(&side(corner, direction)) {
                    continue;
                }
                let [left, right] = pieces_of_side(pieces, corner, direction);
                let (mut at, mut along, mut line) = (corner, direction, vec![corner]);
                loop {
                    walked.insert(side(at, along));
                    at = stepped(at, along);
                    line.push(at);
                    if at == corner || is_junction(pieces, at) {
                        break;
                    }
                    let back = (along + 2) % 4;
                    let Some(next) = lines_at(pieces, at).find(|direction| *direction != back) else { break };
                    along = next;
                }
                chains.push(Chain { corners: line, left, right });
            }
        }
    }
    chains
}

/// A chain in a ring, forwards or backwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Link {
    pub chain: usize,
    pub forwards: bool,
}

/// Returns the direction of a side between two corners.
fn direction(from: Spot, to: Spot) -> usize {
    STEPS.iter().position(|step| beside(from, *step) == to).unwrap_or_default()
}

/// Returns the rings around each piece of a roof, with the piece to their left: the outline turns
/// counter-clockwise, holes clockwise.
pub(super) fn rings(chains: &[Chain]) -> BTreeMap<u32, Vec<Vec<Link>>> {
    // Links of each piece by the corner that they begin at.
    let mut from: BTreeMap<(u32, Spot), Vec<Link>> = BTreeMap::new();
    let mut all: Vec<(u32, Link)> = Vec::new();
    for (number, chain) in chains.iter().enumerate() {
        for (piece, forwards) in [(chain.left, true), (chain.right, false)] {
            let link = Link { chain: number, forwards };
            if piece >= FIRST_ROOF
                && let Some([start, _]) = ends(chain, forwards)
            {
                from.entry((piece, start)).or_default().push(link);
                all.push((piece, link));
            }
        }
    }
    let mut found: BTreeMap<u32, Vec<Vec<Link>>> = BTreeMap::new();
    let mut taken: BTreeSet<(usize, bool)> = BTreeSet::new();
    for (piece, first) in all {
        let (mut ring, mut link) = (Vec::new(), first);
        while taken.insert((link.chain, link.forwards)) {
            ring.push(link);
            let Some(chain) = chains.get(link.chain) else { break };
            let Some([_, end]) = ends(chain, link.forwards) else { break };
            let along = last_direction(chain, link.forwards);
            // At a corner where two cells of the piece touch, the ring stays with its cell: left
            // before straight on before right.
            let turn = |next: &Link| {
                let out = chains.get(next.chain).map_or(0, |chain| first_direction(chain, next.forwards));
                [1, 2, 3, 0].get((out + 4 - along) % 4).copied().unwrap_or(3)
            };
            let found = from.get(&(piece, end)).into_iter().flatten();
            let Some(next) = found.min_by_key(|next| turn(next)) else { break };
            link = *next;
        }
        if !ring.is_empty() {
            found.entry(piece).or_default().push(ring);
        }
    }
    found
}

/// Returns the corners at which a chain begins and ends.
fn ends(chain: &Chain, forwards: bool) -> Option<[Spot; 2]> {
    let (first, last) = (*chain.corners.first()?, *chain.corners.last()?);
    Some(if forwards { [first, last] } else { [last, first] })
}

/// Returns the direction of the last side of a chain.
fn last_direction(chain: &Chain, forwards: bool) -> usize {
    match (chain.corners.as_slice(), forwards) {
        ([.., a, b], true) | ([b, a, ..], false) => direction(*a, *b),
        _ => 0,
    }
}

/// Returns the direction of the first side of a chain.
fn first_direction(chain: &Chain, forwards: bool) -> usize {
    match (chain.corners.as_slice(), forwards) {
        ([a, b, ..], true) | ([.., b, a], false) => direction(*a, *b),
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(rows: &[&str]) -> Lattice<u32> {
        let mut grid = Lattice::filled(rows[0].len(), rows.len(), OUTSIDE);
        for spot in grid.spots() {
            let letter = rows[spot[1] as usize].as_bytes()[spot[0] as usize];
            grid.set(spot, u32::from(letter - b'0'));
        }
        grid
    }

    /// Two roofs side by side on ground have 3 chains, of 1, 3 and 5 sides, and a ring each of two
    /// chains.
    #[test]
    fn two_roofs_side_by_side_have_3_chains() {
        let found = chains(&pieces(&["11111", "12231", "11111"]));
        let mut sides: Vec<usize> = found.iter().map(|chain| chain.corners.len() - 1).collect();
        sides.sort_unstable();
        assert_eq!(sides, [1, 3, 5]);
        let rings = rings(&found);
        assert_eq!(rings.iter().map(|(piece, rings)| (*piece, rings.len())).collect::<Vec<_>>(), [(2, 1), (3, 1)]);
        assert!(rings.values().flatten().all(|ring| ring.len() == 2));
    }

    /// A roof around a court has 2 closed chains and 2 rings; cells that touch at a corner make 2
    /// rings of 6 chains.
    #[test]
    fn a_court_has_a_chain_of_its_own() {
        let court = chains(&pieces(&["222", "212", "222"]));
        assert_eq!((court.len(), rings(&court)[&2].len()), (2, 2));
        assert!(court.iter().all(|chain| chain.corners.first() == chain.corners.last()));
        let touching = chains(&pieces(&["21", "12"]));
        assert_eq!(touching.len(), 6);
        assert_eq!(rings(&touching)[&2].len(), 2);
    }
}
