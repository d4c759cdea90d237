//! Lists of receivers by id. In: a CSV file with a column `receiver`. Out: the ids in it, one after
//! the other.

use std::path::Path;

use heliotile_core::error::{Error, Problem, Result};
use heliotile_files::csv_rows::CsvRows;

/// Column that is read; all others are ignored.
const COLUMN: &str = "receiver";

/// Iterator over the ids of a list of receivers; it needs bounded memory.
pub struct ReceiverIds<'a> {
    rows: CsvRows<'a>,
    column: usize,
}

impl<'a> ReceiverIds<'a> {
    /// Opens the file and reads its header. Fails if there is no column `receiver`.
    pub fn open(file: &'a Path) -> Result<Self> {
        let mut rows = CsvRows::open(file)?;
        let hint = format!("begin with a line that names a column `{COLUMN}`, then one id a line");
        if !rows.advance()? {
            return Err(Error::input(file, None, "the file is empty", hint));
        }
        match rows.record.iter().position(|name| name == COLUMN) {
            Some(column) => Ok(ReceiverIds { rows, column }),
            None => Err(rows.error(format!("column `{COLUMN}` is missing"), hint).because(Problem::no_column(COLUMN))),
        }
    }
}

impl Iterator for ReceiverIds<'_> {
    /// Id of a receiver and its line.
    type Item = Result<(String, usize)>;

    fn next(&mut self) -> Option<Self::Item> {
        match self.rows.advance() {
            Ok(true) => {}
            Ok(false) => return None,
            Err(error) => return Some(Err(error)),
        }
        Some(match self.rows.record.get(self.column) {
            Some(id) if !id.is_empty() => Ok((id.to_owned(), self.rows.line)),
            _ => Err(self.rows.cell_error(COLUMN, "", "an empty name", "name a receiver in every row")),
        })
    }
}
