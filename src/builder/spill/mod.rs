//! Sorting more than memory holds. In: byte records in any order. Out: the same records by key, read one after the other,
//! as often as wanted.
//!
//! Runs that do not fit the budget go to unnamed temporary files, which the system removes when the program ends, however
//! it ends. It knows nothing of what the records mean.

mod merge;
mod run;
mod sorter;

pub use merge::Sorted;
pub use sorter::Sorter;
