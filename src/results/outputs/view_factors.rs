//! View factors of receivers as a table: the shares of each hemisphere by what is seen, and the
//! vertical sky component. In: the shares that the build stored, sky components. Out: a table of
//! any format.

use std::path::Path;

use super::provenance::Provenance;
use super::tables::column::Column;
use super::tables::table::Table;
use crate::outputs::tables::table::Cell;
use heliotile_core::error::Result;

/// Columns of shares, which sum to 1.
const SHARES: [&str; 4] = ["sky_view", "ground_view", "obstruction_view", "nothing_view"];

/// Columns of the direct light of the CIE traditional overcast sky, percent of that on open ground,
/// and of the flag that no sky is seen.
const SKY: [&str; 2] = ["vsc_percent", "no_sky"];

/// Decimals of percent in CSV.
const PERCENT_DECIMALS: usize = 3;

/// Decimals of the shares in CSV.
const DECIMALS: usize = 7;

/// Table of view factors being written.
pub struct ViewFactorTable {
    table: Table,
}

impl ViewFactorTable {
    /// Starts a table of `count` receivers.
    pub fn create(path: &Path, count: u64, about: &Provenance) -> Result<Self> {
        let shares = SHARES.map(|name| Column::number(name, DECIMALS));
        let sky = [Column::number(SKY[0], PERCENT_DECIMALS), Column::count(SKY[1])];
        let columns = std::iter::once(Column::text("receiver")).chain(shares).chain(sky).collect();
        Ok(ViewFactorTable { table: Table::of_rows(path, columns, count, Some(about))? })
    }

    /// Appends a row. `views` are the cosine-weighted shares of sky, ground and obstructions; the
    /// remaining share meets nothing, below the horizon beyond the edge of the scene. `vsc_percent`
    /// is the direct light of the CIE traditional overcast sky, percent of that on open ground.
    pub fn row(&mut self, receiver: &str, views: [f32; 3], vsc_percent: f64) -> Result<()> {
        let [sky, ground, obstruction] = views.map(f64::from);
        let nothing = (1.0 - sky - ground - obstruction).max(0.0);
        let shares = [sky, ground, obstruction, nothing].map(Cell::from);
        let no_sky = Cell::Count(u64::from(views[0] == 0.0));
        self.table.row(std::iter::once(receiver.into()).chain(shares).chain([vsc_percent.into(), no_sky]))
    }

    /// Returns true if the reader of the output has gone away.
    pub fn is_closed(&self) -> bool {
        self.table.is_closed()
    }

    /// Completes the table; its file appears only now, after its metadata file.
    pub fn finish(self) -> Result<u64> {
        Ok(self.table.finish()?.bytes)
    }
}
