//! Writers of tables, whatever their format. In: a path, columns, places. Out: the request and the
//! interface of a writer; errors for rows that do not fit and files that fail.

use std::path::Path;
use std::sync::Arc;

use crate::outputs::provenance::Provenance;
use crate::outputs::tables::batch::Batch;
use crate::outputs::tables::column::TableColumns;
use heliotile_core::error::{Error, Result};

/// Writer of a table in one format.
pub trait FormatWriter {
    /// Appends rows that fit the columns; the batch has at least one row.
    fn write(&mut self, batch: &Batch) -> Result<()>;

    /// Returns true if the reader of the output has gone away.
    fn is_closed(&self) -> bool {
        false
    }

    /// Completes the table and returns its size in bytes.
    fn finish(self: Box<Self>) -> Result<u64>;
}

/// Table to start: path, columns, places and provenance.
pub struct TableRequest<'a> {
    /// Path of the file; `-` is CSV on standard output.
    pub path: &'a Path,
    pub columns: Arc<TableColumns>,
    pub places: Places<'a>,
    /// Provenance of the table. CSV without it has no metadata file.
    pub about: Option<&'a Provenance>,
}

/// Places of a table's rows.
#[derive(Clone, Copy)]
pub struct Places<'a> {
    /// Number of places. Only formats whose files begin with their size need it.
    pub count: u64,
    /// Function that returns the names of places in order. Only some formats call it, for tables
    /// whose places are categories.
    pub names: &'a dyn Fn() -> Result<Vec<String>>,
}

impl Places<'_> {
    /// Returns `count` places that are no categories.
    pub fn counted(count: u64) -> Self {
        Places { count, names: &no_names }
    }
}

fn no_names() -> Result<Vec<String>> {
    Ok(Vec::new())
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
