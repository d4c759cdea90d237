//! Tables, all of the program's: one model of columns and rows, one writer a format.
//!
//! In: columns ([`mod@column`]), then batches of their values ([`batch`]), or rows one by one
//! ([`table`]). Out: a file in the format of its name's ending ([`mod@format`]), complete or not
//! there at all, or CSV on standard output. Never: the meaning of values.
//!
//! A new format needs a file with a [`writer::FormatWriter`] and its lines in `format.rs`; every
//! table can then be written in it.

mod arrow;
pub mod batch;
pub mod bin_labels;
pub mod column;
mod csv;
pub mod csvw;
pub mod format;
#[cfg(test)]
mod format_tests;
pub mod layout;
mod npy;
mod npz;
mod numpy;
mod parquet;
pub mod records;
pub mod table;
pub mod writer;
mod zone_name;

pub use arrow::ArrowRows;
pub use csv::quoted;
pub use numpy::header as npy_header;
