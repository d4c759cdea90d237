//! Numbers of patches, row by row: radiances of skies, or what clouds let through. In: a subdivision and numbers. Out: those of one row on any
//! subdivision.

use std::sync::Arc;

use crate::dome::grid::PatchGrid;

/// Numbers of patches over rows; at least one row.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchSeries {
    grid: PatchGrid,
    /// `[row][patch]`
    numbers: Vec<f32>,
}

impl PatchSeries {
    /// Numbers `[row][patch]` of whole rows; none where there is no row, or a part of one.
    pub fn new(grid: PatchGrid, numbers: Vec<f32>) -> Option<Self> {
        let whole = !numbers.is_empty() && numbers.len().is_multiple_of(grid.len());
        whole.then_some(PatchSeries { grid, numbers })
    }

    /// Its patches.
    pub fn grid(&self) -> &PatchGrid {
        &self.grid
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.numbers.len() / self.grid.len()
    }

    /// Numbers of a row; empty beyond the last one.
    pub fn row(&self, row: usize) -> &[f32] {
        let patches = self.grid.len();
        self.numbers.get(row * patches..(row + 1) * patches).unwrap_or_default()
    }

    /// Irradiance of an open horizontal surface under a row of radiances, W/m2.
    pub fn horizontal_w_m2(&self, row: usize) -> f64 {
        self.grid.horizontal_w_m2(self.row(row))
    }
}

/// One row of a series, as a condition holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchRow {
    series: Arc<PatchSeries>,
    row: usize,
    /// Where the axes' north lies clockwise of the series' north.
    turns: f64,
}

impl PatchRow {
    /// A row of a series, whose azimuths go by true north.
    pub fn new(series: &Arc<PatchSeries>, row: usize) -> Self {
        PatchRow { series: series.clone(), row, turns: 0.0 }
    }

    /// The row in axes whose north lies so many degrees clockwise.
    pub fn turned(self, north_deg: f64) -> Self {
        PatchRow { turns: self.turns + north_deg / 360.0, ..self }
    }

    /// Its numbers on a subdivision ([`PatchGrid::resampled`]).
    pub fn on(&self, grid: &PatchGrid) -> Vec<f64> {
        self.series.grid.resampled(self.series.row(self.row), grid, self.turns)
    }
}
