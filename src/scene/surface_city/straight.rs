//! Straight lines between pieces. In: chains of sides of cells. Out: a polyline for each chain,
//! along lines that fit the middles of its sides.
//!
//! The line between cells of two pieces goes through the middles of the sides between them, within
//! half a cell, whatever its direction; a staircase of sides is up to 1.41 times as long. A chain
//! is cut where its sides are more than [`OFF_LINE`] cells off one line (Douglas and Peucker 1973,
//! with fitted lines in place of chords), and neighbouring lines meet in corners. Where two planes
//! of a roof meet, the line is their intersection: a ridge, a valley.

use std::collections::HashMap;
use std::ops::Range;

use glam::DVec2;

use crate::surface_city::lattice::Spot;
use crate::surface_city::layers::Layers;
use crate::surface_city::outlines::Chain;
use crate::surface_city::plane::Plane;

/// Largest distance of middles of sides from their line, cells: half a cell by the grid, the rest
/// is noise.
const OFF_LINE: f64 = 0.75;
/// Largest distance of a chain from the line in which two planes meet, cells, for which that line
/// is drawn.
const OFF_RIDGE: f64 = 2.0;
/// Least difference between the slopes of planes that meet in a line that cells show.
const MIN_BEND: f64 = 0.08;
/// Largest movement of a corner, cells.
const MAX_MOVED: f64 = 1.5;
/// Weight that holds a corner in the direction that no line determines, and weight for lines that
/// nearly run alike.
const HELD: f64 = 1e-3;
const HELD_FAST: f64 = 0.3;

/// Ways to draw a chain. Each one keeps closer to the sides of the cells than the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Drawing {
    /// Along lines that fit the middles of the sides.
    Fitted,
    /// Straight from one corner of cells to another, between the corners where the fitted lines
    /// would meet.
    Chords,
    /// Along all sides of cells.
    Cells,
}

impl Drawing {
    /// Returns the way that keeps closer to the cells.
    pub(super) fn closer(self) -> Drawing {
        match self {
            Drawing::Fitted => Drawing::Chords,
            _ => Drawing::Cells,
        }
    }
}

/// A straight line in plan.
#[derive(Clone, Copy, Debug)]
struct Line {
    point: DVec2,
    /// Normal of length 1.
    normal: DVec2,
    weight: f64,
}

/// Sides of a chain along one line.
#[derive(Clone, Debug)]
struct Stretch {
    sides: Range<usize>,
    line: Line,
}

/// A chain as it is drawn.
#[derive(Clone, Debug)]
pub(super) struct Polyline {
    /// Corners in plan.
    pub points: Vec<DVec2>,
    /// Index of each point among the corners of the chain, `[point]`.
    pub corners: Vec<usize>,
}

/// Draws chains. `planes` returns the planes of both pieces of a chain between roofs; `drawings`
/// has a way for each chain.
pub(super) fn straightened(
    chains: &[Chain],
    layers: &Layers,
    planes: impl Fn(&Chain) -> Option<[Plane; 2]>,
    drawings: &[Drawing],
) -> Vec<Polyline> {
    let cell = layers.cell_m();
    let mut all: Vec<Vec<Stretch>> = Vec::new();
    // Lines that end at a corner; `None` if a chain that is not fitted ends there.
    let mut at_nodes: HashMap<Spot, Option<Vec<Line>>> = HashMap::new();
    for (chain, drawing) in chains.iter().zip(drawings) {
        let places: Vec<DVec2> = chain.corners.iter().map(|corner| layers.corner(*corner)).collect();
        let ridge = planes(chain).and_then(|[a, b]| ridge(&places, a, b, cell));
        let stretches = match ridge {
            _ if *drawing == Drawing::Cells => Vec::new(),
            Some(line) => vec![Stretch { sides: 0..places.len().saturating_sub(1), line }],
            None => stretches(&places, cell),
        };
        let ends = [(chain.corners.first(), stretches.first()), (chain.corners.last(), stretches.last())];
        for (corner, stretch) in ends {
            let Some(corner) = corner else { continue };
            let lines = at_nodes.entry(*corner).or_insert_with(|| Some(Vec::new()));
            match stretch.filter(|_| *drawing == Drawing::Fitted) {
                Some(stretch) => lines.iter_mut().for_each(|lines| lines.push(stretch.line)),
                None => *lines = None,
            }
        }
        all.push(stretches);
    }
    let node = |corner: Spot| {
        let place = layers.corner(corner);
        match at_nodes.get(&corner) {
            Some(Some(lines)) => meeting(place, lines, cell),
            _ => place,
        }
    };
    let at = |corner: Spot, lines: &[Line], drawing: Drawing| match drawing {
        Drawing::Fitted => meeting(layers.corner(corner), lines, cell),
        _ => layers.corner(corner),
    };
    let drawn = chains.iter().zip(all).zip(drawings);
    drawn
        .map(|((chain, all), drawing)| polyline(chain, &all, node, |corner, lines| at(corner, lines, *drawing)))
        .collect()
}

/// Draws a chain through the corners at which its stretches meet, or through all of its corners if
/// it has no stretches.
fn polyline(
    chain: &Chain,
    stretches: &[Stretch],
    node: impl Fn(Spot) -> DVec2,
    inner: impl Fn(Spot, &[Line]) -> DVec2,
) -> Polyline {
    let last = chain.corners.len().saturating_sub(1);
    let breaks: Vec<usize> = match stretches {
        [] => (0..=last).collect(),
        _ => stretches.iter().map(|stretch| stretch.sides.start).chain([last]).collect(),
    };
    let mut line = Polyline { points: Vec::new(), corners: Vec::new() };
    for (i, &at) in breaks.iter().enumerate() {
        let Some(corner) = chain.corners.get(at) else { continue };
        let place = match (i.checked_sub(1).and_then(|i| stretches.get(i)), stretches.get(i)) {
            _ if at == 0 || at == last => node(*corner),
            (Some(one), Some(two)) => inner(*corner, &[one.line, two.line]),
            _ => inner(*corner, &[]),
        };
        line.points.push(place);
        line.corners.push(at);
    }
    line
}

/// Returns the place near a corner where lines meet, by least squares of the distances from them.
fn meeting(place: DVec2, lines: &[Line], cell: f64) -> DVec2 {
    let held = |held: f64| {
        let (mut xx, mut xy, mut yy, mut by) = (held, 0.0, held, DVec2::ZERO);
        for Line { point, normal, weight } in lines {
            xx += weight * normal.x * normal.x;
            xy += weight * normal.x * normal.y;
            yy += weight * normal.y * normal.y;
            by += weight * normal.dot(*point - place) * *normal;
        }
        DVec2::new(by.x * yy - by.y * xy, by.y * xx - by.x * xy) / (xx * yy - xy * xy)
    };
    let near = |moved: &DVec2| moved.length() <= MAX_MOVED * cell;
    let moved = Some(held(HELD)).filter(near).or_else(|| Some(held(HELD_FAST)).filter(near));
    place + moved.unwrap_or_default()
}

/// Returns the line in which two planes meet, if it runs along a chain.
fn ridge(places: &[DVec2], a: Plane, b: Plane, cell: f64) -> Option<Line> {
    let bend = a.slope - b.slope;
    if bend.length() < MIN_BEND {
        return None;
    }
    let off = |place: DVec2| (a.at(place) - b.at(place)) / bend.length();
    let is_near = middles(places).all(|middle| off(middle).abs() <= OFF_RIDGE * cell);
    let normal = bend.normalize();
    let first = *places.first()?;
    is_near.then(|| Line { point: first - off(first) * normal, normal, weight: 1.0 })
}

fn middles(places: &[DVec2]) -> impl Iterator<Item = DVec2> + '_ {
    places.array_windows().map(|[a, b]| 0.5 * (*a + *b))
}

/// Cuts a chain into stretches along lines.
fn stretches(places: &[DVec2], cell: f64) -> Vec<Stretch> {
    let middles: Vec<DVec2> = middles(places).collect();
    let fit = |sides: &Range<usize>| fitted(places, &middles, sides);
    let fits = |sides: &Range<usize>, line: &Line| {
        let found = middles.get(sides.clone()).unwrap_or_default();
        found.iter().all(|middle| line.normal.dot(*middle - line.point).abs() <= OFF_LINE * cell)
    };
    let mut open: Vec<Range<usize>> = std::iter::once(0..middles.len()).collect();
    let mut found: Vec<Range<usize>> = Vec::new();
    while let Some(sides) = open.pop() {
        // A closed stretch has no chord, so that it is always cut.
        let is_closed = places.get(sides.start) == places.get(sides.end);
        match farthest(places, &sides).filter(|_| is_closed || !fits(&sides, &fit(&sides))) {
            Some(at) => open.extend([at..sides.end, sides.start..at]),
            None => found.push(sides),
        }
    }
    let mut joined: Vec<Range<usize>> = Vec::new();
    for sides in found {
        if let Some(last) = joined.last_mut() {
            let both = last.start..sides.end;
            if places.get(both.start) != places.get(both.end) && fits(&both, &fit(&both)) {
                *last = both;
                continue;
            }
        }
        joined.push(sides);
    }
    settle(&mut joined, |sides| squares(&middles, sides, &fit(sides)));
    joined.into_iter().map(|sides| Stretch { line: fit(&sides), sides }).collect()
}

/// Moves cuts by a few sides to where the lines on both sides fit best.
fn settle(stretches: &mut [Range<usize>], squares: impl Fn(&Range<usize>) -> f64) {
    const MAX: usize = 3;
    for i in 1..stretches.len() {
        let Some([one, two]) = stretches.get_mut(i - 1..=i).and_then(|pair| pair.first_chunk_mut::<2>()) else {
            continue;
        };
        let low = (one.start + 1).max(one.end.saturating_sub(MAX));
        let high = (two.end - 1).min(one.end + MAX);
        let cost = |at: usize| squares(&(one.start..at)) + squares(&(at..two.end));
        let now = cost(one.end);
        let best = (low..=high).map(|at| (cost(at), at)).min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, at)) = best.filter(|(least, _)| *least < now - 1e-9) {
            (one.end, two.start) = (at, at);
        }
    }
}

fn squares(middles: &[DVec2], sides: &Range<usize>, line: &Line) -> f64 {
    let found = middles.get(sides.clone()).unwrap_or_default();
    found.iter().map(|middle| line.normal.dot(*middle - line.point).powi(2)).sum()
}

/// Returns the corner of a stretch that is farthest from its chord, or from its start if it is
/// closed.
fn farthest(places: &[DVec2], sides: &Range<usize>) -> Option<usize> {
    let (from, to) = (*places.get(sides.start)?, *places.get(sides.end)?);
    let along = (to - from).normalize_or_zero();
    let off =
        |place: DVec2| if along == DVec2::ZERO { place.distance(from) } else { along.perp_dot(place - from).abs() };
    let inner = sides.start + 1..sides.end;
    let found = inner.filter_map(|at| Some((off(*places.get(at)?), at)));
    found.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))).map(|(_, at)| at)
}

/// Returns the line of least squares through the middles of sides.
fn fitted(places: &[DVec2], middles: &[DVec2], sides: &Range<usize>) -> Line {
    let found = middles.get(sides.clone()).unwrap_or_default();
    let count = found.len().max(1) as f64;
    let point = found.iter().sum::<DVec2>() / count;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for off in found.iter().map(|middle| *middle - point) {
        xx += off.x * off.x;
        xy += off.x * off.y;
        yy += off.y * off.y;
    }
    // The middles spread most in the direction of the line.
    let turn = 0.5 * (2.0 * xy).atan2(xx - yy);
    let mut along = DVec2::from_angle(turn);
    if found.len() < 2 {
        let end = |at: usize| places.get(at).copied().unwrap_or_default();
        along = (end(sides.end) - end(sides.start)).normalize_or(DVec2::X);
    }
    Line { point, normal: along.perp(), weight: if found.len() < 2 { 0.2 } else { 1.0 } }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A staircase of 40 sides along a line of 3 in 4 is 1 stretch whose slope is within 0.03 of
    /// it. An L of 8 and 6 sides is 2 stretches that meet in its corner within 0.01 of a cell.
    #[test]
    fn a_staircase_becomes_one_straight_line() {
        let (mut places, mut at) = (vec![DVec2::ZERO], DVec2::ZERO);
        for _ in 0..40 {
            at += if (at.y + 0.5) / (at.x + 1.0) < 0.75 { DVec2::Y } else { DVec2::X };
            places.push(at);
        }
        let found = stretches(&places, 1.0);
        assert_eq!(found.len(), 1);
        let along = -found[0].line.normal.perp();
        assert!((along.y / along.x - 0.75).abs() < 0.03, "{along}");
        let mut corner: Vec<DVec2> = (0..=8).map(|x| DVec2::new(f64::from(x), 0.0)).collect();
        corner.extend((1..=6).map(|y| DVec2::new(8.0, f64::from(y))));
        let found = stretches(&corner, 1.0);
        assert_eq!(found.iter().map(|stretch| stretch.sides.clone()).collect::<Vec<_>>(), [0..8, 8..14]);
        let met = meeting(DVec2::new(8.0, 0.0), &[found[0].line, found[1].line], 1.0);
        assert!(met.distance(DVec2::new(8.0, 0.0)) < 0.01, "{met}");
    }
}
