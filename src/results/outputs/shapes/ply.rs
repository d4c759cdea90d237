//! Maps as a PLY file: triangles or points with a value and a colour at each corner, for MeshLab,
//! CloudCompare and Blender. In: rows. Out: one binary file, 64-bit coordinates of the scene.

use std::io::{self, Write};

use super::columns::MapColumns;
use super::rows::MapRows;
use crate::outputs::pictures::colours::ColourScale;
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use heliotile_core::error::{Error, Result};

/// Writes the file with the value of the colour column, in the colours of maps. Triangles share no
/// corner.
pub fn write(mut sink: Sink, rows: &mut MapRows, columns: &MapColumns, about: &Provenance) -> Result<u64> {
    let path = sink.path().to_owned();
    let failed = |error: io::Error| Error::io(&path, "write to")(error);
    let largest = rows.facts.largest.max(0.0);
    let (mut faces, mut points) = (0_u64, 0_u64);
    // The header states counts, so rows are read once to count, once for vertices and once for
    // faces.
    rows.each(|row| {
        for polygon in &row.polygons {
            match polygon.triangles().len() {
                0 => points += polygon.corners().count() as u64,
                count => faces += count as u64,
            }
        }
        Ok(())
    })?;
    let vertices = 3 * faces + points;
    if vertices > i32::MAX as u64 {
        let what = "the number of vertices of the map".into();
        return Err(Error::Limit { what, value: vertices, max: i32::MAX as u64 });
    }
    let name = columns.numbers.get(columns.colour).map_or("value", |(name, _)| name.as_str());
    let comments = about.ascii().into_iter().map(|(name, value)| format!("comment {name} {value}\n"));
    let comments: String = comments.collect();
    let lists = if faces > 0 {
        format!("element face {faces}\nproperty list uchar int vertex_indices\n")
    } else {
        String::new()
    };
    let least = match columns.scale {
        ColourScale::FromZero => "0".to_owned(),
        ColourScale::AroundZero => format!("-{largest:.1} (loss)"),
    };
    let head = format!(
        "ply\nformat binary_little_endian 1.0\ncomment heliotile: {name}, colours from {least} to {largest:.1}\n{comments}\
         element vertex {vertices}\nproperty double x\nproperty double y\nproperty double z\n\
         property float {name}\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n{lists}end_header\n"
    );
    sink.write_all(head.as_bytes()).map_err(failed)?;
    rows.each(|row| {
        let value = row.numbers.get(columns.colour).copied().unwrap_or(f32::NAN);
        let share = if largest > 0.0 { value / largest } else { 0.0 };
        let colour = columns.scale.on_surfaces(share);
        for polygon in &row.polygons {
            let corners: Vec<_> = polygon.corners().copied().collect();
            let triangles = polygon.triangles();
            let of_triangles = triangles.iter().flatten().filter_map(|corner| corners.get(*corner as usize));
            let of_points = corners.iter().filter(|_| triangles.is_empty());
            for corner in of_triangles.chain(of_points) {
                let metres = corner.to_array().into_iter().flat_map(f64::to_le_bytes);
                let vertex: Vec<u8> = metres.chain(value.to_le_bytes()).chain(colour).collect();
                sink.write_all(&vertex).map_err(failed)?;
            }
        }
        Ok(())
    })?;
    let mut first = 0_i32;
    rows.each(|row| {
        for polygon in &row.polygons {
            let triangles = polygon.triangles().len();
            for _ in 0..triangles {
                let corners = (first..first + 3).flat_map(i32::to_le_bytes);
                let face: Vec<u8> = [3].into_iter().chain(corners).collect();
                sink.write_all(&face).map_err(failed)?;
                first += 3;
            }
            first += if triangles == 0 { polygon.corners().count() as i32 } else { 0 };
        }
        Ok(())
    })?;
    sink.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outputs::periods::Every;
    use crate::outputs::shapes::row::tests::wall;
    use crate::outputs::shapes::row::{MapPolygon, MapRow};
    use crate::outputs::shapes::rows::RowSpool;
    use crate::outputs::tables::bin_labels::BinLabels;
    use crate::outputs::tables::layout::{BinKind, By, Layout};
    use glam::DVec3;
    use heliotile_core::replay::components::{Component, ComponentList};

    /// A wall with a window has 8 triangles, and a place without an extent is a point: 25 vertices
    /// of 31 bytes, 8 faces of 13; 5 comments are single lines.
    #[test]
    fn a_place_without_extent_is_a_point() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("map.ply");
        let (labels, by) = (BinLabels::words(vec!["total".into()]), By::Receiver);
        let layout = Layout::of_components(BinKind::Sums, by, &ComponentList::new(Component::Total));
        let columns = MapColumns::new(&layout, &labels, Some(Every::Total)).expect("columns");
        let mut spool = RowSpool::new(folder.path(), 1 << 20, &columns);
        for (number, polygon) in [(0.0, wall()), (1000.0, MapPolygon::point(DVec3::Z))] {
            let numbers = vec![number; columns.numbers.len()];
            let row = MapRow { texts: Vec::new(), numbers, polygons: vec![polygon] };
            spool.push(&row).expect("pushed");
        }
        let about = crate::outputs::provenance::tests::example();
        let mut rows = spool.finish().expect("rows");
        write(Sink::file(&path).expect("created"), &mut rows, &columns, &about).expect("written");
        let bytes = std::fs::read(&path).expect("read");
        let end = bytes.windows(11).position(|w| w == b"end_header\n").expect("a header") + 11;
        let header = String::from_utf8_lossy(&bytes[..end]);
        assert!(header.contains("element vertex 25\n") && header.contains("element face 8\n"), "{header}");
        assert!(header.contains("property float total_kwh_m2\n"), "{header}");
        assert!(header.contains("\ncomment heliotile.weather a<b>\\u{a}.epw\n"), "{header}");
        assert_eq!(header.matches("\ncomment ").count(), 5);
        assert_eq!(bytes.len() - end, 25 * 31 + 8 * 13);
    }
}
