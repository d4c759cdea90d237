//! Tables of results, one row model for all formats: CSV, Parquet, Arrow, arrays of NumPy.

mod arrow;
mod csv;
#[cfg(test)]
mod format_tests;
pub mod layout;
mod npy;
mod npz;
mod parquet;
pub mod table;
pub mod writer;

pub use csv::quoted;
