//! JSON objects and lists that are mostly copied unchanged. In: text. Out: keys in their order,
//! with the text of their values; or the texts of a list.

use std::fmt;
use std::io::{self, Write};

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;

/// Members of an object, in the order of the file.
#[derive(Debug, Default)]
pub(super) struct Fields<'a>(pub Vec<(String, &'a RawValue)>);

/// Parses an object, or the values of a list; `null` is an empty one.
pub(super) fn parsed<'a, T: Deserialize<'a> + Default>(value: &'a RawValue) -> serde_json::Result<T> {
    serde_json::from_str::<Option<T>>(value.get()).map(Option::unwrap_or_default)
}

impl<'a> Fields<'a> {
    /// Returns the value of a key.
    pub fn get(&self, key: &str) -> Option<&'a RawValue> {
        self.0.iter().find(|(name, _)| name == key).map(|(_, value)| *value)
    }

    /// Returns the value of a key if it is a string.
    pub fn text(&self, key: &str) -> Option<String> {
        self.get(key).and_then(|value| serde_json::from_str(value.get()).ok())
    }
}

impl<'de: 'a, 'a> Deserialize<'de> for Fields<'a> {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Members;
        impl<'de> Visitor<'de> for Members {
            type Value = Fields<'de>;

            fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
                to.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Fields<'de>, A::Error> {
                let mut all = Vec::new();
                while let Some(key) = map.next_key::<String>()? {
                    all.push((key, map.next_value::<&RawValue>()?));
                }
                Ok(Fields(all))
            }
        }
        source.deserialize_map(Members)
    }
}

/// JSON object being written.
pub(super) struct Members<'w, W: Write> {
    out: &'w mut W,
    first: bool,
}

impl<'w, W: Write> Members<'w, W> {
    pub fn begin(out: &'w mut W) -> io::Result<Self> {
        out.write_all(b"{")?;
        Ok(Members { out, first: true })
    }

    /// Writes the key of the next member; its value must be written next.
    pub fn key(&mut self, key: &str) -> io::Result<&mut W> {
        if !std::mem::take(&mut self.first) {
            self.out.write_all(b",")?;
        }
        serde_json::to_writer(&mut *self.out, key)?;
        self.out.write_all(b":")?;
        Ok(self.out)
    }

    pub fn member(&mut self, key: &str, value: &str) -> io::Result<()> {
        self.key(key)?.write_all(value.as_bytes())
    }

    pub fn end(self) -> io::Result<()> {
        self.out.write_all(b"}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An object of 3 members is written again with its keys in order and its numbers unchanged,
    /// `1.50` and `2e0`; null is an empty object.
    #[test]
    fn numbers_and_keys_are_written_again_unchanged() {
        let text = r#"{"b":1.50,"a\n":{"x": 2e0},"c":null}"#;
        let fields: Fields = serde_json::from_str(text).expect("an object");
        let mut out = Vec::new();
        let mut members = Members::begin(&mut out).expect("memory");
        for (key, value) in &fields.0 {
            members.member(key, value.get()).expect("memory");
        }
        members.end().expect("memory");
        assert_eq!(String::from_utf8(out).expect("text"), text);
        let none: Fields = parsed(fields.get("c").expect("c")).expect("null");
        assert_eq!((fields.0.len(), none.0.len()), (3, 0));
    }
}
