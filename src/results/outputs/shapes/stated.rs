//! Attributes that the model states for objects, as columns beside results. In: the objects that
//! archives hold. Out: columns, and their values for an object or a building.

use std::collections::{BTreeMap, HashMap};

use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::tables::ObjectsTable;
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::Result;
use heliotile_core::site::model_part::ModelPart;
use serde_json::{Map, Value};

/// Largest number of columns: in models with more kinds of attributes, those of most objects are
/// kept.
const MAX_COLUMNS: usize = 64;
/// Least share of objects that must have an attribute for it to become a column.
const MIN_SHARE: f64 = 0.01;

/// Type of the values of a column of texts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextKind {
    Text,
    /// Integers of 64 bits.
    Whole,
    Number,
    Truth,
}

/// Columns of the attributes of all objects, and their values.
#[derive(Clone, Debug, Default)]
pub struct StatedColumns {
    /// Names and types of the columns.
    pub columns: Vec<(String, TextKind)>,
    /// Texts in the order of the columns, by object. `of_building` holds those by building; texts
    /// on which its objects differ are empty.
    of_object: HashMap<String, Vec<String>>,
    of_building: HashMap<String, Vec<String>>,
}

impl StatedColumns {
    /// Reads the attributes of the objects of some archives. `taken` are names that other columns
    /// have already.
    pub fn new<'a>(archives: impl Iterator<Item = &'a Archive>, taken: &[String]) -> Result<Self> {
        let mut objects: BTreeMap<String, (String, Map<String, Value>)> = BTreeMap::new();
        for archive in archives {
            for chunk in 0..archive.entries_of(format::OBJECTS).len() as u32 {
                let table = ObjectsTable::from_block(&archive.block(format::OBJECTS, TileNumber(chunk))?)?;
                for object in table.objects().into_iter().filter(|object| !object.note.attributes.is_empty()) {
                    let Ok(stated) = serde_json::from_str(&object.note.attributes) else { continue };
                    let name = if object.note.object.is_empty() { object.name } else { object.note.object };
                    objects.entry(name).or_insert((object.note.building, stated));
                }
            }
        }
        Ok(StatedColumns::of_objects(&objects, taken))
    }

    fn of_objects(objects: &BTreeMap<String, (String, Map<String, Value>)>, taken: &[String]) -> Self {
        let mut found: BTreeMap<&str, (usize, Option<TextKind>)> = BTreeMap::new();
        for (name, value) in objects.values().flat_map(|(_, stated)| stated) {
            let (count, kind) = found.entry(name).or_insert((0, None));
            *count += 1;
            let own = kind_of(value);
            *kind = Some(kind.map_or(own, |kind| joined(kind, own)));
        }
        let least = (MIN_SHARE * objects.len() as f64).ceil() as usize;
        let mut kept: Vec<(&str, usize, TextKind)> = found
            .into_iter()
            .filter(|(_, (count, _))| *count >= least)
            .map(|(name, (count, kind))| (name, count, kind.unwrap_or(TextKind::Text)))
            .collect();
        kept.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
        kept.truncate(MAX_COLUMNS);
        kept.sort_by(|a, b| a.0.cmp(b.0));
        let texts = |stated: &Map<String, Value>| -> Vec<String> {
            kept.iter().map(|(name, _, _)| stated.get(*name).map_or(String::new(), text_of)).collect()
        };
        let mut columns: Vec<(String, TextKind)> = Vec::new();
        for (name, _, kind) in &kept {
            let mut own = (*name).to_owned();
            while taken.contains(&own) || columns.iter().any(|(other, _)| *other == own) {
                own = format!("stated_{own}");
            }
            columns.push((own, *kind));
        }
        let mut all = StatedColumns { columns, ..StatedColumns::default() };
        for (name, (building, stated)) in objects {
            let texts = texts(stated);
            let whole = all.of_building.entry(building.clone()).or_insert_with(|| texts.clone());
            whole.iter_mut().zip(&texts).filter(|(known, own)| known != own).for_each(|(known, _)| known.clear());
            all.of_object.insert(name.clone(), texts);
        }
        all
    }

    /// Returns the texts of an object or building that receivers stand for, one a column; empty if
    /// nothing is stated.
    pub fn row(&self, part: &ModelPart) -> impl Iterator<Item = String> {
        let of_object = self.of_object.get(&part.object).filter(|_| !part.object.is_empty());
        let of_building = || self.of_building.get(&part.building).filter(|_| !part.building.is_empty());
        let found = of_object.or_else(of_building);
        (0..self.columns.len()).map(move |i| found.and_then(|texts| texts.get(i)).cloned().unwrap_or_default())
    }
}

impl TextKind {
    /// Returns a text as a JSON value of this type; null for an empty text.
    pub fn json(self, text: &str) -> Value {
        match self {
            _ if text.is_empty() => Value::Null,
            TextKind::Text => Value::String(text.to_owned()),
            TextKind::Whole | TextKind::Number | TextKind::Truth => serde_json::from_str(text).unwrap_or(Value::Null),
        }
    }
}

fn kind_of(value: &Value) -> TextKind {
    match value {
        Value::Bool(_) => TextKind::Truth,
        Value::Number(number) if number.is_i64() => TextKind::Whole,
        Value::Number(_) => TextKind::Number,
        _ => TextKind::Text,
    }
}

/// Returns the type that can hold values of both types.
fn joined(a: TextKind, b: TextKind) -> TextKind {
    match [a, b] {
        [a, b] if a == b => a,
        [TextKind::Whole | TextKind::Number, TextKind::Whole | TextKind::Number] => TextKind::Number,
        _ => TextKind::Text,
    }
}

fn text_of(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        value => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// A building with two parts has the values on which both parts agree; numbers stay numbers,
    /// and a column `kind` gets another name.
    #[test]
    fn a_building_has_the_values_on_which_its_parts_agree() {
        let object =
            |building: &str, value: Value| (building.to_owned(), value.as_object().expect("an object").clone());
        let objects = BTreeMap::from([
            ("a1".to_owned(), object("a", json!({"year": 1901, "kind": "tower", "h": 3}))),
            ("a2".to_owned(), object("a", json!({"year": 1901, "kind": "hall", "h": 2.5}))),
            ("b".to_owned(), object("b", json!({"year": 1950, "listed": true}))),
        ]);
        let stated = StatedColumns::of_objects(&objects, &["kind".to_owned()]);
        let kinds: Vec<(&str, TextKind)> = stated.columns.iter().map(|(name, kind)| (name.as_str(), *kind)).collect();
        assert_eq!(
            kinds,
            [
                ("h", TextKind::Number),
                ("stated_kind", TextKind::Text),
                ("listed", TextKind::Truth),
                ("year", TextKind::Whole)
            ]
        );
        let row = |object: &str, building: &str| {
            let part = ModelPart { object: object.into(), building: building.into(), ..ModelPart::default() };
            stated.row(&part).collect::<Vec<_>>()
        };
        assert_eq!(row("a1", "a"), ["3", "tower", "", "1901"]);
        assert_eq!(row("", "a"), ["", "", "", "1901"]);
        assert_eq!(row("", ""), ["", "", "", ""]);
        assert_eq!((TextKind::Whole.json("1901"), TextKind::Truth.json("")), (json!(1901), Value::Null));
    }
}
