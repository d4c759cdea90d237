//! Attributes of city objects. In: properties of a feature, and generic attributes. Out: values by
//! name.

use serde_json::{Map, Value};

use crate::formats::citygml::scan::Scan;
use crate::formats::xml::Element;
use heliotile_core::error::Result;

/// Properties of CityGML 2.0 and 3.0 that are attributes.
const KNOWN: [&str; 23] = [
    "name",
    "description",
    "class",
    "function",
    "usage",
    "creationDate",
    "terminationDate",
    "validTo",
    "yearOfConstruction",
    "yearOfDemolition",
    "dateOfConstruction",
    "dateOfDemolition",
    "roofType",
    "measuredHeight",
    "storeysAboveGround",
    "storeysBelowGround",
    "storeyHeightsAboveGround",
    "storeyHeightsBelowGround",
    "species",
    "height",
    "trunkDiameter",
    "crownDiameter",
    "averageHeight",
];

/// Attributes of [`KNOWN`] whose values are numbers.
const NUMBERS: [&str; 7] = [
    "measuredHeight",
    "storeysAboveGround",
    "storeysBelowGround",
    "height",
    "trunkDiameter",
    "crownDiameter",
    "averageHeight",
];

/// Longest name and value together that are kept, and most bytes kept of one object.
const LONGEST: usize = 1 << 12;
const MAX: usize = 1 << 16;

/// Attributes of a feature.
#[derive(Default)]
pub(super) struct Attributes {
    values: Map<String, Value>,
    bytes: usize,
}

impl Attributes {
    /// Adds a value. An attribute with several values keeps them all.
    pub(super) fn add(&mut self, name: &str, value: Value) {
        let length = name.len() + value.as_str().map_or(8, str::len);
        if name.is_empty() || value == Value::String(String::new()) || length > LONGEST || self.bytes + length > MAX {
            return;
        }
        self.bytes += length;
        match self.values.get_mut(name) {
            None => {
                self.values.insert(name.to_owned(), value);
            }
            Some(Value::Array(values)) => values.push(value),
            Some(first) => {
                let before = std::mem::take(first);
                *first = Value::Array(vec![before, value]);
            }
        }
    }

    /// Returns all values by name.
    pub(super) fn into_values(self) -> Map<String, Value> {
        self.values
    }
}

impl Scan<'_> {
    /// Reads a property as an attribute. Returns `None`, and reads nothing, if the property is not
    /// an attribute.
    pub(super) fn attribute(&mut self, property: &Element) -> Result<Option<(String, Value)>> {
        let name = property.name.as_str();
        if KNOWN.contains(&name) {
            let text = self.xml.words()?;
            return Ok(Some((name.to_owned(), value(text, NUMBERS.contains(&name)))));
        }
        match name {
            "stringAttribute" | "dateAttribute" | "uriAttribute" => self.generic(property, false).map(Some),
            "intAttribute" | "doubleAttribute" | "measureAttribute" => self.generic(property, true).map(Some),
            "genericAttribute" => {
                let mut found = (String::new(), Value::Null);
                while let Some(attribute) = self.xml.child()? {
                    let is_number =
                        ["IntAttribute", "DoubleAttribute", "MeasureAttribute"].contains(&attribute.name.as_str());
                    found = self.generic(&attribute, is_number)?;
                }
                Ok(Some(found))
            }
            _ => Ok(None),
        }
    }

    /// Reads a generic attribute, whose name is an XML attribute (2.0) or an element (3.0).
    fn generic(&mut self, element: &Element, is_number: bool) -> Result<(String, Value)> {
        let mut name = element.attribute("name").unwrap_or_default().to_owned();
        let mut found = String::new();
        while let Some(part) = self.xml.child()? {
            match part.name.as_str() {
                "name" => name = self.xml.words()?,
                "value" => found = self.xml.words()?,
                _ => self.xml.skip()?,
            }
        }
        Ok((name, value(found, is_number)))
    }
}

/// Returns a number if the value should be one and is, otherwise text.
fn value(text: String, is_number: bool) -> Value {
    let whole = || text.parse::<i64>().ok().map(Value::from);
    let number = || text.parse::<f64>().ok().and_then(serde_json::Number::from_f64).map(Value::Number);
    match is_number.then(|| whole().or_else(number)).flatten() {
        Some(number) => number,
        None => Value::String(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two values of one name become a list, an empty value is dropped, and a value of 5,000 bytes
    /// is dropped.
    #[test]
    fn values_of_one_name_become_a_list() {
        let mut attributes = Attributes::default();
        for (name, text, is_number) in [
            ("usage", "1000", false),
            ("usage", "1010", false),
            ("height", "7.5", true),
            ("storeys", "3", true),
            ("class", "", false),
        ] {
            attributes.add(name, value(text.into(), is_number));
        }
        attributes.add("long", value("a".repeat(5000), false));
        let text = Value::Object(attributes.into_values()).to_string();
        assert_eq!(text, r#"{"height":7.5,"storeys":3,"usage":["1000","1010"]}"#);
        assert!(Attributes::default().into_values().is_empty());
    }
}
