//! The one row model of all results: a label, a receiver, components.
//!
//! In: tiles of values, `[column][receiver][label]`, f32. Out: rows, receiver-major inside a tile (all labels of receiver
//! 0, then of receiver 1).

use crate::outputs::tables::tile_columns::TileColumns;
use heliotile_core::error::Result;

/// Receivers or surfaces that rows will come for.
pub struct Places<'a> {
    pub count: u64,
    /// Their names in order; only some formats ask.
    pub names: &'a dyn Fn() -> Result<Vec<String>>,
}

/// What each format does.
pub trait Table {
    /// Appends the rows of a tile of the right shape, which is not empty.
    fn write_tile(&mut self, receivers: &[String], values: &TileColumns) -> Result<()>;

    /// Whether nobody reads any more.
    fn is_closed(&self) -> bool {
        false
    }

    /// Completes the table and gives its size in bytes.
    fn finish(self: Box<Self>) -> Result<u64>;
}
