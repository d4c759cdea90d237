//! Sums over a whole weather file, a row for each receiver. In: receivers, their sums in kWh/m2.
//! Out: a table with the positions of the receivers.

use std::path::Path;

use super::provenance::Provenance;
use super::receivers::columns_of_receivers;
use super::tables::column::Column;
use super::tables::table::Table;
use crate::outputs::tables::table::Cell;
use heliotile_core::error::Result;
use heliotile_core::replay::components::{Component, SUM_SUFFIX};
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::units::tilt_and_azimuth;

/// Receiver with its sums over a weather file.
#[derive(Clone, Debug)]
pub struct AnnualRow {
    /// Receiver of the row.
    pub receiver: Receiver,
    /// Sums by component, kWh/m2: the six components and their total.
    pub kwh_m2: [f32; 7],
}

/// Table of sums being written.
pub struct AnnualTable {
    table: Table,
    north: North,
}

impl AnnualTable {
    /// Starts a table of `count` rows, and a file beside it that describes its columns. Columns:
    /// `receiver,x,y,z,nx,ny,nz,area_m2,surface`, the part of the model that the receiver stands
    /// for, its tilt and azimuth (from true north), and the sums.
    pub fn create(path: &Path, count: u64, north: North, provenance: &Provenance) -> Result<Self> {
        let columns = columns_of_receivers()
            .into_iter()
            .chain(["tilt_deg", "azimuth_deg"].map(|name| Column::number(name, 2)))
            .chain(Component::ALL.map(|component| Column::number(format!("{}{SUM_SUFFIX}", component.name()), 3)));
        let table = Table::of_rows(path, columns.collect(), count, Some(provenance))?;
        Ok(AnnualTable { table, north })
    }

    /// Appends a row.
    pub fn write(&mut self, row: &AnnualRow) -> Result<()> {
        let Receiver { id, position: p, normal: n, area, surface, part, .. } = &row.receiver;
        let (tilt, azimuth) = tilt_and_azimuth(self.north.to_true(*n));
        let mut cells = vec![Cell::from(id)];
        cells.extend([p.x, p.y, p.z, n.x, n.y, n.z].map(Cell::from));
        cells.push((*area).into());
        cells.push(surface.as_deref().unwrap_or_default().into());
        cells.extend(part.texts().map(Cell::from));
        cells.extend([tilt, azimuth].map(Cell::from));
        cells.extend(row.kwh_m2.map(|sum| Cell::from(f64::from(sum))));
        self.table.row(cells)
    }

    /// Completes the table; its file appears only now.
    pub fn finish(self) -> Result<()> {
        self.table.finish().map(drop)
    }
}
