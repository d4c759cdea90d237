//! Values of sky patches, row by row: radiances of skies, or transmittances of clouds. In: a
//! subdivision and values. Out: the values of one row on any subdivision.

use std::sync::Arc;

use crate::dome::grid::PatchGrid;

/// Values of patches over rows; at least one row.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchSeries {
    grid: PatchGrid,
    /// `[row][patch]`: values.
    numbers: Vec<f32>,
}

impl PatchSeries {
    /// Returns a series of values `[row][patch]`; `None` where there is no row, or a part of one.
    pub fn new(grid: PatchGrid, numbers: Vec<f32>) -> Option<Self> {
        let whole = !numbers.is_empty() && numbers.len().is_multiple_of(grid.len());
        whole.then_some(PatchSeries { grid, numbers })
    }

    /// Returns the subdivision.
    pub fn grid(&self) -> &PatchGrid {
        &self.grid
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.numbers.len() / self.grid.len()
    }

    /// Returns the values of a row; empty beyond the last one.
    pub fn row(&self, row: usize) -> &[f32] {
        let patches = self.grid.len();
        self.numbers.get(row * patches..(row + 1) * patches).unwrap_or_default()
    }

    /// Returns the irradiance of an open horizontal surface under a row of radiances, W/m2.
    pub fn horizontal_w_m2(&self, row: usize) -> f64 {
        self.grid.horizontal_w_m2(self.row(row))
    }
}

/// One row of a series, as a condition holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchRow {
    series: Arc<PatchSeries>,
    row: usize,
    /// Direction of the axes' north clockwise from the series' north, turns.
    turns: f64,
}

impl PatchRow {
    /// Returns a row of a series, whose azimuths refer to true north.
    pub fn new(series: &Arc<PatchSeries>, row: usize) -> Self {
        PatchRow { series: series.clone(), row, turns: 0.0 }
    }

    /// Returns the row in axes whose north lies `north_deg` degrees clockwise.
    pub fn turned(self, north_deg: f64) -> Self {
        PatchRow { turns: self.turns + north_deg / 360.0, ..self }
    }

    /// Returns the values of the row on a subdivision ([`PatchGrid::resampled`]).
    pub fn on(&self, grid: &PatchGrid) -> Vec<f64> {
        self.series.grid.resampled(self.series.row(self.row), grid, self.turns)
    }
}
