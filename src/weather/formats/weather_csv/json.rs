//! Weather as JSON. In: a document. Out: the names, units and rows of the table in it, and its
//! place.
//!
//! It reads PVGIS (`outputs` with a list of hours), Open-Meteo (`hourly` with an array for each
//! name) and NASA POWER (`properties` with an object of hours for each name). Of any other service
//! it reads a list of records, one record a line, or arrays of one length by name.

use std::collections::HashSet;
use std::path::Path;

use csv::ByteRecord;
use serde_json::{Map, Value};

use crate::formats::stamp_text::parse_stamp;
use crate::formats::weather_csv::head::{Head, Kind};
use crate::formats::weather_csv::layout::late_min;
use crate::formats::weather_csv::names::{Quantity, match_name, squash};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::excerpt;

/// A document as a table.
pub struct JsonTable {
    pub head: Head,
    pub records: Vec<ByteRecord>,
}

/// Largest number of members of an object that a message names.
const NAMED: usize = 8;

/// Largest number of levels down to the table.
const DEEPEST: usize = 6;

/// Returns true if a file starts as JSON does.
pub fn is_json(bytes: &[u8]) -> bool {
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let after = start.get(1..).unwrap_or_default().trim_ascii_start();
    matches!(
        (start.first(), after.first()),
        (Some(b'{'), Some(b'"' | b'}')) | (Some(b'['), Some(b'{' | b'[' | b']' | b'"'))
    )
}

pub fn table(path: &Path, bytes: &[u8]) -> Result<JsonTable> {
    let plain = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let document = document(plain).map_err(|error| {
        let what = format!("is not a complete JSON document: {}", excerpt(&error.to_string(), 120));
        Error::input(path, (error.line() > 0).then_some(error.line()), what, "the file may be cut off; fetch it again")
    })?;
    let mut head = Head::empty(path);
    // Known services come first, because only they state units and zones in known members.
    let found = open_meteo(path, &document, &mut head)?
        .or_else(|| nasa_power(&document, &mut head))
        .or_else(|| split_table(&document))
        .or_else(|| records_of(&document))
        .or_else(|| keyed_by_time(&document))
        .or_else(|| arrays(&document, 0));
    let Some((names, records)) = found else {
        let hint = "give PVGIS, Open-Meteo or NASA POWER as JSON, a list of records with a time and ghi, dni, dhi, or a CSV file";
        return Err(Error::input(
            path,
            None,
            format!("is JSON without a table of hours: {}", described(&document)),
            hint,
        ));
    };
    if head.kind == Kind::Plain {
        pvgis(path, &document, &mut head)?;
    }
    place(&document, &mut head);
    let cells = records.first().into_iter().flatten();
    head.first_row = cells.map(|cell| String::from_utf8_lossy(cell).into_owned()).collect();
    head.names = names;
    Ok(JsonTable { head, records })
}

/// Reads one document, or the list of documents that stand one a line.
fn document(bytes: &[u8]) -> serde_json::Result<Value> {
    serde_json::from_slice(bytes).or_else(|error| {
        let lines = serde_json::Deserializer::from_slice(bytes)
            .into_iter::<Value>()
            .collect::<serde_json::Result<Vec<Value>>>();
        lines.ok().filter(|lines| lines.len() > 1).map(Value::Array).ok_or(error)
    })
}

/// Reads names in `columns` and rows in `data`, as pandas writes a table with `orient="split"`.
fn split_table(document: &Value) -> Option<NamesAndRows> {
    let names: Vec<String> = document.get("columns")?.as_array()?.iter().map(text).collect();
    let rows = document.get("data")?.as_array()?;
    let records =
        rows.iter().map(|row| Some(row.as_array()?.iter().map(text).collect())).collect::<Option<Vec<ByteRecord>>>()?;
    Some((names, records))
}

type NamesAndRows = (Vec<String>, Vec<ByteRecord>);

/// Describes a document without a table.
fn described(document: &Value) -> String {
    match document {
        Value::Object(members) => {
            let names: Vec<String> =
                members.keys().take(NAMED).map(|name| format!("`{}`", excerpt(name, 20))).collect();
            format!("an object of {} members, {}", members.len(), names.join(", "))
        }
        Value::Array(items) => format!("a list of {} items", items.len()),
        _ => "a single value".into(),
    }
}

/// Returns a value as the text of a cell.
fn text(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// Returns the first list of records with light; else the first list of records.
fn records_of(document: &Value) -> Option<NamesAndRows> {
    let mut lists = Vec::new();
    lists_of_records(document, 0, &mut lists);
    let with_light = lists.iter().find(|items| names_of(items).iter().any(|name| is_light(name)));
    with_light.or(lists.first()).map(|items| of_records(items))
}

/// Collects the lists of objects, from the outside in.
fn lists_of_records<'v>(value: &'v Value, depth: usize, found: &mut Vec<&'v [Value]>) {
    match value {
        Value::Array(items) if items.len() > 1 && items.iter().all(Value::is_object) => found.push(items),
        Value::Array(items) if items.len() == 1 && depth < DEEPEST => lists_of_records(&items[0], depth + 1, found),
        Value::Object(members) if depth < DEEPEST => {
            members.values().for_each(|value| lists_of_records(value, depth + 1, found));
        }
        _ => {}
    }
}

fn is_light(name: &str) -> bool {
    let light = [Quantity::Ghi, Quantity::Dni, Quantity::Dhi, Quantity::Beam];
    light.into_iter().any(|quantity| match_name(name, quantity).is_some())
}

/// Returns the names of single values in all records, each once, in order of appearance.
fn names_of(items: &[Value]) -> Vec<String> {
    let (mut names, mut known) = (Vec::new(), HashSet::new());
    for (name, value) in items.iter().filter_map(Value::as_object).flatten() {
        if !value.is_object() && !value.is_array() && known.insert(name) {
            names.push(name.clone());
        }
    }
    names
}

/// Reads objects whose names are time stamps, as pandas writes a table with an index of times: one
/// object for each column (`columns`), or one for each stamp (`index`).
fn keyed_by_time(document: &Value) -> Option<NamesAndRows> {
    let members = document.as_object().filter(|members| members.len() > 1)?;
    let is_stamp = |name: &String| parse_stamp(name, None).is_some_and(|stamp| stamp.has_time);
    if members.keys().all(is_stamp) {
        let stamped = |(stamp, values): (&String, &Value)| {
            let mut record = values.as_object()?.clone();
            record.insert("time".to_owned(), Value::String(stamp.clone()));
            Some(Value::Object(record))
        };
        return Some(of_records(&members.iter().map(stamped).collect::<Option<Vec<Value>>>()?));
    }
    let columns: Vec<(&String, &Map<String, Value>)> =
        members.iter().map(|(name, values)| Some((name, values.as_object()?))).collect::<Option<_>>()?;
    let stamps: Vec<&String> = columns.first()?.1.keys().collect();
    if stamps.len() < 2 || !stamps.iter().all(|stamp| is_stamp(stamp)) {
        return None;
    }
    let names = std::iter::once("time".to_owned()).chain(columns.iter().map(|(name, _)| (*name).clone())).collect();
    let row = |stamp: &&String| {
        let cell = |values: &Map<String, Value>| values.get(stamp.as_str()).map(text).unwrap_or_default();
        std::iter::once((*stamp).clone()).chain(columns.iter().map(|(_, values)| cell(values))).collect()
    };
    Some((names, stamps.iter().map(row).collect()))
}

fn of_records(items: &[Value]) -> NamesAndRows {
    let objects: Vec<&Map<String, Value>> = items.iter().filter_map(Value::as_object).collect();
    let names = names_of(items);
    let cell = |object: &&Map<String, Value>, name: &String| object.get(name).map(text).unwrap_or_default();
    let records = objects.iter().map(|object| names.iter().map(|name| cell(object, name)).collect()).collect();
    (names, records)
}

/// Reads arrays of one length by name, as pandas writes columns, and services their series.
fn arrays(value: &Value, depth: usize) -> Option<NamesAndRows> {
    let members = value.as_object()?;
    let columns: Vec<(&String, Vec<String>)> =
        members.iter().filter_map(|(name, value)| Some((name, series(value)?))).collect();
    let length = columns.iter().map(|(_, cells)| cells.len()).max().unwrap_or_default();
    let whole: Vec<&(&String, Vec<String>)> = columns.iter().filter(|(_, cells)| cells.len() == length).collect();
    if length > 1 && whole.len() > 1 {
        let names = whole.iter().map(|(name, _)| (*name).clone()).collect();
        let row = |row: usize| whole.iter().filter_map(|(_, cells)| cells.get(row)).collect();
        return Some((names, (0..length).map(row).collect()));
    }
    if depth >= DEEPEST {
        return None;
    }
    members.values().find_map(|value| arrays(value, depth + 1))
}

/// Reads an array of values, or an object of values by row number.
fn series(value: &Value) -> Option<Vec<String>> {
    let single = |value: &Value| !value.is_object() && !value.is_array();
    match value {
        Value::Array(items) => items.iter().all(single).then(|| items.iter().map(text).collect()),
        Value::Object(rows) => {
            let mut numbered: Vec<(u64, &Value)> =
                rows.iter().map(|(row, value)| Some((row.parse().ok()?, value))).collect::<Option<_>>()?;
            numbered.sort_by_key(|(row, _)| *row);
            let all_single = numbered.iter().all(|(_, value)| single(value));
            (!numbered.is_empty() && all_single).then(|| numbered.iter().map(|(_, value)| text(value)).collect())
        }
        _ => None,
    }
}

/// Reads Open-Meteo: `hourly` or `minutely_15`, with units beside it.
fn open_meteo(path: &Path, document: &Value, head: &mut Head) -> Result<Option<NamesAndRows>> {
    if let Value::Array(places) = document
        && places.len() > 1
        && places.iter().all(|place| place.get("utc_offset_seconds").is_some())
    {
        let what = format!("holds {} places of Open-Meteo", places.len());
        return Err(Error::input(path, None, what, "ask for one place a file"));
    }
    let document = document.as_array().and_then(|places| places.first()).unwrap_or(document);
    let Some(offset) = document.get("utc_offset_seconds").and_then(Value::as_f64) else { return Ok(None) };
    let table = |series: &'static str| Some((series, arrays(document.get(series)?, DEEPEST)?));
    let mut all: Vec<(&str, NamesAndRows)> = ["minutely_15", "hourly"].into_iter().filter_map(table).collect();
    // Quarters of hours may hold temperatures alone, beside hours of light.
    all.sort_by_key(|(_, (names, _))| !names.iter().any(|name| is_light(name)));
    if let Some((series, found)) = all.into_iter().next() {
        let units = document.get(format!("{series}_units"));
        head.kind = Kind::OpenMeteo;
        let unit = |name: &String| units.and_then(|units| units.get(name)).map(text).unwrap_or_default();
        head.units = found.0.iter().map(unit).collect();
        head.units_are_loose = true;
        (head.station.zone_hours, head.station.zone_is_certain) = (Some(offset / 3600.0), true);
        return Ok(Some(found));
    }
    Ok(None)
}

/// Reads NASA POWER: an object of `YYYYMMDDHH` for each parameter.
fn nasa_power(document: &Value, head: &mut Head) -> Option<NamesAndRows> {
    let parameters = document.get("properties")?.get("parameter")?.as_object()?;
    let hours: Vec<&String> = parameters.values().next()?.as_object()?.keys().collect();
    let mut names = vec!["time".to_owned()];
    names.extend(parameters.keys().cloned());
    let row = |hour: &&String| {
        let cell = |values: &Value| values.get(hour.as_str()).map(text).unwrap_or_default();
        std::iter::once((*hour).clone()).chain(parameters.values().map(cell)).collect()
    };
    let records = hours.iter().map(row).collect();
    head.kind = Kind::NasaPower;
    let told = document.get("parameters");
    let unit = |name: &String| {
        let unit = told.and_then(|told| told.get(name)).and_then(|told| told.get("units"));
        unit.map(text).unwrap_or_default()
    };
    (head.units, head.units_are_loose) = (names.iter().map(unit).collect(), true);
    if let Some(place) = document.get("geometry").and_then(|geometry| geometry.get("coordinates")) {
        let number = |place_of: usize| place.get(place_of).and_then(Value::as_f64);
        (head.station.longitude_deg, head.station.latitude_deg) = (number(0), number(1));
        head.station.elevation_m = number(2).unwrap_or_default();
    }
    let header = document.get("header");
    let standard = header.and_then(|header| header.get("time_standard")).and_then(Value::as_str);
    head.nasa_zone(&standard.unwrap_or_default().to_lowercase());
    head.style.no_data = header.and_then(|header| header.get("fill_value")).and_then(Value::as_f64);
    Some((names, records))
}

/// Reads the plane and the time offset of PVGIS from `inputs`.
fn pvgis(path: &Path, document: &Value, head: &mut Head) -> Result<()> {
    let (Some(inputs), Some(_)) = (document.get("inputs"), document.get("outputs")) else { return Ok(()) };
    head.kind = Kind::Pvgis;
    head.slope_deg = number_of(inputs, "slope", 0);
    if let Some(hours) = number_of(inputs, "irradiancetimeoffset", 0) {
        head.late_min = late_min(path, None, hours, &hours.to_string())?;
    }
    Ok(())
}

/// Reads latitude, longitude and elevation from any level of the document.
fn place(document: &Value, head: &mut Head) {
    let single =
        document.as_array().filter(|items| items.len() == 1).and_then(|items| items.first()).unwrap_or(document);
    if !single.is_object() {
        return;
    }
    let station = &mut head.station;
    let number = |name: &str| number_of(single, name, 0);
    station.latitude_deg = station.latitude_deg.or_else(|| number("latitude"));
    station.longitude_deg = station.longitude_deg.or_else(|| number("longitude"));
    if station.elevation_m == 0.0 {
        station.elevation_m = number("elevation").unwrap_or_default();
    }
}

/// Returns the number of a member with this name, or of the `value` in it, from the outside in;
/// lists are skipped.
fn number_of(value: &Value, name: &str, depth: usize) -> Option<f64> {
    let members = value.as_object()?;
    let named = members.iter().find(|(key, _)| squash(key) == name).map(|(_, value)| value);
    let number = named.and_then(|value| value.as_f64().or_else(|| value.get("value")?.as_f64()));
    number.filter(|number| number.is_finite()).or_else(|| {
        let below = || members.values().find_map(|value| number_of(value, name, depth + 1));
        (depth < DEEPEST).then(below).flatten()
    })
}
