//! Outputs: one row model for all results, as CSV, Parquet, Arrow or arrays of NumPy.
//!
//! In: receivers, labels (conditions, hours or periods) and seven f32 values of each pair. Out: a table file, complete or not
//! there at all, or CSV on the standard output. Never: physics, other than means held for hours becoming energy sums.

mod arrow;
mod csv;
#[cfg(test)]
mod format_tests;
pub mod layout;
mod npy;
mod npz;
mod parquet;
pub mod periods;
pub mod sink;
pub mod surfaces;
pub mod table;
