//! Receivers as the table that builds read. In: points on surfaces. Out: `receiver,x,y,z,nx,ny,nz,area,surface`, what they stand for in
//! their model, their patch and, for those that are left out, a reason.

use std::path::Path;

use glam::DVec3;

use super::tables::column::Column;
use super::tables::rows::{Cell, RowWriter};
use heliotile_core::error::Result;
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::site::patch::Patch;
use heliotile_scene::covering::receivers::PATCH;

/// One row.
pub struct ReceiverRow<'a> {
    pub name: &'a str,
    /// Input coordinates, metres, written to 0.1 mm.
    pub position: DVec3,
    pub normal: DVec3,
    /// None of a point.
    pub area_m2: Option<f64>,
    pub surface: &'a str,
    pub part: ModelPart,
    /// The part of the surface that it stands for.
    pub patch: Patch,
    /// Why it gets no light.
    pub reason: Option<&'a str>,
}

/// Decimals of places and areas, and of normals.
const DECIMALS: usize = 4;
const NORMAL_DECIMALS: usize = 6;

/// `receiver,x,y,z,nx,ny,nz,area,surface` and what a receiver stands for in its model.
pub fn columns_of_receivers() -> Vec<Column> {
    let mut columns = vec![Column::text("receiver")];
    columns.extend(["x", "y", "z"].map(|name| Column::number(name, DECIMALS)));
    columns.extend(["nx", "ny", "nz"].map(|name| Column::number(name, NORMAL_DECIMALS)));
    columns.extend([Column::number("area", DECIMALS), Column::text("surface")]);
    columns.extend(ModelPart::COLUMNS.map(Column::text));
    columns
}

/// A table that is being written.
pub struct ReceiverTable {
    table: RowWriter,
    with_reason: bool,
}

impl ReceiverTable {
    /// Starts a table; `-` is the standard output. Nothing stands beside it: it is an input, which has no provenance.
    pub fn create(path: &Path, with_reason: bool) -> Result<Self> {
        let mut columns = columns_of_receivers();
        columns.push(Column::text(PATCH));
        columns.extend(with_reason.then(|| Column::text("reason")));
        // CSV, which is all that is read again, does not ask how many there are.
        Ok(ReceiverTable { table: RowWriter::create(path, columns, 0, None)?, with_reason })
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

    /// Completes the table; only now does its file appear.
    pub fn finish(self) -> Result<()> {
        self.table.finish().map(drop)
    }
}

/// A number rounded to parts of one, never -0.
fn rounded(number: f64, parts: f64) -> f64 {
    (number * parts).round() / parts + 0.0
}
