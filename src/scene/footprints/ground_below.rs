//! Ground below buildings. In: rasters in scene coordinates, and triangles of class ground. Out:
//! the height of the ground at a place, and the lowest ground below an outline.

use glam::{DVec2, DVec3};

use crate::footprint::PlanRing;
use crate::terrain::raster::Raster;

/// Distance of the places along an outline's sides where the ground is sampled, metres; corners are
/// sampled, too.
const STEP_M: f64 = 5.0;
/// Most sampled places along one side.
const MAX_STEPS: f64 = 200.0;

/// Least width of the cells that triangles are sorted into, metres; otherwise there are as many
/// cells as triangles.
const MIN_CELL_M: f64 = 0.5;
/// Most cells that a triangle is listed in; a triangle over more cells is tested at every place.
const MAX_CELLS: i64 = 4096;

/// Ground of all files of a scene.
pub(crate) struct GroundBelow<'a> {
    rasters: Vec<&'a Raster>,
    triangles: Vec<[DVec3; 3]>,
    low: DVec2,
    cell_m: f64,
    /// Pairs of cell and triangle, sorted.
    cells: Vec<([i64; 2], u32)>,
    /// Triangles that reach over too many cells.
    large: Vec<u32>,
}

impl<'a> GroundBelow<'a> {
    pub(crate) fn new(rasters: Vec<&'a Raster>, triangles: Vec<[DVec3; 3]>) -> Self {
        let corners = || triangles.iter().flatten().map(|corner| corner.truncate());
        let low = corners().fold(DVec2::INFINITY, DVec2::min);
        let size = corners().fold(DVec2::NEG_INFINITY, DVec2::max) - low;
        let cell_m = (size.x * size.y / triangles.len().max(1) as f64).sqrt();
        let cell_m = if cell_m.is_finite() { cell_m.max(MIN_CELL_M) } else { MIN_CELL_M };
        let mut ground = GroundBelow { rasters, triangles, low, cell_m, cells: Vec::new(), large: Vec::new() };
        for (number, triangle) in (0..).zip(&ground.triangles) {
            let [a, b, c] = triangle.map(|corner| corner.truncate());
            let ([x0, y0], [x1, y1]) = (ground.cell(a.min(b).min(c)), ground.cell(a.max(b).max(c)));
            if (x1 - x0 + 1).saturating_mul(y1 - y0 + 1) > MAX_CELLS {
                ground.large.push(number);
                continue;
            }
            for x in x0..=x1 {
                ground.cells.extend((y0..=y1).map(|y| ([x, y], number)));
            }
        }
        ground.cells.sort_unstable();
        ground
    }

    /// Returns true if there is no ground.
    pub(crate) fn is_empty(&self) -> bool {
        self.rasters.is_empty() && self.triangles.is_empty()
    }

    /// Returns the lowest ground below the rings of some outlines; `None` if there is no ground
    /// below them.
    pub(crate) fn lowest<'r>(&self, rings: impl Iterator<Item = &'r PlanRing>) -> Option<f64> {
        let mut lowest: Option<f64> = None;
        for ring in rings {
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                let steps = (a.distance(*b) / STEP_M).ceil().clamp(1.0, MAX_STEPS);
                for step in 0..steps as u32 {
                    let height = self.height(a.lerp(*b, f64::from(step) / steps));
                    lowest = height.map(|height| lowest.map_or(height, |lowest| lowest.min(height))).or(lowest);
                }
            }
        }
        lowest
    }

    /// Returns the height of the ground at a place: that of the first raster that has one, else of
    /// the highest triangle.
    pub(crate) fn height(&self, at: DVec2) -> Option<f64> {
        let of_raster = self.rasters.iter().find_map(|raster| of_raster(raster, at));
        of_raster.or_else(|| {
            let cell = self.cell(at);
            let first = self.cells.partition_point(|(other, _)| *other < cell);
            let own = self.cells.get(first..).unwrap_or_default().iter().take_while(|(other, _)| *other == cell);
            let near = own.map(|(_, number)| *number).chain(self.large.iter().copied());
            let heights = near.filter_map(|number| of_triangle(self.triangles.get(number as usize)?, at));
            heights.reduce(f64::max)
        })
    }

    fn cell(&self, at: DVec2) -> [i64; 2] {
        // The cast saturates far away.
        ((at - self.low) / self.cell_m).floor().to_array().map(|count| count as i64)
    }
}

/// Returns the height of a raster at a place, interpolated between four samples. Up to half a cell
/// beyond the outermost samples their height counts.
fn of_raster(raster: &Raster, at: DVec2) -> Option<f64> {
    let grid = &raster.grid;
    let place = (at - grid.first) / grid.step * DVec2::new(1.0, -1.0);
    let last = DVec2::new(grid.columns as f64 - 1.0, grid.rows as f64 - 1.0);
    if place.cmplt(DVec2::splat(-0.5)).any() || place.cmpgt(last + 0.5).any() {
        return None;
    }
    let place = place.clamp(DVec2::ZERO, last);
    let corner = place.floor().min(last - 1.0).max(DVec2::ZERO);
    let ([column, row], [x, y]) = (corner.to_array().map(|count| count as i64), (place - corner).to_array());
    let (mut height, mut weight) = (0.0, 0.0);
    for (dx, dy, share) in [(0, 0, (1.0 - x) * (1.0 - y)), (1, 0, x * (1.0 - y)), (0, 1, (1.0 - x) * y), (1, 1, x * y)]
    {
        let sample = f64::from(raster.height(column + dx, row + dy));
        if sample.is_finite() && share > 0.0 {
            height += share * sample;
            weight += share;
        }
    }
    (weight > 0.0).then(|| height / weight)
}

fn of_triangle(triangle: &[DVec3; 3], at: DVec2) -> Option<f64> {
    let [a, b, c] = *triangle;
    let (ab, ac, p) = ((b - a).truncate(), (c - a).truncate(), at - a.truncate());
    let turn = ab.perp_dot(ac);
    let (u, v) = (p.perp_dot(ac) / turn, ab.perp_dot(p) / turn);
    // A point on the side of two triangles must be in at least one of them, however it is rounded.
    let inside = u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9;
    inside.then_some(a.z + u * (b.z - a.z) + v * (c.z - a.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a slope of 1 in 10 of two triangles of 100 m, the lowest ground below a house of 10 m at
    /// x = 20 m is 2 m high within 1e-9; beside the slope there is no ground.
    #[test]
    fn the_lowest_corner_counts() {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.1 * x);
        let corners = [at(0., 0.), at(100., 0.), at(100., 100.), at(0., 100.)];
        let slope = vec![[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]];
        let ground = GroundBelow::new(Vec::new(), slope);
        let house = |x: f64| -> PlanRing {
            [(0., 0.), (10., 0.), (10., 10.), (0., 10.)].map(|(dx, dy)| DVec2::new(x + dx, 50.0 + dy)).to_vec()
        };
        assert!((ground.lowest([house(20.0)].iter()).expect("ground") - 2.0).abs() < 1e-9);
        assert_eq!(ground.lowest([house(200.0)].iter()), None);
        assert!(!ground.is_empty() && GroundBelow::new(Vec::new(), Vec::new()).is_empty());
    }
}
