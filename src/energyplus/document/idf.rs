//! The text form of a model. In: bytes, objects to add. Out: objects with the byte ranges of their
//! fields; text to append behind the last object.

use std::ops::Range;
use std::path::Path;

use super::object::{ModelField, ModelObject};
use crate::new_object::{FieldValue, NewObject};
use heliotile_core::error::Result;
use heliotile_scene::idf_fields;

/// List values on one line.
const A_LINE: usize = 12;

/// Parses all objects of a model.
pub fn objects(bytes: &[u8], file: &Path) -> Result<Vec<ModelObject>> {
    let mut objects: Vec<ModelObject> = Vec::new();
    idf_fields(bytes, file, |field| {
        let text = String::from_utf8_lossy(field.text).into_owned();
        if field.place == 0 {
            let start = field.span.clone().map_or(field.end, |span| span.start);
            objects.push(ModelObject { class: text, line: field.line, fields: Vec::new(), span: start..field.end + 1 });
        } else if let Some(object) = objects.last_mut() {
            object.fields.push(ModelField { key: String::new(), text, span: field.span, line: field.line });
            object.span.end = field.end + 1;
        }
        Ok(true)
    })?;
    Ok(objects)
}

/// Returns the text to append for new objects, with the line ends of the file.
pub fn appended(bytes: &[u8], added: &[NewObject]) -> (Range<usize>, Vec<u8>) {
    let mut text = String::new();
    if !added.is_empty() {
        if bytes.last().is_some_and(|last| !matches!(last, b'\n' | b'\r')) {
            text.push('\n');
        }
        text += "\n! Added by heliotile.\n";
    }
    added.iter().for_each(|object| write(object, &mut text));
    let end_of_line = match (bytes.windows(2).any(|two| two == b"\r\n"), bytes.contains(&b'\n'), bytes.contains(&b'\r'))
    {
        (true, ..) => "\r\n",
        (_, false, true) => "\r",
        _ => "\n",
    };
    (bytes.len()..bytes.len(), text.replace('\n', end_of_line).into_bytes())
}

fn write(object: &NewObject, out: &mut String) {
    *out += object.class;
    let named = object.is_named.then_some(object.name.as_str());
    let fields = object.fields.iter().map(|(_, value)| shown(value));
    for text in named.into_iter().chain(fields) {
        *out += ",\n  ";
        *out += text;
    }
    let items = object.list.as_ref().map_or(&[][..], |list| list.2.as_slice());
    // EnergyPlus reads program lines one by one, so each gets a line; numbers share lines.
    let a_line = if items.iter().all(|item| matches!(item, FieldValue::Number(_))) { A_LINE } else { 1 };
    for (i, item) in items.iter().enumerate() {
        *out += if i % a_line == 0 { ",\n  " } else { ", " };
        *out += shown(item);
    }
    *out += ";\n\n";
}

fn shown(value: &FieldValue) -> &str {
    match value {
        FieldValue::Text(text) | FieldValue::Number(text) => text,
        FieldValue::Nothing => "",
    }
}
