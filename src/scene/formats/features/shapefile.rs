//! In: a shapefile (Esri 1998), as files beside each other or in a zip. Out: its features, read by
//! the crates `shapefile` and `dbase`.
//!
//! The index (.shx) says which shape belongs to which row of the table (.dbf); the order of the
//! shapes in the .shp says nothing. A row that is marked as deleted takes its shape with it.

use std::io::Cursor;
use std::path::Path;

use encoding_rs::{Encoding, UTF_8, WINDOWS_1252};
use glam::{DVec2, DVec3};
use heliotile_core::error::{Error, Result};
use serde_json::{Value, json};
use shapefile::dbase::encoding::EncodingRs;
use shapefile::dbase::{self, FieldValue};
use shapefile::record::traits::HasXY;
use shapefile::{Patch, PolygonRing, Shape, ShapeReader};

use super::feature::{Feature, FeaturePolygon, TakeFeature};
use super::shape_index;
use super::system::FeatureSystem;
use crate::formats::sidecar;
use crate::plan::{is_within, sides, signed_area_m2};
use crate::text::{excerpt, utf8};
use heliotile_files::input::ShapefileParts;

/// Value below which a number in a shapefile means "no data" (Esri 1998, "Numeric Types").
const NO_DATA: f64 = -1e38;

/// Reads the shapes in `bytes`, with the table and the coordinate system beside the file.
pub(super) fn read(bytes: Vec<u8>, file: &Path, take: &mut TakeFeature) -> Result<FeatureSystem> {
    let parts = ShapefileParts {
        shapes: bytes,
        table: sidecar::bytes_beside(file, "dbf")?,
        system: sidecar::bytes_beside(file, "prj")?,
        index: sidecar::bytes_beside(file, "shx")?,
        encoding: sidecar::bytes_beside(file, "cpg")?,
    };
    read_parts(&parts, file, take)
}

/// Reads the features from the parts of a shapefile.
pub(super) fn read_parts(parts: &ShapefileParts, file: &Path, take: &mut TakeFeature) -> Result<FeatureSystem> {
    let wrong = |what: &str, error: &dyn std::fmt::Display| {
        let text = error.to_string();
        let what = format!("the {what} of the shapefile cannot be read: {}", excerpt(text.as_bytes()));
        Error::input(file, None, what, "download or export the file again: it is damaged or cut off")
    };
    let index = shape_index::of(&parts.shapes, parts.index.as_deref());
    let mut shapes = ShapeReader::with_shx(Cursor::new(&parts.shapes), Cursor::new(&index))
        .map_err(|error| wrong("shapes", &error))?;
    let mut table = match &parts.table {
        Some(table) => {
            let reader = dbase::ReaderBuilder::new().with_encoding(EncodingRs::from(encoding(parts)));
            Some(reader.build(Cursor::new(without_false_dates(table))).map_err(|error| wrong("table (.dbf)", &error))?)
        }
        None => None,
    };
    let mut records = table.as_mut().map(|table| table.iter_records());
    let mut number = 0;
    while let Some(shape) = shapes.read_nth_shape(number) {
        let shape = shape.map_err(|error| wrong("shapes", &error))?;
        let is_deleted = parts.table.as_ref().is_some_and(|table| is_deleted(table, number));
        number += 1;
        if is_deleted {
            continue;
        }
        let record =
            records.as_mut().and_then(Iterator::next).transpose().map_err(|error| wrong("table (.dbf)", &error))?;
        let mut feature = feature(shape);
        feature.attributes =
            record.into_iter().flatten().filter_map(|(name, field)| Some((name, value(field)?))).collect();
        take(feature)?;
    }
    let text = parts.system.clone().map(|bytes| String::from_utf8_lossy(&utf8(bytes)).into_owned());
    let mut system = text.map(|text| FeatureSystem::of_text(&text)).unwrap_or_default();
    if parts.table.is_none() {
        system.doubts.push(
            "the table (.dbf) beside the shapes is missing: its features have neither heights nor names; put it there"
                .into(),
        );
    }
    Ok(system)
}

/// Returns the number of two bytes in the header of a table.
fn word(table: &[u8], at: usize) -> usize {
    let bytes = table.get(at..at + 2).and_then(|bytes| bytes.try_into().ok());
    bytes.map_or(0, |bytes| usize::from(u16::from_le_bytes(bytes)))
}

/// Returns true if a row of a table is marked as deleted (dBASE III, structure of a table file).
fn is_deleted(table: &[u8], row: usize) -> bool {
    let [header, length] = [8, 10].map(|at| word(table, at));
    length.checked_mul(row).and_then(|start| table.get(header.checked_add(start)?)) == Some(&b'*')
}

/// Returns the table with blanks, which state no date, in place of dates that are none. GDAL writes
/// `00000000` for an absent date, and one such cell would refuse the whole table.
fn without_false_dates(table: &[u8]) -> Vec<u8> {
    let mut table = table.to_vec();
    let [header, length] = [8, 10].map(|at| word(&table, at));
    if length == 0 {
        return table;
    }
    // A field is described by 32 bytes: its type at 11, its length at 16. A row starts with a mark.
    let described = table.get(32..header.min(table.len())).unwrap_or_default();
    let (mut at, mut dates) = (1, Vec::new());
    for field in described.as_chunks::<32>().0.iter().take_while(|field| field[0] != b'\r') {
        let end = at + usize::from(field[16]);
        if field[11] == b'D' {
            dates.push(at..end);
        }
        at = end;
    }
    for row in table.get_mut(header..).unwrap_or_default().chunks_mut(length) {
        for date in &dates {
            if let Some(cell) = row.get_mut(date.clone()).filter(|cell| dbase::Date::from_bytes(cell).is_err()) {
                cell.fill(b' ');
            }
        }
    }
    table
}

/// Returns the encoding of the texts of a table: that of the .cpg, else of the language driver in
/// the header, else UTF-8 if the table is that, else Windows-1252, which holds Latin 1.
fn encoding(parts: &ShapefileParts) -> &'static Encoding {
    let table = parts.table.as_deref().unwrap_or_default();
    let stated = parts.encoding.as_ref().and_then(|bytes| encoding_of(&String::from_utf8_lossy(bytes)));
    // Numbers of language drivers as Esri's ArcGIS lists them, "dBASE language driver".
    let driver = || match table.get(29)? {
        0x13 | 0x7b => encoding_of("932"),
        0x4d | 0x7a => encoding_of("936"),
        0x4e | 0x79 => encoding_of("949"),
        0x4f | 0x78 => encoding_of("950"),
        0x26 | 0x65 => encoding_of("866"),
        0x7c | 0x50 => encoding_of("874"),
        0xc8 => encoding_of("1250"),
        0xc9 => encoding_of("1251"),
        0xca => encoding_of("1254"),
        0xcb => encoding_of("1253"),
        _ => None,
    };
    let is_utf8 = || std::str::from_utf8(table.get(word(table, 8)..).unwrap_or_default()).is_ok();
    stated.or_else(driver).unwrap_or_else(|| if is_utf8() { UTF_8 } else { WINDOWS_1252 })
}

/// Returns the encoding of a .cpg file, which names it by a label (`UTF-8`, `ISO-8859-1`) or by the
/// number of a code page (`1252`, `ANSI 1252`, `88591`).
fn encoding_of(text: &str) -> Option<&'static Encoding> {
    let text = text.trim_start_matches('\u{feff}').trim().trim_end_matches('\0').to_lowercase();
    let number = text.trim_start_matches(|letter: char| !letter.is_ascii_digit());
    let label = match number {
        "65001" => "utf-8".to_owned(),
        "932" => "shift_jis".to_owned(),
        "936" => "gbk".to_owned(),
        "949" => "euc-kr".to_owned(),
        "950" => "big5".to_owned(),
        "866" => "ibm866".to_owned(),
        "20127" => "us-ascii".to_owned(),
        _ if number.starts_with("8859") => {
            format!("iso-8859-{}", number.trim_start_matches("8859").trim_start_matches('-'))
        }
        _ if number.len() >= 3 && !text.contains("iso") => format!("windows-{number}"),
        _ => text.clone(),
    };
    Encoding::for_label(label.as_bytes()).or_else(|| Encoding::for_label(text.as_bytes()))
}

fn feature(shape: Shape) -> Feature {
    let mut feature = Feature::default();
    match shape {
        Shape::Polygon(polygon) => feature.polygons = polygons(polygon.rings(), |_| 0.0),
        Shape::PolygonM(polygon) => feature.polygons = polygons(polygon.rings(), |_| 0.0),
        Shape::PolygonZ(polygon) => feature.polygons = polygons(polygon.rings(), |point| point.z),
        Shape::Multipatch(body) => {
            feature.is_body = true;
            feature.polygons = faces(body.patches());
        }
        Shape::NullShape => {}
        Shape::Point(at) => feature.points.push(DVec3::new(at.x, at.y, 0.0)),
        Shape::PointM(at) => feature.points.push(DVec3::new(at.x, at.y, 0.0)),
        Shape::PointZ(at) => feature.points.push(DVec3::new(at.x, at.y, 0.0)),
        _ => feature.has_others = true,
    }
    feature
}

/// Returns outlines with the holes in them. Writers differ in the order of rings, so a hole belongs
/// to the outline in which it lies. If a hole lies in no outline, the directions of the rings say
/// nothing, and a ring in an odd number of others is a hole.
fn polygons<P: HasXY>(rings: &[PolygonRing<P>], height: impl Fn(&P) -> f64) -> Vec<FeaturePolygon> {
    let corner = |point: &P| {
        let z = height(point);
        DVec3::new(point.x(), point.y(), if z > NO_DATA && z.is_finite() { z } else { 0.0 })
    };
    let all: Vec<Ring> = rings.iter().map(|ring| Ring::new(ring.points().iter().map(corner).collect())).collect();
    let mut holes: Vec<bool> = rings.iter().map(|ring| matches!(ring, PolygonRing::Inner(_))).collect();
    let is_homeless = |(ring, is_hole): (&Ring, &bool)| *is_hole && outline_of(ring, &all, &holes).is_none();
    if all.iter().zip(&holes).any(is_homeless) {
        holes = all.iter().map(|ring| all.iter().filter(|other| ring.lies_in(other)).count() % 2 == 1).collect();
    }
    let mut polygons: Vec<FeaturePolygon> = vec![Vec::new(); all.len()];
    for (at, (ring, is_hole)) in all.iter().zip(&holes).enumerate() {
        let place = if *is_hole { outline_of(ring, &all, &holes) } else { None };
        let Some(polygon) = polygons.get_mut(place.unwrap_or(at)) else { continue };
        match place {
            Some(_) => polygon.push(ring.corners.clone()),
            None => polygon.insert(0, ring.corners.clone()),
        }
    }
    polygons.retain(|polygon| !polygon.is_empty());
    polygons
}

/// Returns the number of the smallest outline around a hole.
fn outline_of(hole: &Ring, all: &[Ring], holes: &[bool]) -> Option<usize> {
    let outlines =
        all.iter().zip(holes).enumerate().filter(|(_, (outline, is_hole))| !**is_hole && hole.lies_in(outline));
    outlines.min_by(|(_, (a, _)), (_, (b, _))| a.area_m2.total_cmp(&b.area_m2)).map(|(at, _)| at)
}

/// A ring of a polygon.
struct Ring {
    corners: Vec<DVec3>,
    plan: Vec<DVec2>,
    low: DVec2,
    high: DVec2,
    area_m2: f64,
}

impl Ring {
    fn new(corners: Vec<DVec3>) -> Ring {
        let plan: Vec<DVec2> = corners.iter().map(|corner| corner.truncate()).collect();
        let none = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let [low, high] = plan.iter().fold(none, |[low, high], p| [low.min(*p), high.max(*p)]);
        Ring { low, high, area_m2: signed_area_m2(&plan).abs(), plan, corners }
    }

    /// Returns true if a ring lies in another one: it is the smaller one, and the middles of most
    /// of its sides lie in the other. Its corners may lie on the other ring.
    fn lies_in(&self, other: &Ring) -> bool {
        let is_apart = self.low.cmpgt(other.high).any() || self.high.cmplt(other.low).any();
        if is_apart || self.area_m2 >= other.area_m2 {
            return false;
        }
        let middles: Vec<DVec2> = sides(&self.plan).filter(|[a, b]| a != b).map(|[a, b]| 0.5 * (a + b)).collect();
        2 * middles.iter().filter(|middle| is_within(sides(&other.plan), **middle)).count() > middles.len()
    }
}

/// Returns the faces of a multipatch (Esri 1998, "MultiPatch"). Rings of unknown order are
/// outlines.
fn faces(patches: &[Patch]) -> Vec<FeaturePolygon> {
    let mut faces: Vec<FeaturePolygon> = Vec::new();
    for patch in patches {
        let points: Vec<DVec3> = patch.points().iter().map(|p| DVec3::new(p.x, p.y, p.z)).collect();
        match patch {
            Patch::TriangleStrip(_) => {
                // Every second triangle of a strip turns the other way.
                let triangles = points.array_windows().enumerate();
                faces.extend(
                    triangles.map(|(i, [a, b, c])| vec![if i % 2 == 0 { vec![*a, *b, *c] } else { vec![*b, *a, *c] }]),
                );
            }
            Patch::TriangleFan(_) => {
                let Some((first, rest)) = points.split_first() else { continue };
                faces.extend(rest.array_windows().map(|[b, c]| vec![vec![*first, *b, *c]]));
            }
            Patch::InnerRing(_) => match faces.last_mut() {
                Some(face) => face.push(points),
                None => faces.push(vec![points]),
            },
            Patch::OuterRing(_) | Patch::FirstRing(_) | Patch::Ring(_) => faces.push(vec![points]),
        }
    }
    faces
}

/// Returns a value of the table as JSON; a whole number becomes an integer.
fn value(field: FieldValue) -> Option<Value> {
    let number = |number: f64| match number.fract() == 0.0 && number.abs() < 9e15 {
        true => json!(number as i64),
        false => json!(number),
    };
    match field {
        FieldValue::Character(text) => text.map(Value::String),
        FieldValue::Memo(text) => Some(Value::String(text)),
        FieldValue::Numeric(found) => found.map(number),
        FieldValue::Float(found) => found.map(|found| number(f64::from(found))),
        FieldValue::Double(found) | FieldValue::Currency(found) => Some(number(found)),
        FieldValue::Integer(found) => Some(json!(found)),
        FieldValue::Logical(found) => found.map(Value::Bool),
        FieldValue::Date(date) => date.map(|date| Value::String(date.to_string())),
        FieldValue::DateTime(_) => None,
    }
}
