//! Table in the format given by the ending of its name. In: columns, then rows in batches or one by
//! one. Out: a file, complete or not there.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::outputs::provenance::Provenance;
use crate::outputs::tables::batch::{Batch, Values};
use crate::outputs::tables::column::{Column, Kind, TableColumns};
use crate::outputs::tables::format::Format;
use crate::outputs::tables::writer::{FormatWriter, Places, TableRequest, rows_defect};
use heliotile_core::error::{Error, Result};

/// Number of single rows that are in memory at a time.
const ROWS_AT_ONCE: usize = 1 << 15;

/// Statistics of a table that was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    pub rows: u64,
    pub bytes: u64,
}

/// Value of a row; all cells of a column are of one variant.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    Text(String),
    Count(u64),
    /// Number, or an empty cell.
    Number(Option<f64>),
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::Text(text.to_owned())
    }
}

impl From<&String> for Cell {
    fn from(text: &String) -> Self {
        Cell::Text(text.clone())
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Cell::Number(Some(number))
    }
}

impl From<Option<f64>> for Cell {
    fn from(number: Option<f64>) -> Self {
        Cell::Number(number)
    }
}

/// Table being written.
pub struct Table {
    to: Box<dyn FormatWriter>,
    path: PathBuf,
    columns: Arc<TableColumns>,
    rows: u64,
    /// Single rows that wait for a batch, and their number.
    pending: Vec<Values<'static>>,
    waiting: usize,
}

impl Table {
    /// Starts a table in the format given by the ending of its name; `-` is CSV on standard output.
    /// CSV without `about` has no metadata file.
    pub fn create(path: &Path, columns: TableColumns, places: Places, about: Option<&Provenance>) -> Result<Self> {
        let columns = Arc::new(columns);
        let to =
            Format::by_ending(path)?.start(&TableRequest { path, columns: Arc::clone(&columns), places, about })?;
        let pending = empty(&columns);
        Ok(Table { to, path: path.to_path_buf(), columns, rows: 0, pending, waiting: 0 })
    }

    /// Starts a table of columns without bins, as [`Table::create`] does; `count` is the number of
    /// rows that will come.
    pub fn of_rows(path: &Path, columns: Vec<Column>, count: u64, about: Option<&Provenance>) -> Result<Self> {
        Table::create(path, TableColumns::new(columns), Places::counted(count), about)
    }

    /// Appends a row. Fails if the cells do not fit the columns.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) -> Result<()> {
        let mut columns = self.pending.iter_mut();
        for cell in cells {
            match (columns.next(), cell) {
                (Some(Values::Texts(texts)), Cell::Text(text)) => texts.to_mut().push(text),
                (Some(Values::Counts(counts)), Cell::Count(count)) => counts.push(count),
                (Some(Values::Numbers(numbers)), Cell::Number(number)) => numbers.push(number),
                (_, other) => return Err(self.defect(format!("{other:?} fits no column"))),
            }
        }
        self.waiting += 1;
        if self.waiting == ROWS_AT_ONCE { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<()> {
        let values = std::mem::replace(&mut self.pending, empty(&self.columns));
        let places = std::mem::take(&mut self.waiting);
        self.write(&Batch { places, values })
    }

    /// Appends rows. Fails, and writes nothing, if the values do not fit the columns.
    pub fn write(&mut self, batch: &Batch) -> Result<()> {
        if let Some(misfit) = batch.misfit(&self.columns) {
            return Err(self.defect(misfit));
        }
        let rows = batch.places * self.columns.rows_of_place();
        if rows == 0 || self.is_closed() {
            return Ok(());
        }
        self.to.write(batch)?;
        self.rows += rows as u64;
        Ok(())
    }

    /// Returns true if numbers are written as text.
    pub fn is_text(&self) -> bool {
        Format::known(&self.path) == Some(Format::Csv)
    }

    /// Returns true if the reader of the output has gone away: the caller may stop.
    pub fn is_closed(&self) -> bool {
        self.to.is_closed()
    }

    /// Completes the table; its file appears only now.
    pub fn finish(mut self) -> Result<Stats> {
        self.flush()?;
        let bytes = self.to.finish()?;
        Ok(Stats { rows: self.rows, bytes })
    }

    /// Returns the error for rows that no caller should hand over.
    pub fn defect(&self, what: String) -> Error {
        rows_defect(&self.path, what)
    }
}

/// Returns empty values for each column of a batch.
fn empty(columns: &TableColumns) -> Vec<Values<'static>> {
    let of_kind = |kind| match kind {
        Kind::Text | Kind::Category => Values::Texts(Vec::new().into()),
        Kind::Count => Values::Counts(Vec::new()),
        Kind::Number(_) | Kind::Float(_) => Values::Numbers(Vec::new()),
    };
    columns.in_batches().map(|column| of_kind(column.kind)).collect()
}

#[cfg(test)]
#[path = "table_tests.rs"]
pub(crate) mod tests;
