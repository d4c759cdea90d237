//! Tables row by row: a few thousand records, or many that are written as they come. In: cells.
//! Out: batches of a table.

use std::path::Path;

use super::batch::{Batch, Values};
use super::column::{Column, Kind, TableColumns};
use super::format::Places;
use super::writer::TableWriter;
use crate::outputs::provenance::Provenance;
use heliotile_core::error::Result;

/// Number of rows that are in memory at a time.
const ROWS_AT_ONCE: usize = 1 << 15;

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

/// Rows with their columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Records {
    pub columns: Vec<Column>,
    pub rows: Vec<Vec<Cell>>,
}

impl Records {
    /// Writes the table and returns its size in bytes.
    pub fn write(self, path: &Path, about: &Provenance) -> Result<u64> {
        let mut table = RowWriter::create(path, self.columns, self.rows.len() as u64, Some(about))?;
        self.rows.into_iter().try_for_each(|row| table.row(row))?;
        table.finish()
    }
}

/// Table that is written row by row.
pub struct RowWriter {
    table: TableWriter,
    pending: Vec<Values<'static>>,
    rows: usize,
}

impl RowWriter {
    /// Starts a table of columns without steps; `count` is the number of rows that will come.
    pub fn create(path: &Path, columns: Vec<Column>, count: u64, about: Option<&Provenance>) -> Result<Self> {
        let table = TableWriter::create(path, TableColumns::new(columns), Places::counted(count), about)?;
        let pending = table.columns().in_batches().map(|column| none_of(column.kind)).collect();
        Ok(RowWriter { table, pending, rows: 0 })
    }

    /// Appends a row. Fails if the cells do not fit the columns.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) -> Result<()> {
        let mut columns = self.pending.iter_mut();
        for cell in cells {
            match (columns.next(), cell) {
                (Some(Values::Texts(texts)), Cell::Text(text)) => texts.to_mut().push(text),
                (Some(Values::Counts(counts)), Cell::Count(count)) => counts.push(count),
                (Some(Values::Numbers(numbers)), Cell::Number(number)) => numbers.push(number),
                (_, other) => return Err(self.table.defect(format!("{other:?} fits no column"))),
            }
        }
        self.rows += 1;
        if self.rows == ROWS_AT_ONCE { self.flush() } else { Ok(()) }
    }

    /// Returns true if the reader of the output has gone away.
    pub fn is_closed(&self) -> bool {
        self.table.is_closed()
    }

    /// Completes the table, whose file appears only now, and returns its size in bytes.
    pub fn finish(mut self) -> Result<u64> {
        self.flush()?;
        Ok(self.table.finish()?.bytes)
    }

    fn flush(&mut self) -> Result<()> {
        let next = self.table.columns().in_batches().map(|column| none_of(column.kind)).collect();
        let values = std::mem::replace(&mut self.pending, next);
        let places = std::mem::take(&mut self.rows);
        self.table.write(&Batch { places, values })
    }
}

/// Returns empty values of a kind.
fn none_of(kind: Kind) -> Values<'static> {
    match kind {
        Kind::Text | Kind::Category => Values::Texts(Vec::new().into()),
        Kind::Count => Values::Counts(Vec::new()),
        Kind::Number(_) | Kind::Float(_) => Values::Numbers(Vec::new()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cell of another kind, one cell too many and one too few are defects: 3 of 3, and no file
    /// is left.
    #[test]
    fn rows_that_do_not_fit_the_columns_are_defects() {
        let folder = tempfile::tempdir().expect("a folder");
        let columns = || vec![Column::text("face"), Column::count("regions"), Column::number("area_m2", 3)];
        let rows: [Vec<Cell>; 3] = [
            vec!["a".into(), 1.0.into(), None.into()],
            vec!["a".into(), Cell::Count(1), None.into(), 2.0.into()],
            vec!["a".into(), Cell::Count(1)],
        ];
        for row in rows {
            let error = Records { columns: columns(), rows: vec![row] }
                .write(&folder.path().join("t.csv"), &Provenance::default())
                .expect_err("a defect");
            assert!(matches!(error, heliotile_core::error::Error::Defect { .. }), "{error}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
    }
}
