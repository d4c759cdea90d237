//! In: the bytes of a GeoParquet file (version 1.1; Overture's buildings are such files). Out: its
//! features.

use std::path::Path;

use geozero::GeozeroGeometry;
use geozero::wkb::Wkb;
use heliotile_core::error::{Error, Result};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, Row};
use serde_json::{Map, Value, json};

use super::feature::{Feature, TakeFeature};
use super::shapes::Shapes;
use super::system::FeatureSystem;
use crate::text::excerpt;

/// Deepest nesting of structures that is read: Overture has three.
const DEPTH: usize = 8;

pub(super) fn read(bytes: Vec<u8>, file: &Path, take: &mut TakeFeature) -> Result<FeatureSystem> {
    let wrong = |error: ParquetError| {
        let text = error.to_string();
        let what = format!("the file cannot be read as Parquet: {}", excerpt(text.as_bytes()));
        Error::input(file, None, what, "download or export the file again: it is damaged or cut off")
    };
    let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).map_err(wrong)?;
    let metadata = reader.metadata().file_metadata();
    let geo = metadata.key_value_metadata().into_iter().flatten().find(|entry| entry.key == "geo");
    let geo: Value = geo.and_then(|entry| serde_json::from_str(entry.value.as_deref()?).ok()).unwrap_or(Value::Null);
    let Some(column) = geo.get("primary_column").and_then(Value::as_str).map(str::to_owned) else {
        let what = "the file is Parquet, but not GeoParquet: its metadata have no key `geo` with a primary column";
        return Err(Error::input(file, None, what, "write it with geopandas (`to_parquet`), DuckDB or GDAL"));
    };
    let about = geo.get("columns").and_then(|columns| columns.get(&column)).unwrap_or(&Value::Null);
    let encoding = about.get("encoding").and_then(Value::as_str).unwrap_or("WKB");
    if encoding != "WKB" {
        let what = format!("its geometries are encoded as `{}`, not as WKB", excerpt(encoding.as_bytes()));
        return Err(Error::input(file, None, what, "write it with WKB, the usual encoding of GeoParquet"));
    }
    for row in reader.get_row_iter(None).map_err(wrong)? {
        let feature = feature(&row.map_err(wrong)?, &column).map_err(|error| {
            let what = format!("a geometry cannot be read: {}", excerpt(error.as_bytes()));
            Error::input(file, None, what, "export the file again, with polygons of straight sides")
        })?;
        take(feature)?;
    }
    Ok(match about.get("crs") {
        // Longitude and latitude are the default (GeoParquet 1.1.0, "crs").
        None => FeatureSystem::WGS84,
        Some(Value::Null) => FeatureSystem::default(),
        Some(crs) => {
            let [authority, code] = ["/id/authority", "/id/code"].map(|path| crs.pointer(path));
            let number = code.and_then(|code| code.as_u64().or_else(|| code.as_str()?.parse().ok()));
            match (authority.and_then(Value::as_str), number.and_then(|number| u32::try_from(number).ok())) {
                (Some("EPSG"), Some(epsg)) => FeatureSystem::of_epsg(epsg),
                (Some("OGC"), _) => FeatureSystem::WGS84,
                _ => FeatureSystem::default(),
            }
        }
    })
}

fn feature(row: &Row, column: &str) -> std::result::Result<Feature, String> {
    let mut feature = Feature::default();
    for (name, field) in row.get_column_iter() {
        match field {
            Field::Bytes(bytes) if name == column => {
                let mut shapes = Shapes::default();
                Wkb(bytes.data()).process_geom(&mut shapes).map_err(|error| error.to_string())?;
                shapes.fill(&mut feature);
            }
            // The box of the geometry says nothing new.
            _ if name == "bbox" => {}
            field => drop(feature.attributes.insert(name.clone(), value(field, DEPTH))),
        }
    }
    Ok(feature)
}

fn value(field: &Field, depth: usize) -> Value {
    match field {
        Field::Bool(truth) => json!(truth),
        Field::Byte(number) => json!(number),
        Field::Short(number) => json!(number),
        Field::Int(number) => json!(number),
        Field::Long(number) => json!(number),
        Field::UByte(number) => json!(number),
        Field::UShort(number) => json!(number),
        Field::UInt(number) => json!(number),
        Field::ULong(number) => json!(number),
        Field::Float16(number) => json!(f32::from(*number)),
        Field::Float(number) => json!(number),
        Field::Double(number) => json!(number),
        Field::Decimal(_) => field.to_string().parse::<f64>().map_or(Value::Null, |number| json!(number)),
        Field::Str(text) => json!(text),
        Field::Group(row) if depth > 0 => {
            let inner: Map<String, Value> =
                row.get_column_iter().map(|(name, field)| (name.clone(), value(field, depth - 1))).collect();
            Value::Object(inner)
        }
        _ => Value::Null,
    }
}
