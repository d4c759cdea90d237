//! Sorting more than memory holds. In: byte records in any order. Out: the same records by key, read one after the other,
//! as often as wanted.
//!
//! Runs that do not fit the budget go to unnamed temporary files, which the system removes when the program ends, however
//! it ends; the same for what replay cannot keep in memory. It knows nothing of what the records mean.

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

/// A record that is not what was pushed: the temporary file in `folder` that held it is damaged.
pub fn damaged(folder: &Path) -> Error {
    Error::io(folder, "read a temporary file in")(io::ErrorKind::InvalidData.into())
}

/// A number that was pushed as eight bytes.
pub fn number_of(payload: &[u8], folder: &Path) -> heliotile_core::error::Result<u64> {
    payload.try_into().map(u64::from_le_bytes).map_err(|_| damaged(folder))
}
