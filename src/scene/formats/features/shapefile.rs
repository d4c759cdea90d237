//! In: a shapefile (Esri 1998), as files beside each other or in a zip. Out: its features, read by
//! the crates `shapefile` and `dbase`.

use std::io::Cursor;
use std::path::Path;

use glam::{DVec2, DVec3};
use heliotile_core::error::{Error, Result};
use serde_json::{Value, json};
use shapefile::dbase::{self, FieldValue};
use shapefile::record::traits::HasXY;
use shapefile::{Patch, PolygonRing, Shape, ShapeReader};

use super::feature::{Feature, FeaturePolygon, TakeFeature};
use super::system::FeatureSystem;
use crate::formats::sidecar;
use crate::input::ShapefileParts;
use crate::plan::{is_within, sides};
use crate::text::{excerpt, utf8};

/// Value below which a number in a shapefile means "no data" (Esri 1998, "Numeric Types").
const NO_DATA: f64 = -1e38;

/// Reads the shapes in `bytes`, with the table and the coordinate system beside the file.
pub(super) fn read(bytes: Vec<u8>, file: &Path, take: &mut TakeFeature) -> Result<FeatureSystem> {
    let parts = ShapefileParts {
        shapes: bytes,
        table: sidecar::bytes_beside(file, "dbf")?,
        system: sidecar::bytes_beside(file, "prj")?,
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
    let mut shapes = ShapeReader::new(Cursor::new(&parts.shapes)).map_err(|error| wrong("shapes", &error))?;
    let mut table = match &parts.table {
        Some(table) => Some(dbase::Reader::new(Cursor::new(table)).map_err(|error| wrong("table (.dbf)", &error))?),
        None => None,
    };
    let mut records = table.as_mut().map(|table| table.iter_records());
    for shape in shapes.iter_shapes() {
        let shape = shape.map_err(|error| wrong("shapes", &error))?;
        let record =
            records.as_mut().and_then(Iterator::next).transpose().map_err(|error| wrong("table (.dbf)", &error))?;
        let mut feature = feature(shape);
        feature.attributes =
            record.into_iter().flatten().filter_map(|(name, field)| Some((name, value(field)?))).collect();
        take(feature)?;
    }
    let text = parts.system.clone().map(|bytes| String::from_utf8_lossy(&utf8(bytes)).into_owned());
    Ok(text.map(|text| FeatureSystem::of_text(&text)).unwrap_or_default())
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
        _ => feature.has_others = true,
    }
    feature
}

/// Returns outlines with the holes in them. Writers differ in the order of rings, so a hole belongs
/// to the outline in which its first corner lies.
fn polygons<P: HasXY>(rings: &[PolygonRing<P>], height: impl Fn(&P) -> f64) -> Vec<FeaturePolygon> {
    let corners = |points: &[P]| -> Vec<DVec3> {
        let corner = |point: &P| {
            let z = height(point);
            DVec3::new(point.x(), point.y(), if z > NO_DATA && z.is_finite() { z } else { 0.0 })
        };
        points.iter().map(corner).collect()
    };
    let mut polygons: Vec<FeaturePolygon> = Vec::new();
    for ring in rings {
        if let PolygonRing::Outer(points) = ring {
            polygons.push(vec![corners(points)]);
        }
    }
    for ring in rings {
        let PolygonRing::Inner(points) = ring else { continue };
        let hole = corners(points);
        let first = hole.first().copied().unwrap_or_default().truncate();
        let holds = |outline: &Vec<DVec3>| {
            let plan: Vec<DVec2> = outline.iter().map(|corner| corner.truncate()).collect();
            is_within(sides(&plan), first)
        };
        let within = polygons.iter().position(|polygon| polygon.first().is_some_and(holds));
        match within.and_then(|at| polygons.get_mut(at)) {
            Some(polygon) => polygon.push(hole),
            // A ring in no outline was drawn in the wrong direction: it is an outline of its own.
            None => polygons.push(vec![hole]),
        }
    }
    polygons
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
