//! Answers to requests: a value as JSON, and arrays behind it. In: values and numbers. Out: a text
//! that says where in the bytes each array stands, and the bytes.

use serde::Serialize;
use serde_json::{Value, json};

/// Arrays start at multiples of this number of bytes.
const ALIGNMENT: usize = 4;

/// Numbers of one array.
pub enum Numbers<'n> {
    U8(&'n [u8]),
    U16(&'n [u16]),
    U32(&'n [u32]),
    F32(&'n [f32]),
}

/// Answer that is being made.
pub struct Answer {
    value: Value,
    /// Name, type, first byte and number of values of each array.
    sections: Vec<Value>,
    bytes: Vec<u8>,
}

impl Answer {
    /// Makes an answer without arrays.
    pub fn of(value: impl Serialize) -> Self {
        // Maps here have texts for keys, and no number is refused.
        let value = serde_json::to_value(value).unwrap_or(Value::Null);
        Answer { value, sections: Vec::new(), bytes: Vec::new() }
    }

    /// Adds an array.
    #[must_use]
    pub fn with(mut self, name: &str, numbers: Numbers) -> Self {
        let (first, bytes) = (self.bytes.len(), &mut self.bytes);
        let (kind, count) = match numbers {
            Numbers::U8(values) => {
                bytes.extend_from_slice(values);
                ("u8", values.len())
            }
            Numbers::U16(values) => {
                bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
                ("u16", values.len())
            }
            Numbers::U32(values) => {
                bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
                ("u32", values.len())
            }
            Numbers::F32(values) => {
                bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
                ("f32", values.len())
            }
        };
        bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
        self.sections.push(json!([name, kind, first, count]));
        self
    }

    /// Returns the text and the bytes of the arrays.
    pub fn finish(self) -> (Vec<u8>, Vec<u8>) {
        (json!({ "value": self.value, "arrays": self.sections }).to_string().into_bytes(), self.bytes)
    }
}
