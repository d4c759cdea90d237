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
pub use scratch::TempFiles;
pub use sorter::Sorter;
