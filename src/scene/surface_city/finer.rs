//! Crowns on a finer grid than that of the city. In: a raster of crowns, and the city's pieces and
//! ground on its own grid. Out: the same on the grid of the crowns.

use glam::DVec2;

use crate::surface_city::floor::Moved;
use crate::surface_city::lattice::{Lattice, Spot};
use crate::surface_city::layers::{Layer, Layers, check_size, crowns_of, nearest, sampled};
use crate::surface_city::outlines::OUTSIDE;
use crate::terrain::raster::Grid;
use heliotile_core::error::Result;

/// Share of a cell of the city below which cells of crowns are finer.
const FINER: f64 = 0.99;

/// Ground that crowns stand on, on one grid.
pub(super) struct Site {
    /// Crowns by cell.
    pub layers: Layers,
    /// Number of each cell's piece.
    pub pieces: Lattice<u32>,
    /// Heights of the ground, `[corner]`.
    pub ground: Lattice<f32>,
    /// Places of corners that lines of the city move.
    pub moved: Moved,
}

/// Returns true if the cells of a raster are finer than those of a grid.
pub(super) fn is_finer(raster: &Layer, grid: &Grid) -> bool {
    raster.raster.grid.step.max_element() < FINER * grid.step.max_element()
}

impl Site {
    /// Returns the part of a raster of crowns that lies on a city, with the pieces and the ground
    /// below it; `None` if it is less than 2 x 2 cells.
    pub(super) fn new(
        crowns: &Layer,
        trunk_zone: Option<&Layer>,
        layers: &Layers,
        pieces: &Lattice<u32>,
        ground: &Lattice<f32>,
        moved: &Moved,
    ) -> Result<Option<Site>> {
        let city = layers.grid;
        let last = DVec2::new(city.columns as f64 - 1.0, 1.0 - city.rows as f64) * city.step;
        let (north_west, south_east) = (city.first, city.first + last);
        let half = 0.5 * city.step;
        let low = DVec2::new(north_west.x, south_east.y) - half;
        let high = DVec2::new(south_east.x, north_west.y) + half;
        let [columns, rows] = crowns.raster.window(low, high);
        let Some(raster) = crowns.raster.cut(columns, rows) else { return Ok(None) };
        let grid = raster.grid;
        check_size(crowns.file, &grid)?;
        let cells = Lattice::filled(grid.columns, grid.rows, f32::NAN);
        let base = trunk_zone.map(|zone| sampled(&cells, &zone.raster, &raster, nearest));
        let fine = Layers {
            grid,
            surface: cells.like(f32::NAN),
            quantum_m: 0.0,
            ground: None,
            crown: Some(crowns_of(&cells, |[column, row]| raster.height(column, row))),
            base,
            class: None,
        };
        // Place in cells of the city, whose first corner is 0.
        let in_cells =
            |place: DVec2| (grid.first + place - city.first) / city.step * DVec2::new(1.0, -1.0) + DVec2::splat(0.5);
        let mut own = cells.like(OUTSIDE);
        for cell in cells.spots() {
            let at = in_cells(fine.middle(cell)).floor();
            own.set(cell, pieces.at([at.x as i64, at.y as i64]));
        }
        let mut heights = Lattice::filled(grid.columns + 1, grid.rows + 1, f32::NAN);
        let mut places = Moved::new();
        for corner in heights.spots() {
            let around = weights(in_cells(fine.corner(corner)));
            let (mut height, mut by, mut sum) = (0.0, DVec2::ZERO, 0.0);
            for (spot, weight) in around {
                let known = f64::from(ground.at(spot));
                if weight > 0.0 && known.is_finite() {
                    (height, sum) = (height + weight * known, sum + weight);
                }
                if let Some(place) = moved.get(&spot) {
                    by += weight * (*place - layers.corner(spot));
                }
            }
            if sum > 0.0 {
                heights.set(corner, (height / sum) as f32);
            }
            if by != DVec2::ZERO {
                places.insert(corner, fine.corner(corner) + by);
            }
        }
        Ok(Some(Site { layers: fine, pieces: own, ground: heights, moved: places }))
    }
}

/// Returns the four corners around a place, in cells, with their bilinear weights.
fn weights(at: DVec2) -> [(Spot, f64); 4] {
    let (low, part) = (at.floor(), at - at.floor());
    let corner = |x: i64, y: i64, weight: f64| ([low.x as i64 + x, low.y as i64 + y], weight);
    [
        corner(0, 0, (1.0 - part.x) * (1.0 - part.y)),
        corner(1, 0, part.x * (1.0 - part.y)),
        corner(0, 1, (1.0 - part.x) * part.y),
        corner(1, 1, part.x * part.y),
    ]
}
