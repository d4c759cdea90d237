//! Maps as GeoJSON (RFC 7946): longitude and latitude on WGS 84, for small maps in browsers. In:
//! rows. Out: one file, a row a line.

use std::io::{self, Write};

use serde_json::{Map, Value, json};

use super::columns::MapColumns;
use super::crs::MapCrs;
use super::row::{MapPolygon, MapRow};
use super::rows::MapRows;
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use heliotile_core::error::{Error, Result};

/// Steps of a degree to which coordinates are rounded: a millimetre is about 1e-8 degrees.
const DEGREES: f64 = 1e9;

/// Steps of a metre to which heights are rounded.
const HEIGHTS: f64 = 1e3;

/// Writes the file; fails if a point has no latitude.
pub fn write(
    mut sink: Sink,
    rows: &mut MapRows,
    columns: &MapColumns,
    crs: &MapCrs,
    about: &Provenance,
) -> Result<u64> {
    let path = sink.path().to_owned();
    let failed = || Error::io(&path, "write to");
    let head = format!("{{\"type\":\"FeatureCollection\",\"heliotile\":{},\"features\":[", about.json());
    sink.write_all(head.as_bytes()).map_err(failed())?;
    let mut between = "\n";
    rows.each(|row| {
        let feature = feature(row, columns, crs).ok_or_else(|| {
            let outside = io::Error::other("a point lies outside of what its coordinate system maps");
            failed()(outside)
        })?;
        let line = format!("{between}{feature}");
        between = ",\n";
        sink.write_all(line.as_bytes()).map_err(failed())
    })?;
    sink.write_all(b"\n]}\n").map_err(failed())?;
    sink.finish()
}

fn feature(row: &MapRow, columns: &MapColumns, crs: &MapCrs) -> Option<Value> {
    let texts = columns.texts.iter().zip(&columns.kinds).zip(&row.texts);
    let texts = texts.map(|((name, kind), text)| (name.clone(), kind.json(text)));
    let numbers = columns.numbers.iter().zip(&row.numbers);
    // Numbers have as few digits as a 32-bit float needs; NaN and infinity become null.
    let short = |number: &f32| number.to_string().parse::<f64>().map_or(Value::Null, |number| json!(number));
    let numbers = numbers.map(|((name, _), number)| (name.clone(), short(number)));
    let properties: Map<String, Value> = texts.chain(numbers).collect();
    let mut polygons: Vec<Value> = row.polygons.iter().map(|polygon| rings(polygon, crs)).collect::<Option<_>>()?;
    let geometry = match polygons.len() {
        1 => json!({"type": "Polygon", "coordinates": polygons.remove(0)}),
        _ => json!({"type": "MultiPolygon", "coordinates": polygons}),
    };
    Some(json!({"type": "Feature", "properties": properties, "geometry": geometry}))
}

/// Returns the closed rings of a polygon.
fn rings(polygon: &MapPolygon, crs: &MapCrs) -> Option<Value> {
    let rounded = |value: f64, steps: f64| (value * steps).round() / steps;
    let point = |corner: &glam::DVec3| {
        let [longitude, latitude, height] = crs.degrees(*corner)?;
        Some(json!([rounded(longitude, DEGREES), rounded(latitude, DEGREES), rounded(height, HEIGHTS)]))
    };
    let ring = |ring: &Vec<glam::DVec3>| ring.iter().chain(ring.first()).map(point).collect::<Option<Vec<Value>>>();
    polygon.rings.iter().map(ring).collect::<Option<Vec<_>>>().map(|rings| json!(rings))
}
