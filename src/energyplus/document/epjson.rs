//! The JSON form of a model. In: bytes, objects to add. Out: objects with the byte ranges of their
//! values; text to insert. The contents of the file keep their order and their digits.

use std::collections::HashSet;
use std::fmt;
use std::ops::Range;
use std::path::Path;

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;
use serde_json::{Map, Value};

use super::object::{ModelField, ModelObject};
use crate::new_object::{FieldValue, NewObject};
use heliotile_core::error::{Error, Result};

/// Members of a JSON object in their order, with their values as raw text.
struct Members<'a>(Vec<(String, &'a RawValue)>);

impl<'de: 'a, 'a> Deserialize<'de> for Members<'a> {
    fn deserialize<D: Deserializer<'de>>(json: D) -> std::result::Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Members<'de>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<Members<'de>, A::Error> {
                let mut members = Vec::new();
                while let Some(member) = map.next_entry::<String, &RawValue>()? {
                    members.push(member);
                }
                Ok(Members(members))
            }
        }
        json.deserialize_map(Reader)
    }
}

/// Parses all objects of a model.
pub fn objects(bytes: &[u8], file: &Path) -> Result<Vec<ModelObject>> {
    let refuse = |what: String, line: Option<usize>| {
        Error::input(file, line, what, "an epJSON file is `{\"Class\": {\"name\": {\"field\": value}}}`, in UTF-8")
    };
    let whole = std::str::from_utf8(bytes).map_err(|error| refuse(format!("not UTF-8: {error}"), None))?;
    let text = whole.trim_start_matches('\u{feff}');
    let members = |text: &'_ str| -> std::result::Result<Vec<(String, Range<usize>)>, serde_json::Error> {
        let Members(members) = serde_json::from_str(text)?;
        Ok(members.into_iter().map(|(key, raw)| (key, place_in(whole, raw.get()))).collect())
    };
    let of = |span: &Range<usize>| whole.get(span.clone()).unwrap_or_default();
    let mut objects = Vec::new();
    let classes = members(text).map_err(|e| refuse(format!("not a model in epJSON: {e}"), Some(e.line())))?;
    for (class, span) in classes {
        let listed =
            members(of(&span)).map_err(|e| refuse(format!("`{class}` does not hold objects by name: {e}"), None))?;
        for (name, span) in listed {
            let fields =
                members(of(&span)).map_err(|e| refuse(format!("{class} `{name}` has no fields: {e}"), None))?;
            let key = "name".to_owned();
            let mut all = vec![ModelField { key, text: name, span: None, line: 0 }];
            for (key, span) in fields {
                // A part of a text that was parsed parses again.
                let value = serde_json::from_str::<Value>(of(&span)).unwrap_or_default();
                push(&mut all, key, value, span);
            }
            objects.push(ModelObject { class: class.clone(), line: 0, fields: all, span });
        }
    }
    Ok(objects)
}

/// Adds the field of a value, or a field for each value in a list or an object.
fn push(all: &mut Vec<ModelField>, key: String, value: Value, span: Range<usize>) {
    let text = match value {
        Value::String(text) => text,
        Value::Array(items) => return items.into_iter().for_each(|item| push(all, key.clone(), item, span.clone())),
        Value::Object(map) => return map.into_iter().for_each(|(key, item)| push(all, key, item, span.clone())),
        Value::Null => String::new(),
        other => other.to_string(),
    };
    all.push(ModelField { key, text, span: Some(span), line: 0 });
}

/// Returns the byte range of `part`, which is a slice of `whole`.
fn place_in(whole: &str, part: &str) -> Range<usize> {
    let start = (part.as_ptr() as usize).saturating_sub(whole.as_ptr() as usize);
    start..start + part.len()
}

/// Returns the insertions for new objects: members into classes that exist, and new classes before
/// the end.
pub fn inserted(bytes: &[u8], added: &[NewObject]) -> Vec<(Range<usize>, Vec<u8>)> {
    let whole = std::str::from_utf8(bytes).unwrap_or_default();
    let there = serde_json::from_str::<Members>(whole.trim_start_matches('\u{feff}')).map_or(Vec::new(), |all| all.0);
    let mut classes: Vec<&'static str> = Vec::new();
    for object in added {
        if !classes.contains(&object.class) {
            classes.push(object.class);
        }
    }
    let (mut edits, mut last) = (Vec::new(), String::new());
    for class in classes {
        let objects: Vec<String> = added.iter().filter(|object| object.class == class).map(member).collect();
        let found = there.iter().find(|(name, _)| name.eq_ignore_ascii_case(class));
        match found {
            Some((_, raw)) => {
                let at = place_in(whole, raw.get()).start + 1;
                let is_empty = raw.get().trim_start_matches('{').trim_start().starts_with('}');
                let text = format!("\n{}{}", objects.join(",\n"), if is_empty { "\n    " } else { "," });
                edits.push((at..at, text.into_bytes()));
            }
            None => last += &format!(",\n    {}: {{\n{}\n    }}", Value::from(class), objects.join(",\n")),
        }
    }
    // New classes go behind the last class; without any class, the first comma is dropped.
    let end = whole.rfind('}').unwrap_or(whole.len());
    let behind = whole.get(..end).unwrap_or_default().trim_end().len();
    let last = if there.is_empty() { last.trim_start_matches(',').to_owned() } else { last };
    edits.push((behind..behind, last.into_bytes()));
    edits
}

/// Returns the replacements of classes whose members at `gone` are removed.
pub fn removed(bytes: &[u8], gone: &[Range<usize>]) -> Vec<(Range<usize>, Vec<u8>)> {
    let whole = std::str::from_utf8(bytes).unwrap_or_default();
    let there = serde_json::from_str::<Members>(whole.trim_start_matches('\u{feff}')).map_or(Vec::new(), |all| all.0);
    let gone: HashSet<usize> = gone.iter().map(|span| span.start).collect();
    let mut edits = Vec::new();
    for (_, raw) in there {
        let members = serde_json::from_str::<Members>(raw.get()).map_or(Vec::new(), |all| all.0);
        let count = members.len();
        let is_kept = |member: &&(String, &RawValue)| !gone.contains(&place_in(whole, member.1.get()).start);
        let kept: Vec<String> = (members.iter().filter(is_kept))
            .map(|(key, raw)| format!("\n        {}: {}", Value::from(key.as_str()), raw.get()))
            .collect();
        if kept.len() < count {
            edits.push((place_in(whole, raw.get()), format!("{{{}\n    }}", kept.join(",")).into_bytes()));
        }
    }
    edits
}

fn member(object: &NewObject) -> String {
    let mut fields = Map::new();
    for (key, value) in &object.fields {
        fields.extend(json(value).map(|value| ((*key).to_owned(), value)));
    }
    if let Some((list, item, items)) = &object.list {
        let part = |(key, value): (&&str, &FieldValue)| Some(((*key).to_owned(), json(value)?));
        let entry = |values: &[FieldValue]| Value::Object(item.iter().zip(values).filter_map(part).collect());
        fields.insert((*list).to_owned(), items.chunks(item.len().max(1)).map(entry).collect());
    }
    format!("        {}: {}", Value::from(object.name.as_str()), Value::Object(fields))
}

fn json(value: &FieldValue) -> Option<Value> {
    match value {
        FieldValue::Text(text) => Some(Value::from(text.as_str())),
        FieldValue::Number(text) => serde_json::from_str(text).ok(),
        FieldValue::Nothing => None,
    }
}
