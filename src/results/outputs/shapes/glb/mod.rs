//! Maps as binary glTF 2.0: a mesh with colours, values and features, and the triangles of the
//! scene around it. In: rows, an archive's scene. Out: one file for Blender, three.js, Cesium.
//!
//! Coordinates are 32-bit, relative to a point that `asset.extras.origin_m` states, with z up; a
//! node turns them to glTF's y up.

mod binary;
mod surroundings;

use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;
use serde_json::{Map, Value, json};

use super::columns::MapColumns;
use super::crs::MapCrs;
use super::row::MapRow;
use super::rows::MapRows;
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use binary::{ARRAY, Binary, INDICES};
use heliotile_core::error::{Error, Result};
pub use surroundings::Surroundings;

/// Distance of the map in front of the surfaces that it is drawn on, metres: in the same plane both
/// would flicker.
const RAISED_M: f64 = 0.01;

/// Number that stands for a missing value.
const NO_NUMBER: f32 = -9999.0;

/// Largest number of places: they are numbered by 32-bit floats, which are exact for integers up to
/// this.
const MAX_PLACES: u64 = 1 << 24;

/// Bytes of a vertex with its colour, value and place number.
const CORNER_BYTES: u64 = 28;

/// Component types of accessors.
const F32: u32 = 5126;
const U32: u32 = 5125;
const U16: u32 = 5123;

/// Quarter turn about x as a quaternion: z up becomes y up.
const Z_UP: [f64; 4] = [-std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2];

/// Parts of the JSON that grow.
#[derive(Default)]
struct Scene {
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    nodes: Vec<Value>,
}

impl Scene {
    /// Adds an accessor and returns its index.
    fn accessor(&mut self, view: usize, kind: &str, component: u32, count: u64, more: Value) -> usize {
        let mut accessor = json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
        if let (Some(accessor), Value::Object(more)) = (accessor.as_object_mut(), more) {
            accessor.extend(more);
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn node(&mut self, name: &str, primitives: Vec<Value>) {
        self.nodes.push(json!({"name": name, "mesh": self.meshes.len()}));
        self.meshes.push(json!({"name": name, "primitives": primitives}));
    }
}

/// Writes the file.
pub fn write(
    sink: Sink,
    rows: &mut MapRows,
    columns: &MapColumns,
    crs: &MapCrs,
    around: Option<&Surroundings>,
    about: &Provenance,
) -> Result<u64> {
    let path = sink.path().to_owned();
    check_size(rows, &path)?;
    let [low, high] = rows.facts.bounds;
    let origin = (0.5 * (low + high)).round();
    let (mut binary, mut scene) = (Binary::new(&path)?, Scene::default());
    let raised_m = if around.is_some() { RAISED_M } else { 0.0 };
    scene.materials.push(json!({
        "name": "map", "doubleSided": true, "extensions": {"KHR_materials_unlit": {}},
        "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 1.0},
    }));
    let primitive = map_mesh(rows, columns, origin, raised_m, &mut binary, &mut scene)?;
    scene.node("map", vec![primitive]);
    let table = property_table(rows, columns, &mut binary)?;
    if let Some(around) = around {
        surroundings::add(around, origin, &mut binary, &mut scene)?;
    }
    let children: Vec<usize> = (0..scene.nodes.len()).collect();
    scene.nodes.push(json!({"name": "z up", "rotation": Z_UP, "children": children}));
    let (colour, _) = columns.numbers.get(columns.colour).cloned().unwrap_or_default();
    let units: Map<String, Value> = columns.numbers.iter().map(|(name, unit)| (name.clone(), json!(unit))).collect();
    let (views, length) = binary.views();
    let (scale, largest) = (columns.scale, rows.facts.largest);
    let extras = json!({
        "origin_m": origin.to_array(), "epsg": crs.epsg(), "raised_m": raised_m, "units": units,
        "colours": {"map": scale.name_on_surfaces(), "column": colour, "from": scale.least(largest.into()) as f32, "to": largest}, "heliotile": about.json(),
    });
    let json = json!({
        "asset": {"version": "2.0", "generator": concat!("heliotile ", env!("CARGO_PKG_VERSION")), "extras": extras},
        "extensionsUsed": ["KHR_materials_unlit", "EXT_mesh_features", "EXT_structural_metadata"],
        "extensions": {"EXT_structural_metadata": table},
        "scene": 0, "scenes": [{"name": "heliotile", "nodes": [children.len()]}],
        "nodes": scene.nodes, "meshes": scene.meshes, "materials": scene.materials, "accessors": scene.accessors,
        "bufferViews": views, "buffers": [{"byteLength": length}],
    });
    finish(sink, &json, binary, &path)
}

/// Refuses maps that do not fit, before they are written: more places than 32-bit floats can
/// number, more bytes than a file can have.
fn check_size(rows: &MapRows, path: &Path) -> Result<()> {
    if rows.facts.rows > MAX_PLACES {
        let what = format!("the number of places of {} (write .fgb, or choose fewer receivers)", path.display());
        return Err(Error::Limit { what: what.into(), value: rows.facts.rows, max: MAX_PLACES });
    }
    let least = CORNER_BYTES.saturating_mul(rows.facts.corners);
    if least > u64::from(u32::MAX) { Err(too_large(path, least)) } else { Ok(()) }
}

fn too_large(path: &Path, bytes: u64) -> Error {
    let what = format!("the size in bytes of {} (write .fgb, or choose fewer receivers)", path.display());
    Error::Limit { what: what.into(), value: bytes, max: u64::from(u32::MAX) }
}

/// Writes the mesh of the map. Each polygon has its own vertices, so that places share none.
fn map_mesh(
    rows: &mut MapRows,
    columns: &MapColumns,
    origin: DVec3,
    raised_m: f64,
    binary: &mut Binary,
    scene: &mut Scene,
) -> Result<Value> {
    let facts = rows.facts;
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    let view = binary.begin(Some(ARRAY))?;
    rows.each(|row| {
        for polygon in &row.polygons {
            let normal = polygon.normal() * raised_m;
            for corner in polygon.corners() {
                let corner = (*corner + normal - origin).as_vec3().to_array();
                low = std::array::from_fn(|i| low[i].min(corner[i]));
                high = std::array::from_fn(|i| high[i].max(corner[i]));
                corner.iter().try_for_each(|metres| binary.put(&metres.to_le_bytes()))?;
            }
        }
        Ok(())
    })?;
    let position = scene.accessor(view, "VEC3", F32, facts.corners, json!({"min": low, "max": high}));
    // Writes an attribute with the same value at all vertices of a place.
    let mut attribute =
        |kind: &str, component: u32, more: Value, value: &dyn Fn(u64, &MapRow) -> Vec<u8>| -> Result<usize> {
            let view = binary.begin(Some(ARRAY))?;
            let mut number = 0;
            rows.each(|row| {
                let bytes = value(number, row);
                number += 1;
                row.polygons.iter().flat_map(|polygon| polygon.corners()).try_for_each(|_| binary.put(&bytes))
            })?;
            Ok(scene.accessor(view, kind, component, facts.corners, more))
        };
    let colour_of = |row: &MapRow| row.numbers.get(columns.colour).copied().filter(|value| value.is_finite());
    let share = |row: &MapRow| colour_of(row).map_or(0.0, |value| value / facts.largest.max(f32::MIN_POSITIVE));
    let colour = attribute("VEC4", U16, json!({"normalized": true}), &|_, row| {
        let steps = columns.scale.on_surfaces(share(row)).map(linear);
        steps.into_iter().chain([u16::MAX]).flat_map(u16::to_le_bytes).collect()
    })?;
    let value =
        attribute("SCALAR", F32, json!({}), &|_, row| colour_of(row).unwrap_or(NO_NUMBER).to_le_bytes().to_vec())?;
    // Floats are exact for integers up to 2^24; glTF allows no 32-bit integers as vertex
    // attributes.
    let feature = attribute("SCALAR", F32, json!({}), &|number, _| (number as f32).to_le_bytes().to_vec())?;
    let view = binary.begin(Some(INDICES))?;
    let mut first = 0_u32;
    rows.each(|row| {
        for polygon in &row.polygons {
            for corner in polygon.triangles().iter().flatten() {
                binary.put(&(first + corner).to_le_bytes())?;
            }
            first += polygon.corners().count() as u32;
        }
        Ok(())
    })?;
    let indices = scene.accessor(view, "SCALAR", U32, 3 * facts.triangles, json!({}));
    let name = columns.numbers.get(columns.colour).map_or("", |(name, _)| name.as_str());
    let mut attributes = json!({"POSITION": position, "COLOR_0": colour, "_FEATURE_ID_0": feature});
    if let Some(attributes) = attributes.as_object_mut() {
        attributes.insert(format!("_{}", identifier(name).to_ascii_uppercase()), value.into());
    }
    let features = json!([{"featureCount": facts.rows, "attribute": 0, "propertyTable": 0, "label": "place"}]);
    Ok(json!({
        "attributes": attributes, "indices": indices, "material": 0,
        "extensions": {"EXT_mesh_features": {"featureIds": features}},
    }))
}

/// Writes the property table with the columns of each feature.
fn property_table(rows: &mut MapRows, columns: &MapColumns, binary: &mut Binary) -> Result<Value> {
    let (mut classes, mut table) = (Map::new(), Map::new());
    for (i, name) in columns.texts.iter().enumerate() {
        let values = binary.begin(None)?;
        rows.each(|row| binary.put(row.texts.get(i).map_or(&[][..], |text| text.as_bytes())))?;
        let offsets = binary.begin(None)?;
        let mut offset = 0_u32;
        binary.put(&offset.to_le_bytes())?;
        rows.each(|row| {
            offset += row.texts.get(i).map_or(0, |text| text.len() as u32);
            binary.put(&offset.to_le_bytes())
        })?;
        // A view has at least one byte, so columns of empty texts are left out.
        if offset == 0 {
            continue;
        }
        classes.insert(identifier(name), json!({"name": name, "type": "STRING"}));
        table.insert(identifier(name), json!({"values": values, "stringOffsets": offsets}));
    }
    for (i, (name, unit)) in columns.numbers.iter().enumerate() {
        let values = binary.begin(None)?;
        rows.each(|row| {
            let number = row.numbers.get(i).copied().filter(|number| number.is_finite());
            binary.put(&number.unwrap_or(NO_NUMBER).to_le_bytes())
        })?;
        let id = identifier(name);
        let property = json!({
            "name": name, "description": format!("{name}, {unit}"), "type": "SCALAR", "componentType": "FLOAT32",
            "noData": NO_NUMBER,
        });
        classes.insert(id.clone(), property);
        table.insert(id, json!({"values": values}));
    }
    Ok(json!({
        "schema": {"id": "heliotile", "classes": {"place": {"name": "place", "properties": classes}}},
        "propertyTables": [{"name": "places", "class": "place", "count": rows.facts.rows, "properties": table}],
    }))
}

/// Returns a name of letters, digits and underscores, without a leading digit, as properties and
/// attributes require.
fn identifier(name: &str) -> String {
    let plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if plain.starts_with(|c: char| c.is_ascii_digit()) { format!("_{plain}") } else { plain }
}

/// Converts a step of sRGB to linear light (IEC 61966-2-1:1999), in 65,535ths.
fn linear(step: u8) -> u16 {
    let share = f64::from(step) / 255.0;
    let light = if share <= 0.040_45 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) };
    (light * f64::from(u16::MAX)).round() as u16
}

/// Writes the header, the JSON padded with blanks, and the binary part padded with zeros.
fn finish(mut sink: Sink, json: &Value, binary: Binary, path: &Path) -> Result<u64> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = binary.length();
    let whole = 12 + 8 + text.len() as u64 + 8 + length;
    let size = u32::try_from(whole).map_err(|_| too_large(path, whole))?;
    let mut write = || -> io::Result<()> {
        sink.write_all(b"glTF")?;
        for number in [2, size, text.len() as u32] {
            sink.write_all(&number.to_le_bytes())?;
        }
        sink.write_all(b"JSON")?;
        sink.write_all(&text)?;
        sink.write_all(&(length as u32).to_le_bytes())?;
        sink.write_all(b"BIN\0")
    };
    write().map_err(Error::io(path, "write to"))?;
    binary.copy_to(&mut sink)?;
    sink.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Black, the middle and white of sRGB are 0, 21.4 % and all of the light; 3 names become
    /// identifiers.
    #[test]
    fn middle_grey_is_a_fifth_of_the_light() {
        assert_eq!([0, 127, 255].map(linear), [0, 13_909, 65_535]);
        assert_eq!(["total_kwh_m2", "12 noon", "a-b"].map(identifier), ["total_kwh_m2", "_12_noon", "a_b"]);
    }
}
