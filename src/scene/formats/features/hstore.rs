//! Tags in one column. In: `"height"=>"12","roof:shape"=>"flat"`, as GDAL writes the tags of
//! OpenStreetMap that have no column of their own (`other_tags`). Out: attributes.

use serde_json::{Map, Value};

/// Adds the tags in `other_tags` to the attributes. A tag that has a column of its own keeps the
/// value of the column.
pub(super) fn unfold(attributes: &mut Map<String, Value>) {
    let Some(Value::String(text)) = attributes.get("other_tags").cloned() else { return };
    let Some(tags) = tags(&text) else { return };
    attributes.remove("other_tags");
    for (name, value) in tags {
        attributes.entry(name).or_insert(Value::String(value));
    }
}

fn tags(text: &str) -> Option<Vec<(String, String)>> {
    let mut tags = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let (name, behind) = quoted(rest)?;
        let (value, behind) = quoted(behind.trim_start().strip_prefix("=>")?.trim_start())?;
        tags.push((name, value));
        rest = behind.trim_start();
        rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
    }
    Some(tags)
}

/// Returns the text within quotation marks, and the rest behind it.
fn quoted(text: &str) -> Option<(String, &str)> {
    let inner = text.strip_prefix('"')?;
    let mut found = String::new();
    let mut letters = inner.char_indices();
    while let Some((at, letter)) = letters.next() {
        match letter {
            '\\' => found.push(letters.next()?.1),
            '"' => return Some((found, inner.get(at + 1..)?)),
            letter => found.push(letter),
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// Three tags are read, and the one that has a column keeps the column's value; a text without
    /// tags stays as it is.
    #[test]
    fn tags_become_attributes() {
        let mut map = json!({"name": "A", "other_tags": r#""height"=>"12","name"=>"B", "note"=>"a \"b\"""#});
        let map = map.as_object_mut().expect("an object");
        unfold(map);
        assert_eq!(Value::Object(map.clone()), json!({"name": "A", "height": "12", "note": "a \"b\""}));
        let mut other = json!({"other_tags": "none"});
        let other = other.as_object_mut().expect("an object");
        unfold(other);
        assert_eq!(other.len(), 1);
    }
}
