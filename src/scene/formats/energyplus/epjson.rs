//! JSON form of EnergyPlus models. In: the bytes of an epJSON file. Out: its objects of known
//! classes; nothing else is kept.
//!
//! `{"Class": {"name": {"field": value}}}` (Input Output Reference, chapter "JSON Input Format").

use std::fmt;
use std::path::Path;

use serde::de::{DeserializeSeed, Deserializer, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};

use crate::coordinate::MAX_COORDINATE_M;
use crate::formats::energyplus::layout::Layout;
use crate::formats::energyplus::model::{Model, Object, Value};
use crate::model_version::ModelVersion;
use crate::text::without_byte_order_mark;
use heliotile_core::error::{Error, Result};

/// Most characters shown of a JSON error message.
const LONGEST_MESSAGE: usize = 240;

/// Reads all objects of known classes.
pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<Model> {
    let mut model = Model::default();
    let mut json = serde_json::Deserializer::from_slice(without_byte_order_mark(bytes));
    let read = json.deserialize_map(Classes(&mut model)).and_then(|()| json.end());
    read.map_err(|e| {
        let line = (e.line() > 0).then_some(e.line());
        let hint = "an epJSON file is `{\"Class\": {\"name\": {\"field\": value}}}`, as EnergyPlus writes it";
        // The message quotes what serde_json found, at any length.
        let what: String = e.to_string().chars().take(LONGEST_MESSAGE).collect();
        Error::input(file, line, format!("not a model in epJSON: {what}"), hint)
    })?;
    let stated = model.of("Version").next().and_then(|object| ModelVersion::parse(object.text("version_identifier")));
    model.version = stated;
    Ok(model)
}

/// Returns true if a JSON file is a model: its outermost object holds a typical EnergyPlus class.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    let mut found = false;
    let mut json = serde_json::Deserializer::from_slice(without_byte_order_mark(bytes));
    // The visitor stops at the first class, with an error that means nothing.
    let _ = json.deserialize_map(Looks(&mut found));
    found
}

struct Looks<'a>(&'a mut bool);

impl<'de> Visitor<'de> for Looks<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<(), A::Error> {
        const KNOWN: [&str; 5] =
            ["Building", "BuildingSurface:Detailed", "GlobalGeometryRules", "Shading:Site:Detailed", "Version"];
        while let Some(key) = map.next_key::<String>()? {
            if KNOWN.contains(&key.as_str()) {
                // Other formats may hold a member of that name; only a class holds named objects.
                if map.next_value::<std::collections::BTreeMap<String, Members>>().is_ok() {
                    *self.0 = true;
                }
                return Err(A::Error::custom("seen"));
            }
            map.next_value::<IgnoredAny>()?;
        }
        Ok(())
    }
}

/// An object with any members.
type Members = std::collections::BTreeMap<String, IgnoredAny>;

struct Classes<'m>(&'m mut Model);

impl<'de> Visitor<'de> for Classes<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object of classes")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<(), A::Error> {
        while let Some(class) = map.next_key::<String>()? {
            match Layout::of_class(&class) {
                Some(layout) => map.next_value_seed(Objects { model: self.0, layout })?,
                None => map.next_value::<IgnoredAny>().map(drop)?,
            }
        }
        Ok(())
    }
}

struct Objects<'m> {
    model: &'m mut Model,
    layout: &'static Layout,
}

impl<'de> DeserializeSeed<'de> for Objects<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, json: D) -> std::result::Result<(), D::Error> {
        json.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Objects<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "the {} objects by name", self.layout.class)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<(), A::Error> {
        while let Some(name) = map.next_key::<String>()? {
            let object = Object { layout: self.layout, name, line: 0, fields: Vec::new(), vertices: Vec::new() };
            self.model.objects.push(map.next_value_seed(Fields(object))?);
        }
        Ok(())
    }
}

struct Fields(Object);

impl<'de> DeserializeSeed<'de> for Fields {
    type Value = Object;

    fn deserialize<D: Deserializer<'de>>(self, json: D) -> std::result::Result<Object, D::Error> {
        json.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Fields {
    type Value = Object;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "the fields of {}", self.0.title())
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut map: A) -> std::result::Result<Object, A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            if self.0.layout.has_vertices && key == "vertices" {
                self.0.vertices = map.next_value_seed(Vertices(&self.0))?;
            } else if let Some(key) = self.0.layout.key(&key) {
                let value = match map.next_value::<serde_json::Value>()? {
                    serde_json::Value::String(text) => Value::Text(text),
                    serde_json::Value::Number(number) => Value::Number(number.as_f64().unwrap_or(f64::NAN)),
                    serde_json::Value::Null => Value::Other("null"),
                    serde_json::Value::Bool(_) => Value::Other("a truth value"),
                    serde_json::Value::Array(_) => Value::Other("a list"),
                    serde_json::Value::Object(_) => Value::Other("an object"),
                };
                self.0.fields.push((key, value));
            } else {
                map.next_value::<IgnoredAny>()?;
            }
        }
        Ok(self.0)
    }
}

/// Reader of an object's list of vertices.
struct Vertices<'o>(&'o Object);

impl<'de> DeserializeSeed<'de> for Vertices<'_> {
    type Value = Vec<[f64; 3]>;

    fn deserialize<D: Deserializer<'de>>(self, json: D) -> std::result::Result<Self::Value, D::Error> {
        json.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Vertices<'_> {
    type Value = Vec<[f64; 3]>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "the vertices of {}", self.0.title())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> std::result::Result<Self::Value, A::Error> {
        /// A vertex as epJSON spells it.
        #[derive(serde::Deserialize)]
        struct Vertex {
            #[serde(rename = "vertex_x_coordinate")]
            x: f64,
            #[serde(rename = "vertex_y_coordinate")]
            y: f64,
            #[serde(rename = "vertex_z_coordinate")]
            z: f64,
        }
        let title = self.0.title();
        let mut vertices = Vec::new();
        while let Some(Vertex { x, y, z }) = list
            .next_element()
            .map_err(|e| A::Error::custom(format!("vertex {} of {title}: {e}", vertices.len() + 1)))?
        {
            if let Some(beyond) = [x, y, z].into_iter().find(|metres| metres.abs() > MAX_COORDINATE_M) {
                let number = vertices.len() + 1;
                return Err(A::Error::custom(format!("vertex {number} of {title}: {beyond} is beyond 1e9 metres")));
            }
            vertices.push([x, y, z]);
        }
        Ok(vertices)
    }
}
