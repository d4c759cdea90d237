//! Reader of Honeybee models. In: an HBJSON file. Out: the hull of its rooms with windows and doors
//! cut out, and its shades, in metres, normals outwards, named by identifiers. Rooms that stand for
//! several are drawn once. These files have no place on Earth.
//!
//! Written from the schema (ladybug-tools, honeybee-schema 2.3), whose names the fields have.

mod cut;
mod document;
#[cfg(test)]
mod hostile_tests;
mod kind;
mod materials;
mod optics;
mod properties;
mod rooms;
mod surface;
#[cfg(test)]
mod tests;

use std::fmt;
use std::path::Path;

use serde::de::{Deserializer, Error as _, IgnoredAny, MapAccess, Visitor};

use crate::formats::ReadOptions;
use crate::formats::building::standing::{Shades, ground_elevation_m};
use crate::geometry::Geometry;
use crate::ground::model::ModelGround;
use crate::text::{excerpt, without_byte_order_mark};
use document::Model;
use heliotile_core::error::{Error, Result};

/// Most characters shown of a JSON error message, which may quote the file.
const LONGEST_MESSAGE: usize = 240;

const HINT: &str = "write it again with honeybee (`Model.to_hbjson`), or check it with `honeybee validate`";

/// Reads a model.
pub(super) fn parse(bytes: &[u8], file: &Path, asked: &ReadOptions) -> Result<Geometry> {
    let mut json = serde_json::Deserializer::from_slice(without_byte_order_mark(bytes));
    let model: Model = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let place = error.path().to_string();
        refused(error.into_inner(), &place, file)
    })?;
    json.end().map_err(|error| refused(error, "", file))?;
    if model.kind != "Model" {
        let what = format!("`type` is `{}`, not Model", excerpt(model.kind.as_bytes()));
        return Err(Error::input(file, None, what, "write the whole model with honeybee: `Model.to_hbjson`"));
    }
    if model.buildings.is_some() {
        let hint = "translate it first: `dragonfly translate model-to-honeybee`";
        return Err(Error::input(file, None, "the file is a Dragonfly model, not a Honeybee model", hint));
    }
    let (mut geometry, materials) = rooms::write(&model, file)?;
    for note in geometry.object_notes.values_mut().filter(|note| !note.object.is_empty()) {
        note.building.clone_from(&model.identifier);
    }
    let elevation_m = ground_elevation_m(&mut geometry, Shades::Count, file);
    geometry.ground = Some(ModelGround::usual(elevation_m));
    if asked.reflectances {
        geometry.stated = materials.into_stated();
    }
    if geometry.face_count() == 0 {
        let what = format!("no surface of the {} rooms faces outdoors", model.rooms.as_ref().map_or(0, Vec::len));
        return Err(Error::input(file, None, what, "give a model with rooms, orphaned faces or shades"));
    }
    Ok(geometry)
}

fn refused(error: serde_json::Error, place: &str, file: &Path) -> Error {
    let line = (error.line() > 0).then_some(error.line());
    // Most models stand in one line: the column and the path say more than the line.
    let said = error.to_string();
    let said = said.replace(&format!(" at line {} column {}", error.line(), error.column()), "");
    let said: String =
        said.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).take(LONGEST_MESSAGE).collect();
    let place: String = place.chars().filter(|c| !c.is_control()).take(LONGEST_MESSAGE).collect();
    let place = if ["", "."].contains(&place.as_str()) { String::new() } else { format!("{place}: ") };
    let hint = if error.is_eof() { "the file was cut off: copy or write it again" } else { HINT };
    Error::input(file, line, format!("not a Honeybee model: {place}{said} (column {})", error.column()), hint)
}

/// Returns true if a JSON file is a Honeybee model: an object of type `Model`.
pub(super) fn is_model(bytes: &[u8]) -> bool {
    struct Looks<'a>(&'a mut bool);

    impl<'de> Visitor<'de> for Looks<'_> {
        type Value = ();

        fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
            to.write_str("an object")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<(), A::Error> {
            while let Some(key) = map.next_key::<String>()? {
                if key == "type" {
                    *self.0 = map.next_value::<String>().is_ok_and(|kind| kind == "Model");
                    return Err(A::Error::custom("seen"));
                }
                map.next_value::<IgnoredAny>()?;
            }
            Ok(())
        }
    }

    let mut found = false;
    let mut json = serde_json::Deserializer::from_slice(without_byte_order_mark(bytes));
    // The visitor stops at the type, with an error that means nothing.
    let _ = json.deserialize_map(Looks(&mut found));
    found
}
