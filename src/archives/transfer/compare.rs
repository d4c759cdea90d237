//! Comparison of what two archives state about scene, settings and materials. In: two archives.
//! Out: the items that differ.

use serde_json::{Map, Value, json};

use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::{Archive, format, tables};
use heliotile_core::error::{Error, Result};
use heliotile_core::site::content::ContentHasher;

/// Keys of the manifest that describe one file, not its content.
const OF_THE_FILE: [&str; 4] = ["format", "creator", "counts", "layers"];

/// Length of the longest value in a message, characters.
const LONGEST: usize = 70;

/// Item with its values in both archives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Path of the item, such as `settings.hit`.
    pub item: String,
    /// Values in the first and in the second archive, shortened for messages.
    pub values: [String; 2],
}

/// Returns all stated items that differ, including unknown keys of the manifest, but not counts.
pub fn differences(a: &Archive, b: &Archive) -> Result<Vec<Difference>> {
    let mut found = Vec::new();
    walk("", Some(&statements(a)?), Some(&statements(b)?), &mut found);
    Ok(found)
}

fn statements(archive: &Archive) -> Result<Value> {
    let refuse = |e: serde_json::Error| Error::Unsupported {
        what: format!("{}: reading the manifest", archive.path().display()).into(),
        found: e.to_string(),
        supported: "a manifest that is JSON".into(),
    };
    let mut value = serde_json::to_value(archive.manifest()).map_err(refuse)?;
    if let Some(object) = value.as_object_mut() {
        OF_THE_FILE.iter().for_each(|key| drop(object.remove(*key)));
        if let Some(receivers) = object.get_mut("receivers").and_then(Value::as_object_mut) {
            ["count", "tiles", "tile_size"].iter().for_each(|key| drop(receivers.remove(*key)));
        }
        object.insert("materials".into(), materials(archive)?);
        let triangles = archive.entries_of(format::SCENE).iter().map(|entry| entry.items).sum::<u32>();
        let overview = shows(archive);
        object.insert(
            "shown".into(),
            json!({ "triangles": triangles, "objects": objects(archive), "overview": overview }),
        );
    }
    Ok(value)
}

/// Returns a hash of the objects of an archive's scene; `None` if the archive does not hold its
/// scene.
pub fn objects(archive: &Archive) -> Option<String> {
    let mut content = ContentHasher::new("objects");
    archive.entries_of(format::OBJECTS).iter().for_each(|entry| content.raw(&entry.content));
    archive.has(format::SCENE, TileNumber::FIRST).then(|| format::hex(&content.finish()))
}

/// Returns true if an archive holds the overview of all its receivers.
pub fn shows(archive: &Archive) -> bool {
    archive.entries_of(format::OVERVIEW).len() == archive.tiles() as usize
}

/// Returns the materials by name, with their numbers in cell keys.
fn materials(archive: &Archive) -> Result<Value> {
    let table = tables::MaterialsTable::from_block(&archive.block(format::MATERIALS, TileNumber::FIRST)?)?;
    let bands = match archive.has(format::BANDS, TileNumber::FIRST) {
        true => tables::BandsTable::from_block(&archive.block(format::BANDS, TileNumber::FIRST)?)?.optics(table.rows()),
        false => None,
    };
    let by_band = |i: usize| -> Map<String, Value> {
        let Some(optics) = bands.as_ref().and_then(|all| all.get(i)) else { return Map::new() };
        let light = optics.all().map(|(property, band, value)| (format!("{}.{}", property.name(), band.name()), value));
        let emissivity = optics.emissivity.map(|value| ("emissivity".to_owned(), value));
        light.chain(emissivity).map(|(name, value)| (name, value.into())).collect()
    };
    let row = |i: usize| {
        json!({
            "bands": by_band(i),
            "number": i,
            "diffuse": table.diffuse[i],
            "specular": table.specular[i],
            "class": table.class[i],
            "group": table.group[i],
        })
    };
    let rows: Map<String, Value> = table.name.iter().enumerate().map(|(i, name)| (name.clone(), row(i))).collect();
    Ok(Value::Object(rows))
}

/// Collects differences. Descends into items that are objects in both archives.
fn walk(item: &str, a: Option<&Value>, b: Option<&Value>, found: &mut Vec<Difference>) {
    match (a, b) {
        (Some(Value::Object(a)), Some(Value::Object(b))) => {
            let only_b = b.keys().filter(|key| !a.contains_key(*key));
            for key in a.keys().chain(only_b) {
                let item = if item.is_empty() { key.clone() } else { format!("{item}.{key}") };
                walk(&item, a.get(key), b.get(key), found);
            }
        }
        (a, b) if a == b => {}
        (a, b) => found.push(Difference { item: item.to_owned(), values: [a, b].map(text) }),
    }
}

fn text(value: Option<&Value>) -> String {
    let text = value.map_or("nothing".to_owned(), Value::to_string);
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}
