//! Tags in one column. In: `"height"=>"12","roof:shape"=>"flat"`, as GDAL writes the tags of
//! OpenStreetMap that have no column of their own (`other_tags`), or an object. Out: attributes.

use serde_json::{Map, Value};

/// Columns that hold tags: as GDAL names them, and as tables of OpenStreetMap for programs do.
const COLUMNS: [&str; 2] = ["other_tags", "tags"];

/// Adds the tags in these columns to the attributes, from a text or from an object. A tag that has
/// a column of its own keeps the value of the column.
pub(super) fn unfold(attributes: &mut Map<String, Value>) {
    for column in COLUMNS {
        let found: Map<String, Value> = match attributes.get(column) {
            Some(Value::String(text)) => {
                let Some(tags) = tags(text) else { continue };
                tags.into_iter().map(|(name, value)| (name, Value::String(value))).collect()
            }
            Some(Value::Object(tags)) => tags.clone(),
            _ => continue,
        };
        attributes.remove(column);
        for (name, value) in found {
            attributes.entry(name).or_insert(value);
        }
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

    /// Three tags are read, and the one that has a column keeps the column's value; an object of
    /// tags is read too; a text without tags stays as it is.
    #[test]
    fn tags_become_attributes() {
        let mut map = json!({"name": "A", "other_tags": r#""height"=>"12","name"=>"B", "note"=>"a \"b\"""#});
        let map = map.as_object_mut().expect("an object");
        unfold(map);
        assert_eq!(Value::Object(map.clone()), json!({"name": "A", "height": "12", "note": "a \"b\""}));
        let mut object = json!({"tags": {"building": "yes"}});
        let object = object.as_object_mut().expect("an object");
        unfold(object);
        assert_eq!(Value::Object(object.clone()), json!({"building": "yes"}));
        let mut other = json!({"other_tags": "none"});
        let other = other.as_object_mut().expect("an object");
        unfold(other);
        assert_eq!(other.len(), 1);
    }
}
