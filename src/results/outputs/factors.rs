//! Factors over positions of the sun as a table. In: factors of receivers or groups, one after the
//! other. Out: a table of any format, a row for each sun.

use std::path::Path;

use super::provenance::Provenance;
use super::tables::batch::{Batch, Values};
use super::tables::column::{Column, Digits, Kind, TableColumns};
use super::tables::table::Table;
use crate::outputs::tables::writer::Places;
use heliotile_core::error::Result;
use heliotile_core::replay::factors::{FACTORS, SunGrid};

/// Number of rows that are in memory at a time, unless a single receiver or group has more.
const ROWS_AT_ONCE: usize = 1 << 16;

/// Table of factors being written.
pub struct FactorTable {
    table: Table,
    /// Names of the receivers or groups that are not yet written; `factors` are their factors,
    /// `[factor][place][sun]`.
    names: Vec<String>,
    factors: [Vec<Option<f64>>; FACTORS.len()],
}

impl FactorTable {
    /// Starts a table of `count` receivers or groups; `place` is the name of their column, such as
    /// `receiver` or `surface`.
    pub fn create(path: &Path, place: &str, grid: &SunGrid, count: u64, about: &Provenance) -> Result<Self> {
        let (azimuths, altitudes) = grid.suns().unzip();
        let mut columns = vec![
            Column::of_places(place, Kind::Text),
            Column::numbers_of_bins("sun_azimuth_deg", azimuths),
            Column::numbers_of_bins("sun_altitude_deg", altitudes),
        ];
        columns.extend(FACTORS.map(|name| Column::float(name, Digits::Decimals(6)).with_unit("1")));
        let table = Table::create(path, TableColumns::new(columns), Places::counted(count), Some(about))?;
        Ok(FactorTable { table, names: Vec::new(), factors: Default::default() })
    }

    /// Appends the factors of a receiver or group: one row for each sun.
    pub fn write(&mut self, name: &str, factors: impl Iterator<Item = [f64; FACTORS.len()]>) -> Result<()> {
        self.names.push(name.to_owned());
        for row in factors {
            self.factors.iter_mut().zip(row).for_each(|(column, factor)| column.push(Some(factor)));
        }
        if self.factors[0].len() < ROWS_AT_ONCE { Ok(()) } else { self.flush() }
    }

    /// Returns true if the reader of the output has gone away.
    pub fn is_closed(&self) -> bool {
        self.table.is_closed()
    }

    /// Completes the table; its file appears only now.
    pub fn finish(mut self) -> Result<u64> {
        self.flush()?;
        Ok(self.table.finish()?.bytes)
    }

    fn flush(&mut self) -> Result<()> {
        let (names, factors) = (std::mem::take(&mut self.names), std::mem::take(&mut self.factors));
        let places = names.len();
        let values = std::iter::once(Values::Texts(names.into())).chain(factors.map(Values::Numbers));
        self.table.write(&Batch { places, values: values.collect() })
    }
}
