//! Spill: sorting of records that do not fit in memory. In: byte records in any order. Out: the
//! same records by key, read one after the other, as often as wanted.
//!
//! Runs that exceed the budget go to unnamed temporary files. The operating system removes them
//! when the program ends, even after a crash. Replay uses such files, too, for what it cannot keep
//! in memory. The module does not interpret the records.

mod merge;
mod run;
mod scratch;
mod sorter;

pub use merge::Sorted;
pub use scratch::{SystemTemp, TempFiles};
pub use sorter::Sorter;

use std::io;
use std::path::Path;

use heliotile_core::error::Error;

/// Returns the error for a record that cannot be read back: the temporary file in `folder` is
/// damaged.
pub fn damaged(folder: &Path) -> Error {
    Error::io(folder, "read a temporary file in")(io::ErrorKind::InvalidData.into())
}

/// Reads a number that was pushed as eight bytes.
pub fn number_of(payload: &[u8], folder: &Path) -> heliotile_core::error::Result<u64> {
    payload.try_into().map(u64::from_le_bytes).map_err(|_| damaged(folder))
}
