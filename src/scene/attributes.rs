//! Attributes of objects: what files state besides geometry. In: JSON values. Out: one flat JSON
//! object of texts, numbers and truth values, as archives keep it.

use heliotile_core::archive::tables::MAX_ATTRIBUTES;
use serde_json::{Map, Value};

/// Depth to which nested objects are flattened, as in `names.primary` of Overture.
const DEPTH: usize = 3;
/// Longest text that is kept, bytes: longer texts are no names or numbers.
const LONGEST_TEXT: usize = 1000;

/// Returns the attributes with nested objects flattened to dotted names. A list of texts and
/// numbers becomes one text. Empty values and texts that are too long are left out.
pub(crate) fn flat(attributes: &Map<String, Value>) -> Map<String, Value> {
    let mut all = Map::new();
    add(&mut all, "", attributes, DEPTH);
    all
}

fn add(all: &mut Map<String, Value>, before: &str, attributes: &Map<String, Value>, depth: usize) {
    for (name, value) in attributes {
        let name = format!("{before}{name}");
        match value {
            Value::Object(inner) if depth > 1 => add(all, &format!("{name}."), inner, depth - 1),
            Value::Number(_) | Value::Bool(_) => drop(all.insert(name, value.clone())),
            Value::Array(values) => {
                let texts: Option<Vec<String>> = values.iter().map(plain).collect();
                let text =
                    texts.map(|texts| texts.join(", ")).filter(|text| !text.is_empty() && text.len() <= LONGEST_TEXT);
                all.extend(text.map(|text| (name, Value::String(text))));
            }
            Value::String(text) if !text.is_empty() && text.len() <= LONGEST_TEXT => {
                all.insert(name, value.clone());
            }
            _ => {}
        }
    }
}

fn plain(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

/// Returns the attributes as JSON text of at most [`MAX_ATTRIBUTES`] bytes, leaving out the
/// alphabetically last names if there is no room for all. The text is empty if there are no
/// attributes.
pub(crate) fn text_of(mut attributes: Map<String, Value>) -> String {
    loop {
        if attributes.is_empty() {
            return String::new();
        }
        let names: Vec<String> = attributes.keys().cloned().collect();
        let text = Value::Object(attributes.clone()).to_string();
        if text.len() <= MAX_ATTRIBUTES {
            return text;
        }
        // Halving the names takes few rounds even if thousands do not fit.
        let mut names = names;
        names.sort_unstable();
        for name in names.iter().skip(names.len() / 2) {
            attributes.remove(name);
        }
    }
}

/// Returns the attributes that a text holds; none if the text is no JSON object.
pub(crate) fn object_of(text: &str) -> Map<String, Value> {
    serde_json::from_str(text).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// An object of 8 attributes keeps 5, one of them from a nested object and one from a list; of
    /// 400 texts of 100 bytes, 100 are kept within 16 KiB.
    #[test]
    fn nested_attributes_become_flat() {
        let value = json!({
            "id": 7, "name": "Hall", "listed": true, "names": {"primary": "H"}, "none": null, "empty": "", "list": [1, "b"], "lists": [[1]]
        });
        let flat = flat(value.as_object().expect("an object"));
        assert_eq!(text_of(flat), r#"{"id":7,"list":"1, b","listed":true,"name":"Hall","names.primary":"H"}"#);
        let many: Map<String, Value> = (0..400).map(|i| (format!("k{i:03}"), json!("x".repeat(100)))).collect();
        let text = text_of(many);
        assert!(text.len() <= MAX_ATTRIBUTES && object_of(&text).len() == 100);
        assert_eq!((text_of(Map::new()), object_of("[1]").len()), (String::new(), 0));
    }
}
