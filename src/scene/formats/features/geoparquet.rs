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
use super::shapes::{Shapes, unreadable};
use super::system::FeatureSystem;
use crate::text::excerpt;
use heliotile_files::input::budget::WorkBudget;
use heliotile_place::epsg_numbers::{Axes, epsg_numbers_in};

/// Deepest nesting of structures that is read: Overture has three.
const DEPTH: usize = 8;

pub(super) fn read(bytes: Vec<u8>, file: &Path, take: &mut TakeFeature) -> Result<FeatureSystem> {
    let wrong = |error: ParquetError| {
        let text = error.to_string();
        if let Some((_, codec)) = text.split_once("Disabled feature at compile time: ") {
            let what = format!("its columns are packed with {}, which is not read", excerpt(codec.trim().as_bytes()));
            let hint = "pack them with zstd or snappy, as geopandas does: `frame.to_parquet(\"town.parquet\", compression=\"zstd\")`";
            return Error::input(file, None, what, hint);
        }
        let what = format!("the file cannot be read as Parquet: {}", excerpt(text.as_bytes()));
        Error::input(file, None, what, "download or export the file again: it is damaged or cut off")
    };
    let mut budget = WorkBudget::new(bytes.len() as u64);
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
        let feature = feature(&row.map_err(wrong)?, &column);
        feature.charge(&mut budget, file)?;
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
                _ => match crs.as_str() {
                    Some(text) => of_text(text),
                    None => of_projjson(crs),
                },
            }
        }
    })
}

/// Returns the system of a text: well-known text, `EPSG:25832`, `OGC:CRS84`.
fn of_text(text: &str) -> FeatureSystem {
    if text.trim_start().starts_with('{') {
        return serde_json::from_str(text).map_or_else(|_| FeatureSystem::default(), |crs| of_projjson(&crs));
    }
    match epsg_numbers_in(text).first().filter(|_| !text.contains('[')) {
        Some(epsg) => FeatureSystem::of_epsg(*epsg),
        None if text.to_uppercase().contains("CRS84") => FeatureSystem::WGS84,
        None => FeatureSystem::of_text(text),
    }
}

/// Returns the system of PROJJSON (PROJ, "PROJJSON", schema 0.7), by its identifier, else by its
/// projection, written as well-known text.
fn of_projjson(crs: &Value) -> FeatureSystem {
    let code = |of: &Value| {
        let is_epsg = of.pointer("/id/authority").and_then(Value::as_str) == Some("EPSG");
        of.pointer("/id/code").filter(|_| is_epsg).and_then(Value::as_u64).and_then(|code| u32::try_from(code).ok())
    };
    match crs.get("type").and_then(Value::as_str) {
        _ if code(crs).is_some() => code(crs).map(FeatureSystem::of_epsg).unwrap_or_default(),
        Some("CompoundCRS") => crs.pointer("/components/0").map(of_projjson).unwrap_or_default(),
        Some("BoundCRS") => crs.get("source_crs").map(of_projjson).unwrap_or_default(),
        Some("GeographicCRS" | "GeodeticCRS") => {
            FeatureSystem { axes: Some(Axes::Degrees), ..FeatureSystem::default() }
        }
        Some("ProjectedCRS") => {
            let found = FeatureSystem::of_text(&well_known(crs));
            let unit = crs.pointer("/coordinate_system/axis/0/unit");
            let unit_m = unit.and_then(|unit| unit.get("conversion_factor").and_then(Value::as_f64));
            FeatureSystem { axes: Some(Axes::Plane), unit_m: unit_m.or(found.unit_m), ..found }
        }
        _ => FeatureSystem::default(),
    }
}

/// Returns the projected system of PROJJSON as well-known text 1 (OGC 01-009).
fn well_known(crs: &Value) -> String {
    let name = |path: &str| {
        let text = crs.pointer(path).and_then(Value::as_str).unwrap_or_default();
        text.replace('"', "")
    };
    let number =
        |path: &str| crs.pointer(path).and_then(|value| value.as_f64().or_else(|| value.get("value")?.as_f64()));
    let ellipsoid = ["/base_crs/datum/ellipsoid", "/base_crs/datum_ensemble/ellipsoid"]
        .into_iter()
        .find(|path| crs.pointer(path).is_some())
        .unwrap_or("/base_crs/datum/ellipsoid");
    let semi_major = number(&format!("{ellipsoid}/semi_major_axis")).or_else(|| number(&format!("{ellipsoid}/radius")));
    let flattening = number(&format!("{ellipsoid}/inverse_flattening")).unwrap_or_default();
    let datum = ["/base_crs/datum/name", "/base_crs/datum_ensemble/name"].map(name).concat();
    let base = name("/base_crs/name");
    let unit_m = number("/coordinate_system/axis/0/unit/conversion_factor").unwrap_or(1.0);
    let parameters = crs.pointer("/conversion/parameters").and_then(Value::as_array);
    let parameters = parameters.into_iter().flatten().filter_map(|parameter| {
        let called = parameter.get("name")?.as_str()?.replace('"', "");
        Some(format!(",PARAMETER[\"{called}\",{}]", parameter.get("value")?.as_f64()?))
    });
    format!(
        "PROJCS[\"{}\",GEOGCS[\"{base}\",DATUM[\"{datum}\",SPHEROID[\"{}\",{},{flattening}]]],PROJECTION[\"{}\"]{},UNIT[\"unit\",{unit_m}]]",
        name("/name"),
        name(&format!("{ellipsoid}/name")),
        semi_major.unwrap_or_default(),
        name("/conversion/method/name"),
        parameters.collect::<String>(),
    )
}

fn feature(row: &Row, column: &str) -> Feature {
    let mut feature = Feature::default();
    for (name, field) in row.get_column_iter() {
        match field {
            Field::Bytes(bytes) if name == column => {
                let mut shapes = Shapes::default();
                match Wkb(bytes.data()).process_geom(&mut shapes) {
                    Ok(()) => shapes.fill(&mut feature),
                    Err(error) => feature.unreadable = Some(unreadable(&error)),
                }
            }
            // The box of the geometry says nothing new.
            _ if name == "bbox" => {}
            field => drop(feature.attributes.insert(name.clone(), value(field, DEPTH))),
        }
    }
    feature
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
        Field::MapInternal(map) if depth > 0 => {
            let entries = map.entries().iter().filter_map(|(name, inner)| match name {
                Field::Str(name) => Some((name.clone(), value(inner, depth - 1))),
                _ => None,
            });
            Value::Object(entries.collect())
        }
        _ => Value::Null,
    }
}
