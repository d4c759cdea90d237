//! View factors of receivers as a table: what each one's hemisphere is filled with. In: the shares that the build stored. Out: a table of any
//! format.

use std::path::Path;

use super::provenance::Provenance;
use super::tables::column::Column;
use super::tables::rows::{Cell, RowWriter};
use heliotile_core::error::Result;

/// The columns of shares, which sum to 1.
const SHARES: [&str; 4] = ["sky_view", "ground_view", "obstruction_view", "nothing_view"];

/// Decimals of the shares in CSV.
const DECIMALS: usize = 7;

/// A table being written.
pub struct ViewFactorTable {
    table: RowWriter,
}

impl ViewFactorTable {
    /// Starts a table of so many receivers.
    pub fn create(path: &Path, count: u64, about: &Provenance) -> Result<Self> {
        let shares = SHARES.map(|name| Column::number(name, DECIMALS));
        let columns = std::iter::once(Column::text("receiver")).chain(shares).collect();
        Ok(ViewFactorTable { table: RowWriter::create(path, columns, count, Some(about))? })
    }

    /// One row; `views`: cosine-weighted shares of sky, ground and obstructions. What is left meets nothing: below the horizon
    /// where the scene ends.
    pub fn row(&mut self, receiver: &str, views: [f32; 3]) -> Result<()> {
        let [sky, ground, obstruction] = views.map(f64::from);
        let nothing = (1.0 - sky - ground - obstruction).max(0.0);
        let shares = [sky, ground, obstruction, nothing].map(Cell::from);
        self.table.row(std::iter::once(receiver.into()).chain(shares))
    }

    /// Whether the reader of the output has gone away.
    pub fn is_closed(&self) -> bool {
        self.table.is_closed()
    }

    /// Completes the table; only now does its file appear, and before it the one that says what it holds.
    pub fn finish(self) -> Result<u64> {
        self.table.finish()
    }
}
