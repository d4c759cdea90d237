//! Objects of an EnergyPlus model of either syntax. In: classes, keys and values. Out: fields by
//! key, numbers checked.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use crate::coordinate::MAX_COORDINATE_M;
use crate::formats::building::frame::Frame;
use crate::formats::building::notes::Notes;
use crate::formats::building::optics;
use crate::formats::energyplus::layout::Layout;
use crate::model_version::ModelVersion;
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::semantics::SurfaceKind;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Text(String),
    Number(f64),
    /// Value of a kind that no field can have: a list, an object, a truth value.
    Other(&'static str),
}

#[derive(Debug)]
pub(super) struct Object {
    pub layout: &'static Layout,
    /// Name as written; class and number for objects of a class without names.
    pub name: String,
    /// Line, counted from 1; 0 for epJSON.
    pub line: usize,
    pub fields: Vec<(&'static str, Value)>,
    pub vertices: Vec<[f64; 3]>,
}

/// Objects in the order of the file.
#[derive(Debug, Default)]
pub(super) struct Model {
    pub objects: Vec<Object>,
    pub version: Option<ModelVersion>,
}

impl Model {
    /// Returns the objects of a class, in the order of the file.
    pub(super) fn of(&self, class: &'static str) -> impl Iterator<Item = &Object> {
        self.objects.iter().filter(move |object| object.layout.class == class)
    }

    /// Returns the objects of several classes by name, in lower case; the first object of a name
    /// counts.
    pub(super) fn by_name<'m>(&'m self, classes: &[&str]) -> HashMap<String, &'m Object> {
        let mut found = HashMap::new();
        for object in self.objects.iter().filter(|object| classes.contains(&object.layout.class)) {
            found.entry(same(&object.name)).or_insert(object);
        }
        found
    }
}

/// Returns a name in the form in which EnergyPlus compares names: without regard to case.
pub(super) fn same(name: &str) -> String {
    name.trim().to_lowercase()
}

impl Object {
    fn value(&self, key: &str) -> Option<&Value> {
        self.fields.iter().find(|field| field.0 == key).map(|field| &field.1)
    }

    /// Returns the text of a field, empty if there is none.
    pub(super) fn text(&self, key: &str) -> &str {
        match self.value(key) {
            Some(Value::Text(text)) => text.trim(),
            _ => "",
        }
    }

    /// Returns the number of a field; `None` if it is missing, blank, `autocalculate` or
    /// `autosize`.
    pub(super) fn number(&self, file: &Path, key: &str) -> Result<Option<f64>> {
        let shown = match self.value(key) {
            None => return Ok(None),
            Some(Value::Number(number)) if number.abs() <= MAX_COORDINATE_M => return Ok(Some(*number)),
            Some(Value::Number(number)) => number.to_string(),
            Some(Value::Other(kind)) => (*kind).to_owned(),
            Some(Value::Text(text)) => {
                let text = text.trim();
                if ["", "autocalculate", "autosize"].iter().any(|word| text.eq_ignore_ascii_case(word)) {
                    return Ok(None);
                }
                match text.parse::<f64>() {
                    // NaN compares false.
                    Ok(number) if number.abs() <= MAX_COORDINATE_M => return Ok(Some(number)),
                    _ => excerpt(text.as_bytes()),
                }
            }
        };
        Err(self.error(
            file,
            format!("`{key}` is `{shown}`, not a number of at most 1e9 in size"),
            "write a decimal number with a point",
        ))
    }

    pub(super) fn number_or(&self, file: &Path, key: &str, otherwise: f64) -> Result<f64> {
        Ok(self.number(file, key)?.unwrap_or(otherwise))
    }

    /// Returns class and name, for messages.
    pub(super) fn title(&self) -> String {
        format!("{} `{}`", self.layout.class, excerpt(self.name.as_bytes()))
    }

    pub(super) fn error(&self, file: &Path, what: String, hint: &'static str) -> Error {
        let line = (self.line > 0).then_some(self.line);
        Error::input(file, line, format!("{}: {what}", self.title()), hint)
    }
}

/// Returns a share of light, clamped to 0..=1, or `otherwise` if the model does not state it.
pub(super) fn share(object: &Object, file: &Path, key: &str, otherwise: f64, notes: &mut Notes) -> Result<f64> {
    Ok(optics::share(object.number_or(file, key, otherwise)?, &object.name, notes))
}

/// Returns a share of light, clamped to 0..=1, or `None` if the model does not state it.
pub(super) fn stated_share(object: &Object, file: &Path, key: &str, notes: &mut Notes) -> Result<Option<f64>> {
    Ok(object.number(file, key)?.map(|value| optics::share(value, &object.name, notes)))
}

/// Space behind a surface, seen from its zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AdjacentSpace {
    Outdoors,
    Ground,
    /// Not stated: a wall to a neighbour, or one between zones.
    Adiabatic,
    Inside,
}

pub(super) struct Surface<'m> {
    pub object: &'m Object,
    pub vertices: Vec<DVec3>,
    pub frame: Frame,
    /// Index of the wall that an opening belongs to; a wall's own index for a wall.
    pub base: usize,
    pub behind: AdjacentSpace,
    pub kind: SurfaceKind,
    /// True if the sun may reach the surface: it lies outdoors and is not stated as `NoSun`.
    pub exposed: bool,
}
