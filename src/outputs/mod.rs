//! Outputs: one row model for all results, as CSV or Parquet.
//!
//! In: receivers, labels (conditions, hours or periods) and seven f32 values of each pair. Out: a table file, complete or not
//! there at all, or CSV on the standard output. Never: physics, other than means held for hours becoming energy sums.

mod csv;
pub mod layout;
mod parquet;
pub mod periods;
pub mod sink;
pub mod surfaces;
pub mod table;
