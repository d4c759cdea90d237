//! Table in the format given by the ending of its name. In: columns, then batches of rows. Out: a
//! file, complete or not there.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::outputs::provenance::Provenance;
use crate::outputs::tables::batch::Batch;
use crate::outputs::tables::column::TableColumns;
use crate::outputs::tables::format::{Format, FormatWriter, Places, TableRequest};
use heliotile_core::error::{Error, Result};

/// Statistics of a table that was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    pub rows: u64,
    pub bytes: u64,
}

/// Table being written.
pub struct TableWriter {
    to: Box<dyn FormatWriter>,
    path: PathBuf,
    columns: Arc<TableColumns>,
    rows: u64,
}

impl TableWriter {
    /// Starts a table in the format given by the ending of its name; `-` is CSV on standard output.
    /// CSV without `about` has no metadata file.
    pub fn create(path: &Path, columns: TableColumns, places: Places, about: Option<&Provenance>) -> Result<Self> {
        let columns = Arc::new(columns);
        let to = Format::of(path)?.start(&TableRequest { path, columns: Arc::clone(&columns), places, about })?;
        Ok(TableWriter { to, path: path.to_path_buf(), columns, rows: 0 })
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

    /// Returns the columns of the table.
    pub fn columns(&self) -> &TableColumns {
        &self.columns
    }

    /// Returns true if the reader of the output has gone away: the caller may stop.
    pub fn is_closed(&self) -> bool {
        self.to.is_closed()
    }

    /// Completes the table; its file appears only now.
    pub fn finish(self) -> Result<Stats> {
        let bytes = self.to.finish()?;
        Ok(Stats { rows: self.rows, bytes })
    }

    /// Returns the error for rows that no caller should hand over.
    pub fn defect(&self, what: String) -> Error {
        rows_defect(&self.path, what)
    }
}

/// Returns the error for rows that do not fit the table at `path`.
pub(super) fn rows_defect(path: &Path, what: String) -> Error {
    Error::defect(path, "table", "rows", what)
}

/// Returns the error for a file that cannot be written, whichever library failed. An error of the
/// system is reported without the library's words.
pub(super) fn failed(path: &Path, error: impl std::error::Error + Send + Sync + 'static) -> Error {
    let mut cause: Option<&(dyn std::error::Error + 'static)> = Some(&error);
    while let Some(found) = cause {
        if let Some(code) = found.downcast_ref::<std::io::Error>().and_then(std::io::Error::raw_os_error) {
            return Error::io(path, "write to")(std::io::Error::from_raw_os_error(code));
        }
        cause = found.source();
    }
    Error::io(path, "write to")(std::io::Error::other(error))
}

#[cfg(test)]
#[path = "writer_tests.rs"]
pub(crate) mod tests;
