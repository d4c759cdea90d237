//! Rasters on one grid. In: a raster of surface heights in its place, and its companions on any
//! grid. Out: the value of each raster in every cell of the first one.

use std::path::Path;

use glam::DVec2;

use crate::surface_city::lattice::{Lattice, Spot};
use crate::terrain::raster::{Grid, Raster};
use heliotile_core::error::{Error, Result};

/// Code of cells without land cover.
pub(super) const NO_CLASS: u16 = u16::MAX;

/// Most cells of a surface: its cells, corners and labels take some 100 bytes each while it becomes
/// a city.
pub(crate) const MAX_CELLS: u64 = 1 << 25;

/// A raster in its place, and its file for messages.
pub(crate) struct Layer<'a> {
    pub file: &'a Path,
    pub raster: Raster,
}

/// Companions of a raster of surface heights.
#[derive(Default)]
pub(crate) struct Companions<'a> {
    pub dem: Option<Layer<'a>>,
    pub canopy: Option<Layer<'a>>,
    pub trunk_zone: Option<Layer<'a>>,
    pub landcover: Option<Layer<'a>>,
}

/// Values of all rasters by cell.
pub(super) struct Layers {
    pub grid: Grid,
    /// Heights of roofs and ground; NaN in cells without a height.
    pub surface: Lattice<f32>,
    /// Step between heights of the surface, metres; 0 if it is not known.
    pub quantum_m: f64,
    /// Heights of the ground.
    pub ground: Option<Lattice<f32>>,
    /// Heights of crowns above the ground; 0 for no crown.
    pub crown: Option<Lattice<f32>>,
    /// Heights of the undersides of crowns above the ground; NaN where none is stated.
    pub base: Option<Lattice<f32>>,
    /// Codes of land cover.
    pub class: Option<Lattice<u16>>,
}

impl Layers {
    /// Samples all rasters at the middles of the cells of the first one.
    pub(super) fn new(dsm: &Layer, with: &Companions) -> Result<Layers> {
        let grid = dsm.raster.grid;
        check_size(dsm.file, &grid)?;
        let cells = Lattice::filled(grid.columns, grid.rows, f32::NAN);
        let mut surface = cells.like(f32::NAN);
        for spot in cells.spots() {
            surface.set(spot, dsm.raster.height(spot[0], spot[1]));
        }
        let sampled = |layer: &Option<Layer>, sample: Sample| {
            layer.as_ref().map(|layer| sampled(&cells, &layer.raster, &dsm.raster, sample))
        };
        let base = sampled(&with.trunk_zone, nearest);
        let crown = sampled(&with.canopy, nearest).map(|heights| crowns_of(&cells, |spot| heights.at(spot)));
        let class = sampled(&with.landcover, nearest).map(|codes| {
            let mut class = cells.like(NO_CLASS);
            for spot in cells.spots() {
                let code = codes.at(spot);
                if (0.0..65_535.0).contains(&code) {
                    class.set(spot, code.round() as u16);
                }
            }
            class
        });
        let ground = sampled(&with.dem, between);
        Ok(Layers { grid, surface, quantum_m: dsm.raster.quantum_m, ground, crown, base, class })
    }

    /// Returns the middle of a cell relative to that of the first one, metres.
    #[inline]
    pub(super) fn middle(&self, [column, row]: Spot) -> DVec2 {
        DVec2::new(column as f64, -(row as f64)) * self.grid.step
    }

    /// Returns the north-west corner of a cell relative to the middle of the first one, metres.
    #[inline]
    pub(super) fn corner(&self, [column, row]: Spot) -> DVec2 {
        DVec2::new(column as f64 - 0.5, 0.5 - row as f64) * self.grid.step
    }

    /// Returns the area of a cell, m2.
    pub(super) fn cell_m2(&self) -> f64 {
        self.grid.step.x * self.grid.step.y
    }

    /// Returns the width of a cell, metres.
    pub(super) fn cell_m(&self) -> f64 {
        self.grid.step.max_element()
    }
}

/// Way to read a raster at a place.
type Sample = fn(&Raster, DVec2) -> f32;

/// Returns the values of a raster at the middles of the cells of another one.
pub(super) fn sampled(cells: &Lattice<f32>, raster: &Raster, of_cells: &Raster, sample: Sample) -> Lattice<f32> {
    let mut values = cells.like(f32::NAN);
    for [column, row] in cells.spots() {
        values.set([column, row], sample(raster, of_cells.plan(column, row)));
    }
    values
}

/// Returns the heights of crowns above the ground on a grid of cells: 0 for a height that is
/// negative or NaN.
pub(super) fn crowns_of(cells: &Lattice<f32>, height: impl Fn(Spot) -> f32) -> Lattice<f32> {
    let mut crowns = cells.like(0.0);
    for spot in cells.spots() {
        // `max` skips NaN.
        crowns.set(spot, height(spot).max(0.0));
    }
    crowns
}

/// Checks that a raster is not too large to become a city at once.
pub(super) fn check_size(file: &Path, grid: &Grid) -> Result<()> {
    let cells = grid.columns as u64 * grid.rows as u64;
    if cells <= MAX_CELLS {
        return Ok(());
    }
    let (columns, rows) = (grid.columns, grid.rows);
    let what = format!("{columns} x {rows} cells are more than the {MAX_CELLS} that become a city at once");
    let hint = "cut the region into parts ({command:atlas partition}), cut the raster (`gdalwarp -te west south east north in.tif out.tif`), or make \
                it coarser (`gdalwarp -tr 2 2 -r average in.tif out.tif`)";
    Err(Error::input(file, None, what, hint))
}

/// Checks that a raster has the coordinate system of a surface and a value on at least one of its
/// cells.
pub(super) fn check_place(dsm: &Layer, other: &Layer) -> Result<()> {
    if let (Some(one), Some(another)) = (dsm.raster.reference, other.raster.reference)
        && one != another
    {
        let what = format!("is in {another}, but {} is in {one}", dsm.file.display());
        let hint = "reproject it: `gdalwarp -t_srs EPSG:number in.tif out.tif`";
        return Err(Error::input(other.file, None, what, hint));
    }
    let Grid { columns, rows, .. } = dsm.raster.grid;
    let has_value = |row: usize| {
        (0..columns).any(|column| !nearest(&other.raster, dsm.raster.plan(column as i64, row as i64)).is_nan())
    };
    if (0..rows).any(has_value) {
        return Ok(());
    }
    let what = format!("has no value on {}", dsm.file.display());
    Err(Error::input(other.file, None, what, "give rasters of one place, in one coordinate system"))
}

/// Returns the sample whose cell holds a place.
pub(super) fn nearest(raster: &Raster, place: DVec2) -> f32 {
    let at = ((place - raster.grid.first) / raster.grid.step).round();
    raster.height(at.x as i64, -at.y as i64)
}

/// Returns the height interpolated between four samples, or that of the nearest sample if one of
/// them has none.
fn between(raster: &Raster, place: DVec2) -> f32 {
    let at = (place - raster.grid.first) / raster.grid.step * DVec2::new(1.0, -1.0);
    let (low, part) = (at.floor(), at - at.floor());
    let height = |x: i64, y: i64| f64::from(raster.height(low.x as i64 + x, low.y as i64 + y));
    let (north, south) =
        (height(0, 0) * (1.0 - part.x) + height(1, 0) * part.x, height(0, 1) * (1.0 - part.x) + height(1, 1) * part.x);
    let found = (north * (1.0 - part.y) + south * part.y) as f32;
    if found.is_nan() { nearest(raster, place) } else { found }
}
