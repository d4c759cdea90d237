//! Horizons as files. In: heights at equal distances, clockwise from north. Out: for each point a
//! list in PVGIS's format, and one table of all with the names of pvlib's `get_pvgis_horizon`.

use std::path::Path;

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::write_texts;
use crate::outputs::tables::column::{Column, Digits};
use crate::outputs::tables::records::Records;
use crate::outputs::tables::table::Cell;
use heliotile_core::error::Result;

/// Horizon of a point.
pub struct PointHorizon {
    pub point: String,
    /// Heights of the horizon, degrees, clockwise from true north, at equal distances.
    pub altitudes_deg: Vec<f64>,
}

/// Returns the name of a point's file in the folder of horizons.
pub fn file_of(point: &str) -> String {
    format!("{point}.csv")
}

/// Writes lists with one height a line and no header: the format of PVGIS's horizon files.
pub fn write_lists(folder: &Path, horizons: &[PointHorizon]) -> Result<()> {
    let text = |horizon: &PointHorizon| horizon.altitudes_deg.iter().map(|height| format!("{height:.2}\n")).collect();
    let files: Vec<(String, String)> =
        horizons.iter().map(|horizon| (file_of(&horizon.point), text(horizon))).collect();
    write_texts(folder, &files)
}

/// Writes a table `point,horizon_azimuth,horizon_elevation`, degrees.
pub fn write_table(path: &Path, horizons: &[PointHorizon], about: &Provenance) -> Result<()> {
    let azimuth = Column::number_as("horizon_azimuth", Digits::Fewest).with_unit("deg");
    let columns = vec![Column::text("point"), azimuth, Column::number("horizon_elevation", 3).with_unit("deg")];
    let rows = horizons.iter().flat_map(rows_of).collect();
    Records { columns, rows }.write(path, about).map(drop)
}

/// Returns the rows of a point.
fn rows_of(horizon: &PointHorizon) -> Vec<Vec<Cell>> {
    let step = 360.0 / horizon.altitudes_deg.len() as f64;
    let row = |(i, height): (usize, &f64)| vec![Cell::from(&horizon.point), (step * i as f64).into(), (*height).into()];
    horizon.altitudes_deg.iter().enumerate().map(row).collect()
}
