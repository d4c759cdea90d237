//! In: JSON text of a CityJSON object or of a CityJSONFeature. Out: the parts of it that readers
//! use, typed but unchecked. Error messages name the object or vertex at fault. Everything else
//! (appearance, extensions) is skipped without being stored.

use std::borrow::Cow;
use std::fmt::{self, Display};

use serde::Deserialize;
use serde::de::{Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

use crate::attributes::flat;
use crate::formats::cityjson::nested::Nested;
use crate::text::excerpt;

/// The whole text, or one line of a sequence.
#[derive(Debug, Default)]
pub(in crate::formats) struct Document<'a> {
    pub kind: Text<'a>,
    pub version: Text<'a>,
    pub transform: Option<Transform>,
    pub objects: Vec<(Text<'a>, CityObject<'a>)>,
    pub vertices: Vec<[f64; 3]>,
    pub reference_system: Option<Text<'a>>,
    pub templates: Templates<'a>,
}

/// Text borrowed from the file, or a copy if it holds escapes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(in crate::formats) struct Text<'a>(pub(in crate::formats) Cow<'a, str>);

#[derive(Debug, PartialEq, Deserialize)]
pub(in crate::formats) struct Transform {
    pub scale: [f64; 3],
    pub translate: [f64; 3],
}

#[derive(Debug, Deserialize)]
pub(in crate::formats) struct CityObject<'a> {
    #[serde(rename = "type", borrow)]
    pub kind: Text<'a>,
    #[serde(default, borrow)]
    pub geometry: Option<Vec<Shape<'a>>>,
    #[serde(default, borrow)]
    pub parents: Option<Vec<Text<'a>>>,
    #[serde(default, borrow)]
    pub children: Option<Vec<Text<'a>>>,
    /// Attributes, without nested values.
    #[serde(default, deserialize_with = "attributes")]
    pub attributes: Map<String, Value>,
}

/// One geometry of an object: surfaces, or an instance of a template.
#[derive(Debug, Deserialize)]
pub(in crate::formats) struct Shape<'a> {
    #[serde(rename = "type", borrow)]
    pub kind: Text<'a>,
    pub lod: Option<Lod>,
    pub boundaries: Option<Nested>,
    #[serde(default, borrow)]
    pub semantics: Option<Semantics<'a>>,
    pub template: Option<u64>,
    #[serde(default, rename = "transformationMatrix")]
    pub matrix: Option<Vec<f64>>,
    /// `[surface]`: line of the file, counted from 1, for formats with lines; it names the faces.
    #[serde(skip)]
    pub lines: Vec<u32>,
}

#[derive(Debug, Deserialize)]
pub(in crate::formats) struct Semantics<'a> {
    #[serde(default, borrow)]
    pub surfaces: Option<Vec<SurfaceKind<'a>>>,
    pub values: Option<Nested>,
}

#[derive(Debug, Deserialize)]
pub(in crate::formats) struct SurfaceKind<'a> {
    #[serde(rename = "type", borrow)]
    pub kind: Text<'a>,
}

#[derive(Debug, Default, Deserialize)]
pub(in crate::formats) struct Templates<'a> {
    #[serde(default, borrow)]
    pub templates: Vec<Shape<'a>>,
    #[serde(default, rename = "vertices-templates", deserialize_with = "vertices")]
    pub vertices: Vec<[f64; 3]>,
}

#[derive(Deserialize)]
struct Metadata<'a> {
    #[serde(default, rename = "referenceSystem", borrow)]
    reference_system: Option<Text<'a>>,
}

/// Level of detail: "2", "1.3"; a number before version 1.1. Ordered by its numbers: 2 before 2.2
/// before 2.10.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::formats) struct Lod {
    major: u32,
    minor: u32,
}

impl Lod {
    pub(in crate::formats) fn parse(text: &str) -> Option<Lod> {
        let (major, minor) = text.split_once('.').unwrap_or((text, "0"));
        Some(Lod { major: major.parse().ok()?, minor: minor.parse().ok()? })
    }

    /// Returns true for the level of outlines without height.
    pub(in crate::formats) fn is_flat(self) -> bool {
        self.major == 0
    }
}

impl Display for Lod {
    fn fmt(&self, to: &mut fmt::Formatter) -> fmt::Result {
        match self.minor {
            0 => write!(to, "{}", self.major),
            minor => write!(to, "{}.{minor}", self.major),
        }
    }
}

/// Returns a function that puts a place before an error message; serde_json keeps the line and
/// column.
fn within<E: Error>(place: impl Display) -> impl FnOnce(E) -> E {
    move |error| E::custom(format_args!("{place}: {error}"))
}

impl<'de: 'a, 'a> Deserialize<'de> for Document<'a> {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Root;
        impl<'de> Visitor<'de> for Root {
            type Value = Document<'de>;

            fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
                to.write_str("a CityJSON object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Document<'de>, A::Error> {
                let mut read = Document::default();
                while let Some(key) = map.next_key::<Text>()? {
                    let key = key.0.as_ref();
                    match key {
                        "type" => read.kind = map.next_value().map_err(within(key))?,
                        "version" => read.version = map.next_value().map_err(within(key))?,
                        "transform" => read.transform = map.next_value().map_err(within(key))?,
                        "CityObjects" => read.objects = map.next_value::<Objects>()?.0,
                        "vertices" => read.vertices = map.next_value::<Vertices>()?.0,
                        "metadata" => {
                            let metadata: Option<Metadata> = map.next_value().map_err(within(key))?;
                            read.reference_system = metadata.and_then(|metadata| metadata.reference_system);
                        }
                        "geometry-templates" => {
                            let templates: Option<Templates> = map.next_value().map_err(within(key))?;
                            read.templates = templates.unwrap_or_default();
                        }
                        _ => drop(map.next_value::<IgnoredAny>()?),
                    }
                }
                Ok(read)
            }
        }
        source.deserialize_map(Root)
    }
}

struct Objects<'a>(Vec<(Text<'a>, CityObject<'a>)>);

impl<'de> Deserialize<'de> for Objects<'de> {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct All;
        impl<'de> Visitor<'de> for All {
            type Value = Objects<'de>;

            fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
                to.write_str("CityObjects by their names")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Objects<'de>, A::Error> {
                let mut all = Vec::new();
                while let Some(id) = map.next_key::<Text>()? {
                    let place = |error| within(format_args!("object `{}`", excerpt(id.0.as_bytes())))(error);
                    let object = map.next_value().map_err(place)?;
                    all.push((id, object));
                }
                Ok(Objects(all))
            }
        }
        source.deserialize_map(All)
    }
}

struct Vertices(Vec<[f64; 3]>);

impl<'de> Deserialize<'de> for Vertices {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct All;
        impl<'de> Visitor<'de> for All {
            type Value = Vertices;

            fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
                to.write_str("vertices of three numbers each")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Vertices, A::Error> {
                let mut all = Vec::new();
                while let Some(vertex) =
                    items.next_element().map_err(|error| within(format_args!("vertex {}", all.len()))(error))?
                {
                    all.push(vertex);
                }
                Ok(Vertices(all))
            }
        }
        source.deserialize_seq(All)
    }
}

fn attributes<'de, D: Deserializer<'de>>(source: D) -> Result<Map<String, Value>, D::Error> {
    let stated: Option<Map<String, Value>> = Deserialize::deserialize(source)?;
    Ok(stated.map(|stated| flat(&stated)).unwrap_or_default())
}

fn vertices<'de, D: Deserializer<'de>>(source: D) -> Result<Vec<[f64; 3]>, D::Error> {
    Vertices::deserialize(source).map(|vertices| vertices.0)
}

impl<'de: 'a, 'a> Deserialize<'de> for Text<'a> {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = Text<'de>;

            fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
                to.write_str("a text")
            }

            fn visit_borrowed_str<E: Error>(self, text: &'de str) -> Result<Text<'de>, E> {
                Ok(Text(Cow::Borrowed(text)))
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Text<'de>, E> {
                Ok(Text(Cow::Owned(text.to_owned())))
            }
        }
        source.deserialize_str(Any)
    }
}

impl<'de> Deserialize<'de> for Lod {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Any;
        impl Visitor<'_> for Any {
            type Value = Lod;

            fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
                to.write_str("a level of detail, as \"2\" or \"2.2\"")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Lod, E> {
                Lod::parse(text.trim())
                    .ok_or_else(|| E::invalid_value(serde::de::Unexpected::Str(&excerpt(text.as_bytes())), &self))
            }

            fn visit_u64<E: Error>(self, number: u64) -> Result<Lod, E> {
                self.visit_str(&number.to_string())
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<Lod, E> {
                self.visit_str(&number.to_string())
            }
        }
        source.deserialize_any(Any)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six levels are read from texts and numbers alike, and are ordered: 2.10 comes after 2.2.
    #[test]
    fn levels_are_read_and_ordered_by_number() {
        let levels: Vec<Lod> = serde_json::from_str("[0, \"1\", 1.2, \"2.0\", \"2.2\", \"2.10\"]").expect("levels");
        assert!(levels.is_sorted() && levels.windows(2).all(|pair| pair[0] != pair[1]));
        assert_eq!(levels.iter().map(Lod::to_string).collect::<Vec<_>>(), ["0", "1", "1.2", "2", "2.2", "2.10"]);
        for text in ["\"\"", "\"two\"", "\"-1\"", "\"2.\"", "-2", "[]", "1e300"] {
            assert!(serde_json::from_str::<Lod>(text).is_err(), "{text}");
        }
    }

    /// A text without escapes borrows the file's 3 bytes, a text with escapes is a copy.
    #[test]
    fn a_text_without_escapes_is_not_copied() {
        let texts: Vec<Text> = serde_json::from_str(r#"["abc", "a\nc"]"#).expect("texts");
        assert!(
            matches!(texts[0].0, Cow::Borrowed("abc")) && matches!(&texts[1].0, Cow::Owned(text) if text == "a\nc")
        );
    }
}
