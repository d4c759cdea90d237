//! Sums over a whole weather file as a map. In: receivers, their sums in kWh/m2, and the pieces of surface that they stand for. Out: a
//! table with places, and a PLY file whose faces have the sums as a property and as colours.

use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;

use super::pictures::colours::inferno;
use super::provenance::Provenance;
use super::receivers::columns_of_receivers;
use super::sink::Sink;
use super::tables::column::Column;
use super::tables::rows::{Cell, RowWriter};
use heliotile_core::error::{Error, Result};
use heliotile_core::replay::components::{Component, SUM_SUFFIX};
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::units::tilt_and_azimuth;

/// A receiver and its sums, kWh/m2: the six components and their total.
#[derive(Clone, Debug)]
pub struct AnnualRow {
    pub receiver: Receiver,
    pub kwh_m2: [f32; 7],
}

impl AnnualRow {
    pub fn total(&self) -> f32 {
        self.kwh_m2[Component::Total as usize]
    }
}

/// Writes `receiver,x,y,z,nx,ny,nz,area,surface`, what the receiver stands for, its tilt and azimuth (from true north), and the sums;
/// and beside them what they are.
pub fn write_table(path: &Path, rows: &[AnnualRow], north: North, provenance: &Provenance) -> Result<()> {
    let columns = columns_of_receivers()
        .into_iter()
        .chain(["tilt_deg", "azimuth_deg"].map(|name| Column::number(name, 2)))
        .chain(Component::ALL.map(|component| Column::number(format!("{}{SUM_SUFFIX}", component.name()), 3)));
    let mut table = RowWriter::create(path, columns.collect(), rows.len() as u64, Some(provenance))?;
    for row in rows {
        let Receiver { id, position: p, normal: n, area, surface, part, .. } = &row.receiver;
        let (tilt, azimuth) = tilt_and_azimuth(north.to_true(*n));
        let mut cells = vec![Cell::from(id)];
        cells.extend([p.x, p.y, p.z, n.x, n.y, n.z].map(Cell::from));
        cells.push((*area).into());
        cells.push(surface.as_deref().unwrap_or_default().into());
        cells.extend(part.texts().map(Cell::from));
        cells.extend([tilt, azimuth].map(Cell::from));
        cells.extend(row.kwh_m2.map(|sum| Cell::from(f64::from(sum))));
        table.row(cells)?;
    }
    table.finish().map(drop)
}

/// A piece of surface, or only its middle, and the light that falls on it.
pub struct Patch<'a> {
    /// Input coordinates, metres; empty for a point.
    pub triangles: &'a [[DVec3; 3]],
    pub middle: DVec3,
    pub total_kwh_m2: f32,
}

/// Writes a binary PLY file: vertices with `total_kwh_m2` and colours from 0 (dark) to the largest sum (bright), triangles or points.
pub fn write_ply(mut sink: Sink, patches: &[Patch], provenance: &Provenance) -> Result<()> {
    let path = sink.path().to_owned();
    let largest = patches.iter().map(|patch| patch.total_kwh_m2).fold(0.0, f32::max);
    let faces: usize = patches.iter().map(|patch| patch.triangles.len()).sum();
    let points = patches.iter().filter(|patch| patch.triangles.is_empty()).count();
    let vertices = 3 * faces as u64 + points as u64;
    if vertices > i32::MAX as u64 {
        return Err(Error::Limit {
            what: "the number of vertices of the map".into(),
            value: vertices,
            max: i32::MAX as u64,
        });
    }
    let about = provenance.ascii().into_iter().map(|(name, value)| format!("comment {name} {value}\n"));
    let about: String = about.collect();
    let mut write = || -> io::Result<()> {
        write!(
            sink,
            "ply\nformat binary_little_endian 1.0\ncomment heliotile: total_kwh_m2, colours from 0 to {largest:.1}\n{about}\
             element vertex {vertices}\nproperty double x\nproperty double y\nproperty double z\n\
             property float total_kwh_m2\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        )?;
        if faces > 0 {
            write!(sink, "element face {faces}\nproperty list uchar int vertex_indices\n")?;
        }
        writeln!(sink, "end_header")?;
        for patch in patches {
            let corners = patch.triangles.iter().flatten();
            let middle = patch.triangles.is_empty().then_some(&patch.middle);
            let share = if largest > 0.0 { patch.total_kwh_m2 / largest } else { 0.0 };
            for corner in corners.chain(middle) {
                for metres in corner.to_array() {
                    sink.write_all(&metres.to_le_bytes())?;
                }
                sink.write_all(&patch.total_kwh_m2.to_le_bytes())?;
                sink.write_all(&inferno(share))?;
            }
        }
        let mut first = 0_i32;
        for patch in patches {
            for _ in patch.triangles {
                sink.write_all(&[3])?;
                for corner in first..first + 3 {
                    sink.write_all(&corner.to_le_bytes())?;
                }
                first += 3;
            }
            first += i32::from(patch.triangles.is_empty());
        }
        Ok(())
    };
    write().map_err(Error::io(&path, "write to"))?;
    sink.finish().map(|_| ())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 2 patches, one of 2 triangles and one a point, the PLY file has 7 vertices of 31 bytes and 2 faces of 13, 5 comments are single
    /// lines.
    #[test]
    fn ply() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("map.ply");
        let square = [[DVec3::ZERO, DVec3::X, DVec3::Y], [DVec3::X, DVec3::ONE, DVec3::Y]];
        let patches = [
            Patch { triangles: &square, middle: DVec3::ZERO, total_kwh_m2: 0.0 },
            Patch { triangles: &[], middle: DVec3::Z, total_kwh_m2: 1000.0 },
        ];
        let about = crate::outputs::provenance::tests::example();
        write_ply(Sink::file(&path).expect("created"), &patches, &about).expect("written");
        let bytes = std::fs::read(&path).expect("read");
        let end = bytes.windows(11).position(|w| w == b"end_header\n").expect("a header") + 11;
        let header = String::from_utf8_lossy(&bytes[..end]);
        assert!(header.contains("element vertex 7\n") && header.contains("element face 2\n"), "{header}");
        assert!(header.contains("\ncomment heliotile.weather a<b>\\u{a}.epw\n"), "{header}");
        assert_eq!(header.matches("\ncomment ").count(), 5);
        assert_eq!(bytes.len() - end, 7 * 31 + 2 * 13);
    }
}
