//! Tables of results, one row model for all formats: CSV, Parquet, Arrow, arrays of NumPy.

pub mod arrow;
mod csv;
pub mod csvw;
#[cfg(test)]
mod format_tests;
pub mod layout;
mod npy;
mod npz;
mod parquet;
pub mod records;
pub mod row_labels;
pub mod table;
pub mod tile_columns;
pub mod writer;
mod zone_name;

pub use csv::quoted;
pub use npy::header as npy_header;
