//! A table in a format by the ending of its name. In: tiles of values. Out: a file, whole or not there.

use std::path::{Path, PathBuf};

use crate::outputs::groups::Extent;
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::arrow::ArrowTable;
use crate::outputs::tables::csv::CsvTable;
use crate::outputs::tables::csvw;
use crate::outputs::tables::layout::Layout;
use crate::outputs::tables::npy::NpyTable;
use crate::outputs::tables::npz::NpzTable;
use crate::outputs::tables::parquet::ParquetTable;
use crate::outputs::tables::row_labels::RowLabels;
use crate::outputs::tables::table::{Places, Table};
use crate::outputs::tables::tile_columns::TileColumns;
use heliotile_core::error::{Error, Result};
use heliotile_core::replay::values::TileValues;

/// What was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    pub rows: u64,
    pub bytes: u64,
}

/// The file format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Csv,
    Parquet,
    /// Arrow IPC, plain.
    Arrow,
    /// Arrow IPC, compressed.
    Feather,
    Npy,
    Npz,
}

impl Format {
    /// Endings of names.
    pub const ENDINGS: [(&'static str, Format); 6] = [
        ("csv", Format::Csv),
        ("parquet", Format::Parquet),
        ("arrow", Format::Arrow),
        ("feather", Format::Feather),
        ("npy", Format::Npy),
        ("npz", Format::Npz),
    ];

    /// `-` is CSV on the standard output, otherwise the ending of the name says it.
    pub fn of(path: &Path) -> Result<Self> {
        Format::known(path).ok_or_else(|| Error::Unsupported {
            what: "ending of the output file".into(),
            found: format!("`{}`", path.display()),
            supported: Format::listed(),
        })
    }

    /// The same, if there is one.
    pub fn known(path: &Path) -> Option<Self> {
        if path == Path::new("-") {
            return Some(Format::Csv);
        }
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        Format::ENDINGS.iter().find(|(name, _)| *name == ending).map(|(_, format)| *format)
    }

    /// All endings in words.
    pub fn listed() -> String {
        let all: Vec<String> = Format::ENDINGS.iter().map(|(ending, _)| format!(".{ending}")).collect();
        let text = all.join(", ");
        let text = text.rsplit_once(", ").map_or(text.clone(), |(most, last)| format!("{most} and {last}"));
        format!("{text} (or - for CSV on the standard output)")
    }
}

/// The files that a table of this name consists of.
pub fn files_of(path: &Path) -> Vec<PathBuf> {
    let beside = match Format::of(path) {
        Ok(Format::Npy) => Some(NpyTable::axes_of(path)),
        Ok(Format::Csv) if path != Path::new("-") => Some(csvw::beside(path)),
        _ => None,
    };
    [Some(path.to_path_buf()), beside].into_iter().flatten().collect()
}

/// A table being written.
pub struct TableWriter {
    table: Box<dyn Table>,
    path: PathBuf,
    layout: Layout,
    labels: usize,
    rows: u64,
}

impl TableWriter {
    /// Starts a table in the format that the name says.
    pub fn create(
        path: &Path,
        layout: &Layout,
        labels: &RowLabels,
        places: &Places,
        about: &Provenance,
    ) -> Result<Self> {
        let sink = || if path == Path::new("-") { Ok(Sink::stdout()) } else { Sink::file(path) };
        let format = Format::of(path)?;
        let table: Box<dyn Table> = match format {
            Format::Csv => Box::new(CsvTable::new(sink()?, layout, labels, about)?),
            Format::Parquet => Box::new(ParquetTable::new(sink()?, layout, labels, about)?),
            Format::Arrow | Format::Feather => {
                let names = (places.names)()?;
                Box::new(ArrowTable::new(sink()?, layout, labels, &names, about, format == Format::Feather)?)
            }
            Format::Npy => Box::new(NpyTable::new(path, layout, labels, about, places.count)?),
            Format::Npz => Box::new(NpzTable::new(sink()?, layout, labels, about, places.count)?),
        };
        Ok(TableWriter { table, path: path.to_path_buf(), layout: layout.clone(), labels: labels.len(), rows: 0 })
    }

    /// Appends the rows of a tile; a shape other than receivers x labels is an error, nothing is written then.
    /// `extents` are those of groups, as many as rows have names; none for receivers.
    pub fn write_tile(&mut self, receivers: &[String], values: &TileValues, extents: &[Extent]) -> Result<()> {
        if values.receivers() != receivers.len() || values.labels() != self.labels {
            let what = format!(
                "rows of {} receivers x {} labels do not fit {} x {}",
                values.receivers(),
                values.labels(),
                receivers.len(),
                self.labels
            );
            return Err(Error::input(&self.path, None, what, "this is a defect, report it"));
        }
        if receivers.is_empty() || self.labels == 0 || self.is_closed() {
            return Ok(());
        }
        self.table.write_tile(receivers, &TileColumns::of(values, &self.layout, extents))?;
        self.rows += (receivers.len() * self.labels) as u64;
        Ok(())
    }

    /// Whether nobody reads any more: the caller may stop.
    pub fn is_closed(&self) -> bool {
        self.table.is_closed()
    }

    /// Completes the table; only now does its file appear.
    pub fn finish(self) -> Result<Stats> {
        let bytes = self.table.finish()?;
        Ok(Stats { rows: self.rows, bytes })
    }
}

#[cfg(test)]
#[path = "table_tests.rs"]
pub(crate) mod tests;
