//! The one row model of all results: a label, a receiver, six components and their total.
//!
//! In: tiles of values, `[component][receiver][label]`, f32. Out: rows, receiver-major inside a tile (all labels of receiver
//! 0, then of receiver 1), as CSV or Parquet by the ending of the file's name.

use std::path::Path;

use super::csv::CsvTable;
use super::parquet::ParquetTable;
use super::sink::Sink;
use crate::error::{Error, Result};
pub use crate::recombine::values::{COMPONENTS, TileValues};

/// Ending of the value columns of period sums.
pub const SUM_SUFFIX: &str = "_kwh_m2";

/// What the rows of a table are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Columns {
    /// `condition`, means in W/m2.
    Conditions,
    /// `time`, means in W/m2.
    Times,
    /// `time` (a period), sums in kWh/m2.
    Sums,
}

impl Columns {
    /// Names of the nine columns.
    pub fn names(self) -> Vec<String> {
        let label = match self {
            Columns::Conditions => "condition",
            Columns::Times | Columns::Sums => "time",
        };
        let suffix = match self {
            Columns::Sums => SUM_SUFFIX,
            _ => "",
        };
        let values = COMPONENTS.iter().map(|name| format!("{name}{suffix}"));
        [label.to_string(), "receiver".to_string()].into_iter().chain(values).collect()
    }

    /// Unit of the value columns.
    pub fn unit(self) -> &'static str {
        match self {
            Columns::Sums => "kWh/m2",
            _ => "W/m2",
        }
    }
}

/// What was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    pub rows: u64,
    pub bytes: u64,
}

/// A table being written.
pub struct TableWriter {
    format: Format,
    labels: usize,
    rows: u64,
}

enum Format {
    Csv(CsvTable),
    Parquet(Box<ParquetTable>),
}

impl TableWriter {
    /// Starts a table: `-` is CSV on the standard output, otherwise the ending says `.csv` or `.parquet`.
    pub fn create(path: &Path, kind: Columns, labels: &[String]) -> Result<Self> {
        let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        let format = if path == Path::new("-") {
            Format::Csv(CsvTable::new(Sink::stdout(), kind, labels)?)
        } else {
            match ending.as_deref() {
                Some("csv") => Format::Csv(CsvTable::new(Sink::file(path)?, kind, labels)?),
                Some("parquet") => {
                    let table = ParquetTable::new(Sink::file(path)?, kind, labels)?;
                    Format::Parquet(Box::new(table))
                }
                _ => {
                    return Err(Error::Unsupported {
                        what: "ending of the output file".into(),
                        found: format!("`{}`", path.display()),
                        supported: ".csv and .parquet (or - for CSV on the standard output)".into(),
                    });
                }
            }
        };
        Ok(TableWriter { format, labels: labels.len(), rows: 0 })
    }

    /// Appends the rows of a tile; a shape other than receivers x labels is an error, nothing is written then.
    pub fn write_tile(&mut self, receivers: &[String], values: &TileValues) -> Result<()> {
        if values.receivers() != receivers.len() || values.labels() != self.labels {
            let what = format!(
                "rows of {} receivers x {} labels do not fit {} x {}",
                values.receivers(),
                values.labels(),
                receivers.len(),
                self.labels
            );
            return Err(Error::input(self.path(), None, what, "this is a defect, report it"));
        }
        if receivers.is_empty() || self.labels == 0 || self.is_closed() {
            return Ok(());
        }
        match &mut self.format {
            Format::Csv(table) => table.write_tile(receivers, values)?,
            Format::Parquet(table) => table.write_tile(receivers, values)?,
        }
        self.rows += (receivers.len() * self.labels) as u64;
        Ok(())
    }

    /// Whether nobody reads any more: the caller may stop.
    pub fn is_closed(&self) -> bool {
        match &self.format {
            Format::Csv(table) => table.is_closed(),
            Format::Parquet(_) => false,
        }
    }

    fn path(&self) -> &Path {
        match &self.format {
            Format::Csv(table) => table.path(),
            Format::Parquet(table) => table.path(),
        }
    }

    /// Completes the table; only now does its file appear.
    pub fn finish(self) -> Result<Stats> {
        let bytes = match self.format {
            Format::Csv(table) => table.finish()?,
            Format::Parquet(table) => table.finish()?,
        };
        Ok(Stats { rows: self.rows, bytes })
    }
}

#[cfg(test)]
#[path = "table_tests.rs"]
mod tests;
