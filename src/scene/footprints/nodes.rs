//! Common nodes of footprints. In: polygons of all footprints. Out: the polygons on common nodes:
//! corners within a tolerance are merged, and a corner that lies on a side of another polygon
//! becomes a corner of that polygon. Sides of buildings that touch are then the same pairs of
//! nodes.

use std::collections::HashMap;

use glam::DVec2;
use heliotile_core::site::morton::lexicographic;

use crate::footprint::PlanRing;

/// Distance within which corners are merged, and within which a corner lies on a side, metres:
/// coordinates in degrees with seven decimals are rounded to 1 cm.
pub(super) const SAME_M: f64 = 0.02;

/// Size of the cells in which nodes are looked up, metres.
const CELL_M: f64 = 8.0;
/// Length from which a side is searched for no nodes, metres: sides of buildings are shorter.
const LONGEST_M: f64 = 5000.0;

/// Polygons on common nodes.
pub(super) struct Noded {
    /// Position of each node.
    pub positions: Vec<DVec2>,
    /// Nodes, `[footprint][polygon][ring]`.
    pub footprints: Vec<Vec<Vec<Vec<u32>>>>,
}

impl Noded {
    /// Builds the common nodes of the polygons of footprints.
    pub(super) fn new(footprints: &[&[Vec<PlanRing>]]) -> Noded {
        let all = footprints.iter().copied().flatten();
        let corners: Vec<DVec2> = all.flatten().flatten().copied().collect();
        let (positions, node_of) = welded(&corners);
        let index = NodeCells::new(&positions);
        let mut nodes = node_of.into_iter();
        let mut ring = |ring: &PlanRing| {
            let own: Vec<u32> = nodes.by_ref().take(ring.len()).collect();
            with_nodes_on_sides(own, &positions, &index)
        };
        let mut polygon = |polygon: &Vec<PlanRing>| -> Vec<Vec<u32>> { polygon.iter().map(&mut ring).collect() };
        let footprints = footprints.iter().map(|polygons| polygons.iter().map(&mut polygon).collect()).collect();
        Noded { positions, footprints }
    }

    /// Returns the polygons of a footprint on their nodes, without those that vanished.
    pub(super) fn polygons(&self, footprint: usize) -> Vec<Vec<PlanRing>> {
        let place = |node: &u32| self.positions.get(*node as usize).copied().unwrap_or_default();
        let ring = |ring: &Vec<u32>| -> PlanRing { ring.iter().map(place).collect() };
        let polygons = self.footprints.get(footprint).into_iter().flatten();
        polygons
            .filter(|polygon| polygon.first().is_some_and(|outline| outline.len() > 2))
            .map(|polygon| polygon.iter().filter(|ring| ring.len() > 2).map(ring).collect())
            .collect()
    }
}

/// Returns the nodes, and the node of each corner: the nearest one within the tolerance. Corners
/// are taken in an order that depends on their positions alone.
fn welded(corners: &[DVec2]) -> (Vec<DVec2>, Vec<u32>) {
    let at = |corner: u32| corners.get(corner as usize).copied().unwrap_or_default();
    let mut order: Vec<u32> = (0..corners.len() as u32).collect();
    order.sort_unstable_by(|&a, &b| lexicographic(at(a).extend(0.0), at(b).extend(0.0)));
    let cell = |place: DVec2| (place / SAME_M).floor().to_array().map(|count| count as i64);
    let (mut nodes, mut node_of): (Vec<DVec2>, Vec<u32>) = (Vec::new(), vec![0; corners.len()]);
    let mut by_cell: HashMap<[i64; 2], u32> = HashMap::new();
    for corner in order {
        let place = at(corner);
        let [x, y] = cell(place);
        let around =
            [-1, 0, 1].into_iter().flat_map(|dx| [-1, 0, 1].map(|dy| [x.saturating_add(dx), y.saturating_add(dy)]));
        let near = around.filter_map(|cell| by_cell.get(&cell).copied()).filter_map(|node| {
            let distance = nodes.get(node as usize)?.distance(place);
            (distance <= SAME_M).then_some((distance, node))
        });
        let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let node = nearest.map_or(nodes.len() as u32, |(_, node)| node);
        if nearest.is_none() {
            nodes.push(place);
            by_cell.entry([x, y]).or_insert(node);
        }
        if let Some(slot) = node_of.get_mut(corner as usize) {
            *slot = node;
        }
    }
    (nodes, node_of)
}

/// Nodes sorted by cells.
struct NodeCells {
    /// Pairs of cell and node, sorted.
    cells: Vec<([i64; 2], u32)>,
}

fn cell_of(place: DVec2) -> [i64; 2] {
    (place / CELL_M).floor().to_array().map(|count| count as i64)
}

impl NodeCells {
    fn new(positions: &[DVec2]) -> NodeCells {
        let mut cells: Vec<_> = (0..).zip(positions).map(|(node, place)| (cell_of(*place), node)).collect();
        cells.sort_unstable();
        NodeCells { cells }
    }

    /// Returns the nodes near a side, column of cells by column.
    fn along(&self, a: DVec2, b: DVec2) -> impl Iterator<Item = u32> + '_ {
        let (west, east) = if a.x <= b.x { (a, b) } else { (b, a) };
        let slope = if east.x - west.x > SAME_M { (east.y - west.y) / (east.x - west.x) } else { 0.0 };
        let [first, _] = cell_of(west - SAME_M);
        let [last, _] = cell_of(east + SAME_M);
        let (low, high) = (west.y.min(east.y) - SAME_M, west.y.max(east.y) + SAME_M);
        (first..=last).flat_map(move |column| {
            let (mut from, mut to) = (low, high);
            if slope != 0.0 {
                let edges = [column as f64 * CELL_M - SAME_M, (column + 1) as f64 * CELL_M + SAME_M];
                let [one, other] = edges.map(|x| west.y + (x.clamp(west.x, east.x) - west.x) * slope);
                (from, to) = (one.min(other) - SAME_M, one.max(other) + SAME_M);
            }
            let [from, to] = [from, to].map(|y| (y / CELL_M).floor() as i64);
            let start = self.cells.partition_point(|(cell, _)| *cell < [column, from]);
            let own = self.cells.get(start..).unwrap_or_default().iter();
            own.take_while(move |(cell, _)| *cell <= [column, to]).map(|(_, node)| *node)
        })
    }
}

/// Returns a ring with all nodes that lie on its sides.
fn with_nodes_on_sides(ring: Vec<u32>, positions: &[DVec2], index: &NodeCells) -> Vec<u32> {
    let place = |node: u32| positions.get(node as usize).copied().unwrap_or_default();
    let mut whole: Vec<u32> = Vec::with_capacity(ring.len());
    for (from, to) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        if whole.last() != Some(from) {
            whole.push(*from);
        }
        let (a, b) = (place(*from), place(*to));
        let length = a.distance(b);
        if !(SAME_M..LONGEST_M).contains(&length) {
            continue;
        }
        let along = (b - a) / length;
        let mut between: Vec<(f64, u32)> = index
            .along(a, b)
            .filter(|node| node != from && node != to)
            .filter_map(|node| {
                let offset = place(node) - a;
                let (reach, off) = (along.dot(offset), along.perp_dot(offset).abs());
                (off <= SAME_M && reach > 0.0 && reach < length).then_some((reach, node))
            })
            .collect();
        between.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        whole.extend(between.into_iter().map(|(_, node)| node));
    }
    while whole.len() > 1 && whole.first() == whole.last() {
        whole.pop();
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    fn house(x: f64, width: f64, depth: f64) -> Vec<Vec<PlanRing>> {
        let at = |dx: f64, y: f64| DVec2::new(690_000.0 + x + dx, 5_330_000.0 + y);
        vec![vec![vec![at(0., 0.), at(width, 0.), at(width, depth), at(0., depth)]]]
    }

    /// Three houses in a row, 1 cm apart and of different depths, share the walls between them: 2
    /// pairs of sides run both ways, and the deepest house has a fifth and a sixth corner where its
    /// neighbours end.
    #[test]
    fn neighbours_share_the_sides_between_them() {
        let noded = Noded::new(&[&house(0.0, 5.0, 10.0), &house(5.01, 5.0, 12.0), &house(10.0, 5.0, 9.0)]);
        let lengths: Vec<usize> = noded.footprints.iter().map(|polygons| polygons[0][0].len()).collect();
        assert_eq!(lengths, [4, 6, 4]);
        let sides: Vec<[u32; 2]> = noded
            .footprints
            .iter()
            .flat_map(|polygons| {
                let ring = &polygons[0][0];
                ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| [*a, *b]).collect::<Vec<_>>()
            })
            .collect();
        let both = sides.iter().filter(|[a, b]| sides.contains(&[*b, *a])).count();
        assert_eq!(both, 4);
        assert_eq!(noded.polygons(1)[0][0].len(), 6);
    }
}
