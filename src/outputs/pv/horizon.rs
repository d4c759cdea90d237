//! Horizons as files. In: heights at equal distances, clockwise from north. Out: for each point a list as PVGIS takes it, and one table of
//! all in the names of pvlib's `get_pvgis_horizon`.

use std::path::Path;

use super::write_csv;
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::write_texts;
use heliotile_core::error::Result;

/// A horizon and its point.
pub struct PointHorizon {
    pub point: String,
    /// Degrees, from true north clockwise, at equal distances.
    pub altitudes_deg: Vec<f64>,
}

/// Name of a point's file in the folder of horizons.
pub fn file_of(point: &str) -> String {
    format!("{point}.csv")
}

/// Writes one height a line, no header: what PVGIS takes as a horizon file.
pub fn write_lists(folder: &Path, horizons: &[PointHorizon]) -> Result<()> {
    let text = |horizon: &PointHorizon| horizon.altitudes_deg.iter().map(|height| format!("{height:.2}\n")).collect();
    let files: Vec<(String, String)> =
        horizons.iter().map(|horizon| (file_of(&horizon.point), text(horizon))).collect();
    write_texts(folder, &files.iter().map(|(name, text)| (name.as_str(), text.clone())).collect::<Vec<_>>())
}

/// Writes `point,horizon_azimuth,horizon_elevation`, degrees.
pub fn write_table(path: &Path, horizons: &[PointHorizon], about: &Provenance) -> Result<()> {
    let rows =
        horizons.iter().flat_map(|horizon| {
            let step = 360.0 / horizon.altitudes_deg.len() as f64;
            horizon.altitudes_deg.iter().enumerate().map(move |(i, height)| {
                vec![horizon.point.clone(), format!("{}", step * i as f64), format!("{height:.3}")]
            })
        });
    let units = [("horizon_azimuth", "deg"), ("horizon_elevation", "deg")];
    write_csv(path, &["point", "horizon_azimuth", "horizon_elevation"], &units, rows, about)
}
