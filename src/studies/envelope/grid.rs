//! Grid over a plot. In: areas in plan, the ground below them. Out: nodes with the height that a
//! building may have there, and the squares between them.

use glam::DVec2;

use heliotile_scene::points::areas::GroundArea;

/// Node of a grid.
pub struct Node {
    /// Place in plan, input coordinates, metres.
    pub at: DVec2,
    /// Height of the ground, input coordinates, metres.
    pub ground_m: f64,
    /// Area of the plot that is nearest to the node, m2.
    pub area_m2: f64,
    /// Number of the area that the node belongs to.
    pub plot: usize,
}

/// Nodes and squares on a plot.
pub struct Grid {
    /// Nodes of all areas.
    pub nodes: Vec<Node>,
    /// `[square]`: nodes at its corners, counterclockwise as seen from above.
    pub squares: Vec<[usize; 4]>,
    /// Longest diagonal of a square, metres.
    pub diagonal_m: f64,
}

impl Grid {
    /// Returns squares that lie within areas, with sides of about `spacing_m` along the longest
    /// side of their area. `ground` returns the height of the ground; squares without any are left
    /// out.
    pub fn new(areas: &[GroundArea], spacing_m: f64, ground: impl Fn(DVec2) -> Option<f64>) -> Self {
        let mut grid = Grid { nodes: Vec::new(), squares: Vec::new(), diagonal_m: 0.0 };
        for (plot, area) in areas.iter().enumerate() {
            grid.add(plot, area, spacing_m, &ground);
        }
        grid
    }

    fn add(&mut self, plot: usize, area: &GroundArea, spacing_m: f64, ground: &impl Fn(DVec2) -> Option<f64>) {
        let along = area.longest_side().normalize_or(DVec2::X);
        let across = along.perp();
        let in_axes = |corner: DVec2| DVec2::new(corner.dot(along), corner.dot(across));
        let corners = || area.corners().map(in_axes);
        let (low, high) =
            (corners().fold(DVec2::INFINITY, DVec2::min), corners().fold(DVec2::NEG_INFINITY, DVec2::max));
        let counts = ((high - low) / spacing_m).round().max(DVec2::ONE);
        let (columns, rows) = (counts.x as usize, counts.y as usize);
        let step = (high - low) / counts;
        self.diagonal_m = self.diagonal_m.max(step.length());
        let place = |column: usize, row: usize| {
            let own = low + step * DVec2::new(column as f64, row as f64);
            along * own.x + across * own.y
        };
        // `[node]`: number among the nodes that some square uses.
        let mut numbers: Vec<Option<usize>> = vec![None; (columns + 1) * (rows + 1)];
        let grounds: Vec<Option<f64>> =
            (0..numbers.len()).map(|node| ground(place(node % (columns + 1), node / (columns + 1)))).collect();
        for row in 0..rows {
            for column in 0..columns {
                let node = row * (columns + 1) + column;
                let around = [node, node + 1, node + columns + 2, node + columns + 1];
                let corners = around.map(|node| place(node % (columns + 1), node / (columns + 1)));
                let [Some(a), Some(b), Some(c), Some(d)] = around.map(|node| grounds[node]) else { continue };
                if !area.holds(corners) {
                    continue;
                }
                let square = [(0, a), (1, b), (2, c), (3, d)].map(|(corner, ground_m)| {
                    *numbers[around[corner]].get_or_insert_with(|| {
                        self.nodes.push(Node { at: corners[corner], ground_m, area_m2: 0.0, plot });
                        self.nodes.len() - 1
                    })
                });
                square.iter().for_each(|node| self.nodes[*node].area_m2 += 0.25 * step.element_product());
                self.squares.push(square);
            }
        }
    }

    /// Returns the area of the squares, m2.
    pub fn area_m2(&self) -> f64 {
        self.nodes.iter().map(|node| node.area_m2).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of 20 x 10 m has 15 squares and 24 nodes at 4 m: 5 x 3 squares of 4 x 3.33 m. Where
    /// one node has no ground, the four squares around it are left out.
    #[test]
    fn squares_fill_a_box() {
        let area = GroundArea::of_box("plot".into(), DVec2::new(80_000.0, 450_000.0), DVec2::new(80_020.0, 450_010.0));
        let grid = Grid::new(std::slice::from_ref(&area), 4.0, |_| Some(1.0));
        assert_eq!((grid.squares.len(), grid.nodes.len()), (15, 24));
        assert!((grid.area_m2() - 200.0).abs() < 1e-6, "{}", grid.area_m2());
        let hole = |at: DVec2| (at.distance(DVec2::new(80_008.0, 450_003.3)) > 1.0).then_some(1.0);
        assert_eq!(Grid::new(&[area], 4.0, hole).squares.len(), 11);
    }
}
