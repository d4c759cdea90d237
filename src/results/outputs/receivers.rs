//! Table of receivers that builds read. In: points on surfaces. Out:
//! `receiver,x,y,z,nx,ny,nz,area_m2,surface`, the part of the model that they stand for, their
//! patch and, for those that are left out, a reason.

use std::path::Path;

use glam::DVec3;

use super::tables::column::Column;
use super::tables::table::Table;
use crate::outputs::tables::table::Cell;
use heliotile_core::error::Result;
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::site::patch::{PATCH, Patch};

/// Row of the table.
pub struct ReceiverRow<'a> {
    pub name: &'a str,
    /// Position in input coordinates, metres, written to 0.1 mm.
    pub position: DVec3,
    pub normal: DVec3,
    /// Area in m2; `None` for a point.
    pub area_m2: Option<f64>,
    pub surface: &'a str,
    pub part: ModelPart,
    /// Part of the surface that the receiver stands for.
    pub patch: Patch,
    /// Reason why the receiver gets no light.
    pub reason: Option<&'a str>,
}

/// Decimals of positions and areas; `NORMAL_DECIMALS` are those of normals.
const DECIMALS: usize = 4;
const NORMAL_DECIMALS: usize = 6;

/// Returns the columns `receiver,x,y,z,nx,ny,nz,area_m2,surface` and those of the part of the
/// model.
pub fn columns_of_receivers() -> Vec<Column> {
    let mut columns = vec![Column::text("receiver")];
    columns.extend(["x", "y", "z"].map(|name| Column::number(name, DECIMALS)));
    columns.extend(["nx", "ny", "nz"].map(|name| Column::number(name, NORMAL_DECIMALS)));
    columns.extend([Column::number("area_m2", DECIMALS), Column::text("surface")]);
    columns.extend(ModelPart::COLUMNS.map(Column::text));
    columns
}

/// Table of receivers being written.
pub struct ReceiverTable {
    table: Table,
    with_reason: bool,
}

impl ReceiverTable {
    /// Starts a table; `-` is the standard output. No metadata file is written beside it: the table
    /// is an input without provenance.
    pub fn create(path: &Path, with_reason: bool) -> Result<Self> {
        let mut columns = columns_of_receivers();
        columns.push(Column::text(PATCH));
        columns.extend(with_reason.then(|| Column::text("reason")));
        // The table is CSV, the only format that is read back, and CSV needs no row count.
        Ok(ReceiverTable { table: Table::of_rows(path, columns, 0, None)?, with_reason })
    }

    /// Appends a receiver.
    pub fn write(&mut self, row: &ReceiverRow) -> Result<()> {
        let mut cells = vec![Cell::from(row.name)];
        cells.extend(row.position.to_array().map(|metres| Cell::from(rounded(metres, 1e4))));
        cells.extend(row.normal.to_array().map(|share| Cell::from(rounded(share, 1e6))));
        cells.extend([Cell::from(row.area_m2.map(|area| area.max(1e-4))), row.surface.into()]);
        cells.extend(row.part.texts().map(Cell::from));
        cells.push(Cell::Text(row.patch.to_string()));
        cells.extend(row.reason.filter(|_| self.with_reason).map(Cell::from));
        self.table.row(cells)
    }

    /// Completes the table; its file appears only now.
    pub fn finish(self) -> Result<()> {
        self.table.finish().map(drop)
    }
}

/// Returns `number` rounded to a multiple of 1 / `parts`, never -0.
fn rounded(number: f64, parts: f64) -> f64 {
    (number * parts).round() / parts + 0.0
}
