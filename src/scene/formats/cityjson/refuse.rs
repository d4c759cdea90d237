//! In: text that should be CityJSON. Out: its document, or an error that says what the text is
//! instead.

use std::fmt;
use std::path::Path;

use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, Visitor};

use crate::formats::cityjson::document::Document;
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};

/// Most characters shown of a message by serde_json, which may quote the file.
const LONGEST_MESSAGE: usize = 300;

/// Reads one JSON value; `line` is its line in a sequence.
pub(super) fn document<'a>(text: &'a [u8], file: &Path, line: Option<usize>) -> Result<Document<'a>> {
    serde_json::from_slice(text).map_err(|error| {
        // For JSON of another kind, naming the kind helps more than naming its first error.
        if let Some(Err(other)) = serde_json::from_slice(text).ok().map(|sketch| kind_of(&sketch, file, line)) {
            return other;
        }
        let said = error.to_string();
        let place = format!(" at line {} column {}", error.line(), error.column());
        let said = said.replace(&place, "");
        let shown: String =
            said.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).take(LONGEST_MESSAGE).collect();
        let (what, hint) = if said.contains("EOF while") {
            (format!("the JSON text ends too early: {shown}"), "copy or export the file again: it was cut off")
        } else if said.contains("trailing characters") && line.is_none() {
            (
                format!("more text follows after the JSON value: {shown}"),
                "end the name of a sequence of features with .city.jsonl",
            )
        } else {
            (shown, "validate the file (cjval) or export it again: it is not valid CityJSON")
        };
        let at = line.unwrap_or(error.line());
        Error::input(file, (at > 0).then_some(at), format!("{what} (column {})", error.column()), hint)
    })
}

/// Accepts only CityJSON objects of known versions.
pub(super) fn other_kinds(document: &Document, text: &[u8], file: &Path, line: Option<usize>) -> Result<()> {
    if document.kind.0 != "CityJSON" {
        let sketch = serde_json::from_slice(text).unwrap_or_default();
        kind_of(&sketch, file, line)?;
    }
    version(document, file)
}

/// Accepts only known versions.
pub(super) fn version(document: &Document, file: &Path) -> Result<()> {
    if !["1.0", "1.1", "2.0"].iter().any(|known| document.version.0.starts_with(known)) {
        return Err(Error::Unsupported {
            what: format!("the CityJSON version of {}", file.display()).into(),
            found: format!("`{}`", excerpt(document.version.0.as_bytes())),
            supported: "1.0, 1.1, 2.0; upgrade older files: `cjio old.json upgrade save new.city.json`".into(),
        });
    }
    Ok(())
}

/// Accepts only features.
pub(super) fn other_than_features(document: &Document, file: &Path, line: usize) -> Result<()> {
    if document.kind.0 == "CityJSONFeature" {
        return Ok(());
    }
    let what = format!("the line's `type` is `{}`, not CityJSONFeature", excerpt(document.kind.0.as_bytes()));
    Err(Error::input(file, line, what, "a sequence has one header, its first line; join two files with cjio"))
}

/// Returns an error unless the value names itself CityJSON.
fn kind_of(sketch: &Sketch, file: &Path, line: Option<usize>) -> Result<()> {
    let has = |key: &str| sketch.keys.iter().any(|found| found == key);
    let (what, hint) = match sketch.kind.as_deref() {
        Some("CityJSON") => return Ok(()),
        // A feature is right in a sequence, except on its first line.
        Some("CityJSONFeature") if line.is_some_and(|line| line > 1) => return Ok(()),
        Some("CityJSONFeature") => (
            "the first line is a CityJSONFeature, not the header".to_owned(),
            "a sequence begins with a line of type CityJSON that holds `transform`",
        ),
        Some("FeatureCollection" | "Feature") => {
            ("the file is GeoJSON, not CityJSON".to_owned(), "export the 3D city model: flat outlines cast no shadow")
        }
        Some(other) => (
            format!("`type` is `{}`, not CityJSON", excerpt(other.as_bytes())),
            "give a CityJSON file, one of type CityJSON",
        ),
        None if sketch.is_list => ("the file is a JSON list, not a CityJSON object".to_owned(), "give a CityJSON file"),
        None if has("Building") || has("Zone") || has("BuildingSurface:Detailed") => (
            "the file looks like an EnergyPlus model (epJSON), not CityJSON".to_owned(),
            "end the name of an EnergyPlus model with .epJSON",
        ),
        None if has("asset") && (has("scenes") || has("meshes") || has("nodes")) => {
            ("the file looks like glTF, not CityJSON".to_owned(), "end the name of a glTF file with .gltf")
        }
        None => {
            let keys: Vec<String> = sketch.keys.iter().map(|key| format!("`{}`", excerpt(key.as_bytes()))).collect();
            let found =
                if keys.is_empty() { "holds nothing".into() } else { format!("begins with {}", keys.join(", ")) };
            (
                format!("the JSON object has no `type`, so the file is not CityJSON; the object {found}"),
                "give a CityJSON file",
            )
        }
    };
    Err(Error::input(file, line, what, hint))
}

/// Outline of a JSON value: its type and first keys.
#[derive(Default)]
struct Sketch {
    kind: Option<String>,
    /// First 64 keys.
    keys: Vec<String>,
    is_list: bool,
}

impl<'de> Deserialize<'de> for Sketch {
    fn deserialize<D: Deserializer<'de>>(source: D) -> std::result::Result<Self, D::Error> {
        struct Outside;
        impl<'de> Visitor<'de> for Outside {
            type Value = Sketch;

            fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
                to.write_str("a JSON object or list")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<Sketch, A::Error> {
                const KEYS_KEPT: usize = 64;
                let mut sketch = Sketch::default();
                while let Some(key) = map.next_key::<String>()? {
                    if key == "type" {
                        let kind: serde_json::Value = map.next_value()?;
                        sketch.kind = Some(kind.as_str().unwrap_or_default().to_owned());
                    } else {
                        map.next_value::<IgnoredAny>()?;
                    }
                    if sketch.keys.len() < KEYS_KEPT {
                        sketch.keys.push(key);
                    }
                }
                Ok(sketch)
            }

            fn visit_seq<A: serde::de::SeqAccess<'de>>(self, mut items: A) -> std::result::Result<Sketch, A::Error> {
                while items.next_element::<IgnoredAny>()?.is_some() {}
                Ok(Sketch { is_list: true, ..Sketch::default() })
            }
        }
        source.deserialize_any(Outside)
    }
}
