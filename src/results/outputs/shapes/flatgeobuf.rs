//! Maps as FlatGeobuf with its spatial index, which QGIS opens quickly. In: rows. Out: one file,
//! rows in the order of the index.

use std::path::Path;

use ::flatgeobuf::{ColumnType, FgbCrs, FgbWriter, FgbWriterOptions, GeometryType};
use geozero::error::Result as GeozeroResult;
use geozero::{ColumnValue, GeomProcessor, GeozeroGeometry, PropertyProcessor};

use super::columns::MapColumns;
use super::crs::MapCrs;
use super::row::MapRow;
use super::rows::MapRows;
use super::stated::TextKind;
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use heliotile_core::error::{Error, Result};

/// Polygons of a row, as a geometry that the library reads.
struct Shape<'a> {
    row: &'a MapRow,
    crs: &'a MapCrs,
    /// True if rows are multipolygons: all are if one row has more than one polygon.
    multi: bool,
}

impl GeozeroGeometry for Shape<'_> {
    fn process_geom<P: GeomProcessor>(&self, to: &mut P) -> GeozeroResult<()> {
        if self.multi {
            to.multipolygon_begin(self.row.polygons.len(), 0)?;
        }
        for (i, polygon) in self.row.polygons.iter().enumerate() {
            to.polygon_begin(!self.multi, polygon.rings.len(), i)?;
            for (k, ring) in polygon.rings.iter().enumerate() {
                to.linestring_begin(false, ring.len() + 1, k)?;
                for (corner, point) in ring.iter().chain(ring.first()).enumerate() {
                    let [x, y, z] = self.crs.coordinates(*point);
                    to.coordinate(x, y, Some(z), None, None, None, corner)?;
                }
                to.linestring_end(false, k)?;
            }
            to.polygon_end(!self.multi, i)?;
        }
        if self.multi {
            to.multipolygon_end(0)?;
        }
        Ok(())
    }
}

/// Writes the file. Memory holds some 60 bytes a row, for the index.
pub fn write(sink: Sink, rows: &mut MapRows, columns: &MapColumns, crs: &MapCrs, about: &Provenance) -> Result<u64> {
    let path = sink.path().to_owned();
    let multi = rows.facts.polygons > rows.facts.rows;
    let kind = if multi { GeometryType::MultiPolygon } else { GeometryType::Polygon };
    let metadata = about.json().to_string();
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let org = crs.epsg().map(|_| "EPSG");
    let options = FgbWriterOptions {
        detect_type: false,
        promote_to_multi: false,
        has_z: true,
        crs: FgbCrs {
            org,
            code: crs.epsg().and_then(|epsg| i32::try_from(epsg).ok()).unwrap_or(0),
            ..FgbCrs::default()
        },
        description: Some("irradiation by heliotile"),
        metadata: Some(&metadata),
        ..FgbWriterOptions::default()
    };
    let mut writer = FgbWriter::create_with_options(&name, kind, options).map_err(|error| failed(&path, error))?;
    for (name, kind) in columns.texts.iter().zip(&columns.kinds) {
        let kind = match kind {
            TextKind::Text => ColumnType::String,
            TextKind::Whole => ColumnType::Long,
            TextKind::Number => ColumnType::Double,
            TextKind::Truth => ColumnType::Bool,
        };
        writer.add_column(name, kind, |_, _| {});
    }
    for (name, unit) in &columns.numbers {
        writer.add_column(name, ColumnType::Float, |builder, column| {
            column.description = Some(builder.create_string(unit))
        });
    }
    let names: Vec<&str> =
        columns.texts.iter().map(String::as_str).chain(columns.numbers.iter().map(|(name, _)| name.as_str())).collect();
    rows.each(|row| {
        let mut properties = Ok(());
        let texts = row.texts.iter().zip(&columns.kinds).map(|(text, kind)| match kind {
            TextKind::Text => (!text.is_empty()).then_some(ColumnValue::String(text)),
            TextKind::Whole => text.parse().ok().map(ColumnValue::Long),
            TextKind::Number => text.parse().ok().map(ColumnValue::Double),
            TextKind::Truth => text.parse().ok().map(ColumnValue::Bool),
        });
        let numbers = row.numbers.iter().map(|number| number.is_finite().then_some(ColumnValue::Float(*number)));
        let added = writer.add_feature_geom(Shape { row, crs, multi }, |feature| {
            for (i, (value, name)) in texts.chain(numbers).zip(&names).enumerate() {
                if let (Some(value), true) = (value, properties.is_ok()) {
                    properties = feature.property(i, name, &value).map(drop);
                }
            }
        });
        added.and(properties).map_err(|error| failed(&path, error))
    })?;
    let mut sink = sink;
    writer.write(&mut sink).map_err(|error| failed(&path, error))?;
    sink.finish()
}

fn failed(path: &Path, error: impl std::error::Error + Send + Sync + 'static) -> Error {
    Error::io(path, "write to")(std::io::Error::other(error))
}
