//! Receivers as the table that builds read. In: points on surfaces. Out: `receiver,x,y,z,nx,ny,nz,area,surface`, what they stand for in
//! their model, their patch and, for those that are left out, a reason.

use std::io;

use ::csv::Writer;
use glam::DVec3;

use super::sink::Sink;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::site::patch::Patch;
use heliotile_scene::covering::receivers::PATCH;

/// One row.
pub struct ReceiverRow<'a> {
    pub name: &'a str,
    /// Input coordinates, metres, written to 0.1 mm.
    pub position: DVec3,
    pub normal: DVec3,
    pub area_m2: f64,
    pub surface: &'a str,
    pub part: ModelPart,
    /// The part of the surface that it stands for.
    pub patch: Patch,
    /// Why it gets no light.
    pub reason: Option<&'a str>,
}

/// A table that is being written.
pub struct ReceiverTable {
    csv: Writer<Sink>,
    with_reason: bool,
}

impl ReceiverTable {
    pub fn create(sink: Sink, with_reason: bool) -> Result<Self> {
        let mut table = ReceiverTable { csv: Writer::from_writer(sink), with_reason };
        let header = ["receiver", "x", "y", "z", "nx", "ny", "nz", "area", "surface"];
        table.record(
            header.into_iter().chain(ModelPart::COLUMNS).chain([PATCH]).chain(with_reason.then_some("reason")),
        )?;
        Ok(table)
    }

    pub fn write(&mut self, row: &ReceiverRow) -> Result<()> {
        let (p, n) = (row.position, row.normal);
        // + 0.0 turns -0.0 into 0.0.
        let numbers = [p.x, p.y, p.z].map(|metres| format!("{:.4}", (metres * 1e4).round() / 1e4 + 0.0));
        let normal = [n.x, n.y, n.z].map(|share| format!("{:.6}", (share * 1e6).round() / 1e6 + 0.0));
        let area = format!("{:.4}", row.area_m2.max(1e-4));
        let cells = [row.name].into_iter().chain(numbers.iter().map(String::as_str));
        let cells =
            cells.chain(normal.iter().map(String::as_str)).chain([area.as_str(), row.surface]).chain(row.part.texts());
        let patch = row.patch.to_string();
        self.record(cells.chain([patch.as_str()]).chain(row.reason.filter(|_| self.with_reason)))
    }

    pub fn finish(self) -> Result<()> {
        let path = self.csv.get_ref().path().to_owned();
        let sink = self.csv.into_inner().map_err(|error| Error::io(&path, "write to")(error.into_error()))?;
        sink.finish().map(|_| ())
    }

    fn record<C: AsRef<[u8]>>(&mut self, cells: impl Iterator<Item = C>) -> Result<()> {
        let path = self.csv.get_ref().path().to_owned();
        self.csv.write_record(cells).map_err(|error| Error::io(&path, "write to")(io::Error::from(error)))
    }
}
