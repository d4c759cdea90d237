//! Outputs of `pv`: sums a point and side, months, hours in the names of pvlib, horizons as PVGIS has them, turns that were tried. In:
//! values in kWh/m2 or W/m2. Out: files, each complete or not there.

pub mod horizon;
pub mod hourly;
pub mod places;
pub mod polar;
pub mod search;
pub mod sums;

use std::io;
use std::path::Path;

use super::provenance::Provenance;
use super::sink::Sink;
use super::tables::csvw::{self, CsvColumn};
use heliotile_core::error::{Error, Result};

/// Writes a CSV file, and beside it what its columns are: those of `units` have theirs, the rest what their names say.
fn write_csv(
    path: &Path,
    names: &[&str],
    units: &[(&str, &'static str)],
    rows: impl Iterator<Item = Vec<String>>,
    about: &Provenance,
) -> Result<()> {
    let mut csv = csv::Writer::from_writer(Sink::file(path)?);
    let failed = |error: csv::Error| Error::io(path, "write to")(io::Error::from(error));
    csv.write_record(names).map_err(failed)?;
    for row in rows {
        csv.write_record(&row).map_err(failed)?;
    }
    let column = |name: &&str| match units.iter().find(|(known, _)| known == name) {
        Some((_, unit)) => CsvColumn::number(name).with_unit(unit),
        None => CsvColumn::named(name),
    };
    csvw::write(path, &names.iter().map(column).collect::<Vec<_>>(), about)?;
    let sink = csv.into_inner().map_err(|error| Error::io(path, "write to")(error.into_error()))?;
    sink.finish().map(|_| ())
}
