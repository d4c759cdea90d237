//! View factors of receivers as a table: the shares of each hemisphere by what is seen, the
//! vertical sky component, and gaps among leaves. In: the shares that the build stored, sky
//! components, gap fractions. Out: a table of any format.

use std::path::Path;

use super::provenance::Provenance;
use super::tables::column::Column;
use super::tables::table::Table;
use crate::gap_fractions::{Gaps, RINGS};
use crate::outputs::tables::table::Cell;
use heliotile_core::error::Result;

/// Columns of shares, which sum to 1.
const SHARES: [&str; 5] = ["sky_view", "leaves_view", "ground_view", "obstruction_view", "nothing_view"];

/// Columns of the direct light of the CIE traditional overcast sky, percent of that on open ground,
/// and of the flag that no sky is seen.
const SKY: [&str; 2] = ["vsc_percent", "no_sky"];

/// Columns of the gaps above a receiver that faces the zenith: shares of the sky by rings of zenith
/// angles, through leaves, and the leaf area index that follows.
const GAPS: [&str; RINGS] =
    ["gap_7_deg_percent", "gap_23_deg_percent", "gap_38_deg_percent", "gap_53_deg_percent", "gap_68_deg_percent"];
const LEAVES: &str = "leaf_area_index";

/// Decimals of percent in CSV.
const PERCENT_DECIMALS: usize = 3;

/// Decimals of the shares in CSV.
const DECIMALS: usize = 7;

/// Largest difference between a view of the sky that was counted and one that was replayed which is
/// rounding, and not leaves.
const ROUNDING: f64 = 1e-5;

/// View factors of a receiver.
pub struct ViewFactors {
    /// Cosine-weighted shares of sky, ground and obstructions, where leaves are no obstructions;
    /// the remaining share meets nothing, below the horizon beyond the edge of the scene.
    pub views: [f32; 3],
    /// Share of the sky as it is seen through leaves; `None` without leaves.
    pub through_leaves: Option<f64>,
    /// Direct light of the CIE traditional overcast sky, percent of that on open ground.
    pub vsc_percent: f64,
    /// Gaps among leaves; `None` for a receiver that does not face the zenith.
    pub gaps: Option<Gaps>,
}

/// Table of view factors being written.
pub struct ViewFactorTable {
    table: Table,
}

impl ViewFactorTable {
    /// Starts a table of `count` receivers.
    pub fn create(path: &Path, count: u64, about: &Provenance) -> Result<Self> {
        let shares = SHARES.map(|name| Column::number(name, DECIMALS));
        let sky = [Column::number(SKY[0], PERCENT_DECIMALS), Column::count(SKY[1])];
        let gaps = GAPS.map(|name| Column::number(name, PERCENT_DECIMALS)).into_iter();
        let gaps = gaps.chain([Column::number(LEAVES, PERCENT_DECIMALS)]);
        let columns = std::iter::once(Column::text("receiver")).chain(shares).chain(sky).chain(gaps).collect();
        Ok(ViewFactorTable { table: Table::of_rows(path, columns, count, Some(about))? })
    }

    /// Appends a row. Cells of gaps are empty where a receiver does not face the zenith.
    pub fn row(&mut self, receiver: &str, of: &ViewFactors) -> Result<()> {
        let &ViewFactors { views, through_leaves, vsc_percent, gaps } = of;
        let [sky, ground, obstruction] = views.map(f64::from);
        let nothing = (1.0 - sky - ground - obstruction).max(0.0);
        let hidden = through_leaves.map(|seen| sky - seen).filter(|hidden| *hidden > ROUNDING);
        let leaves = hidden.unwrap_or(0.0).min(sky);
        let shares = [sky - leaves, leaves, ground, obstruction, nothing].map(Cell::from);
        let no_sky = Cell::Count(u64::from(views[0] == 0.0));
        let of_ring = |ring: usize| Cell::Number(gaps.map(|gaps| 100.0 * gaps.shares[ring]));
        let index = Cell::Number(gaps.and_then(|gaps| gaps.leaf_area_index));
        let gaps = (0..RINGS).map(of_ring).chain([index]);
        self.table.row(std::iter::once(receiver.into()).chain(shares).chain([vsc_percent.into(), no_sky]).chain(gaps))
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
