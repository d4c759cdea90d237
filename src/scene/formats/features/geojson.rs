//! In: GeoJSON (RFC 7946, and older files with a `crs`): a collection, a feature, a geometry, or
//! features line by line. Out: features, one at a time.

use std::fmt;
use std::path::Path;

use glam::DVec3;
use heliotile_core::error::{Error, Result};
use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

use super::feature::{Feature, TakeFeature};
use super::system::FeatureSystem;
use crate::text::{excerpt, without_byte_order_mark};
use heliotile_place::epsg_numbers::epsg_numbers_in;

/// Deepest nesting of geometry collections that is read; only hostile files have more.
const DEPTH: usize = 8;

/// Bytes in which the type of a file is looked for.
const HEAD: usize = 1 << 16;

/// Returns true if JSON is GeoJSON and does not mention CityJSON, which services wrap into feature
/// collections.
pub(in crate::formats) fn is_geojson(bytes: &[u8]) -> bool {
    let head = String::from_utf8_lossy(bytes.get(..HEAD.min(bytes.len())).unwrap_or_default());
    let plain: String = head.chars().filter(|letter| !letter.is_whitespace()).collect();
    let is_collection =
        ["\"type\":\"FeatureCollection\"", "\"type\":\"Feature\""].iter().any(|text| plain.contains(text));
    is_collection && !plain.contains("CityJSON")
}

/// Reads the features; returns the coordinate system that the file states.
pub(super) fn read(bytes: &[u8], file: &Path, take: &mut TakeFeature) -> Result<FeatureSystem> {
    let bytes = without_byte_order_mark(bytes);
    if bytes.trim_ascii().is_empty() {
        return Err(Error::input(file, None, "the file is empty", "export the features again"));
    }
    let mut reading = Reading { take, failed: None, crs: None };
    // Features line by line may each begin with a record separator (RFC 8142).
    let separators = bytes.contains(&0x1e);
    let cleaned: Vec<u8>;
    let bytes = if separators {
        cleaned = bytes.iter().map(|byte| if *byte == 0x1e { b' ' } else { *byte }).collect();
        &cleaned
    } else {
        bytes
    };
    let mut start = 0;
    while let Some(rest) = bytes.get(start..).filter(|rest| !rest.trim_ascii().is_empty()) {
        let mut source = serde_json::Deserializer::from_slice(rest);
        let done = Top { reading: &mut reading }.deserialize(&mut source);
        if let Some(error) = reading.failed.take() {
            return Err(error);
        }
        done.map_err(|error| {
            let line = crate::text::line_of_offset(bytes, start) + error.line().saturating_sub(1);
            let text = error.to_string();
            let what = text.split(" at line ").next().unwrap_or_default();
            let hint = "export the file again: it is not valid GeoJSON or is cut off";
            Error::input(file, line, excerpt(what.as_bytes()), hint)
        })?;
        if source.end().is_ok() {
            break;
        }
        let mut values = serde_json::Deserializer::from_slice(rest).into_iter::<IgnoredAny>();
        values.next();
        start += values.byte_offset().max(1);
    }
    let system = match reading.crs {
        None => FeatureSystem::WGS84,
        Some(name) if name.to_uppercase().contains("CRS84") => FeatureSystem::WGS84,
        Some(name) => match epsg_numbers_in(&name).first() {
            Some(epsg) => FeatureSystem { is_order_open: true, ..FeatureSystem::of_epsg(*epsg) },
            None => FeatureSystem::of_text(&name),
        },
    };
    Ok(system)
}

/// State while a file is read.
struct Reading<'t, 'f> {
    take: &'t mut TakeFeature<'f>,
    /// Error of the consumer of features, which stopped the reading.
    failed: Option<Error>,
    /// Name of the coordinate system.
    crs: Option<String>,
}

/// Reader of the outermost object: a collection, a feature, or a geometry.
struct Top<'r, 't, 'f> {
    reading: &'r mut Reading<'t, 'f>,
}

impl<'de> DeserializeSeed<'de> for Top<'_, '_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, source: D) -> std::result::Result<(), D::Error> {
        source.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Top<'_, '_, '_> {
    type Value = ();

    fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
        to.write_str("a GeoJSON object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<(), A::Error> {
        let mut rest = Map::new();
        let mut is_collection = false;
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "features" => {
                    is_collection = true;
                    map.next_value_seed(Features { reading: self.reading })?;
                }
                "crs" => {
                    let crs: Value = map.next_value()?;
                    let name = crs.pointer("/properties/name").or(Some(&crs)).and_then(Value::as_str);
                    self.reading.crs = name.map(str::to_owned);
                }
                "type" | "geometry" | "properties" | "id" | "coordinates" | "geometries" => {
                    rest.insert(key, map.next_value()?);
                }
                _ => drop(map.next_value::<IgnoredAny>()?),
            }
        }
        // Members come in any order, so that a single feature is complete only now.
        if is_collection {
            return Ok(());
        }
        let value = match rest.get("type").and_then(Value::as_str) {
            Some("FeatureCollection") => return Ok(()),
            Some("Feature") => JsonFeature::deserialize(Value::Object(rest)).map_err(A::Error::custom)?,
            Some(_) => JsonFeature { geometry: Some(Value::Object(rest)), ..JsonFeature::default() },
            None => return Err(A::Error::custom("it has no `type`, so it is no GeoJSON")),
        };
        self.reading.take(value)
    }
}

/// Reader of the list of features.
struct Features<'r, 't, 'f> {
    reading: &'r mut Reading<'t, 'f>,
}

impl<'de> DeserializeSeed<'de> for Features<'_, '_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, source: D) -> std::result::Result<(), D::Error> {
        source.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Features<'_, '_, '_> {
    type Value = ();

    fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
        to.write_str("a list of features")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> std::result::Result<(), A::Error> {
        while let Some(feature) = items.next_element::<JsonFeature>()? {
            self.reading.take(feature)?;
        }
        Ok(())
    }
}

#[derive(Default, Deserialize)]
struct JsonFeature {
    id: Option<Value>,
    properties: Option<Map<String, Value>>,
    geometry: Option<Value>,
}

impl Reading<'_, '_> {
    fn take<E: serde::de::Error>(&mut self, read: JsonFeature) -> std::result::Result<(), E> {
        let id = read.id.and_then(|id| match id {
            Value::String(text) => Some(text),
            Value::Number(number) => Some(number.to_string()),
            _ => None,
        });
        let mut feature = Feature { id, attributes: read.properties.unwrap_or_default(), ..Feature::default() };
        if let Some(geometry) = read.geometry {
            add(&mut feature, &geometry, DEPTH).map_err(E::custom)?;
        }
        (self.take)(feature).map_err(|error| {
            self.failed = Some(error);
            E::custom("stopped")
        })
    }
}

/// Adds the polygons of a geometry to a feature.
fn add(feature: &mut Feature, geometry: &Value, depth: usize) -> std::result::Result<(), String> {
    let Some(kind) = geometry.get("type").and_then(Value::as_str) else { return Ok(()) };
    let coordinates = geometry.get("coordinates").unwrap_or(&Value::Null);
    match kind {
        "Polygon" => feature.polygons.push(polygon(coordinates)?),
        "MultiPolygon" => {
            for one in list(coordinates)? {
                feature.polygons.push(polygon(one)?);
            }
        }
        "Point" => feature.points.push(position(coordinates)?),
        "MultiPoint" => {
            for one in list(coordinates)? {
                feature.points.push(position(one)?);
            }
        }
        "GeometryCollection" if depth > 0 => {
            for one in geometry.get("geometries").and_then(Value::as_array).into_iter().flatten() {
                add(feature, one, depth - 1)?;
            }
        }
        _ => feature.has_others = true,
    }
    Ok(())
}

fn polygon(value: &Value) -> std::result::Result<Vec<Vec<DVec3>>, String> {
    list(value)?.iter().map(|ring| list(ring)?.iter().map(position).collect()).collect()
}

fn position(value: &Value) -> std::result::Result<DVec3, String> {
    let wrong = || format!("a position is `{}`, not two or three numbers", excerpt(value.to_string().as_bytes()));
    match list(value)?.as_slice() {
        [x, y, rest @ ..] => {
            let z = rest.first().map_or(Some(0.0), Value::as_f64);
            Ok(DVec3::new(x.as_f64().ok_or_else(wrong)?, y.as_f64().ok_or_else(wrong)?, z.unwrap_or(0.0)))
        }
        _ => Err(wrong()),
    }
}

fn list(value: &Value) -> std::result::Result<&Vec<Value>, String> {
    value
        .as_array()
        .ok_or_else(|| format!("`coordinates` holds `{}`, not a list", excerpt(value.to_string().as_bytes())))
}
