//! Objects of a model and their fields. In: texts, their places in the file. Out: values by key.

use std::ops::Range;

/// An object of a model.
#[derive(Clone, Debug)]
pub struct ModelObject {
    /// Class, as written.
    pub class: String,
    /// Line, from 1; 0 where the form has no lines.
    pub line: usize,
    pub(crate) fields: Vec<ModelField>,
    /// Byte range of the object, with the character that ends it.
    pub(crate) span: Range<usize>,
}

/// A field of an object. The first field is the name in both forms; fields of epJSON have keys.
#[derive(Clone, Debug)]
pub(crate) struct ModelField {
    pub key: String,
    pub text: String,
    /// Byte range of the text; `None` where the text has no single range.
    pub span: Option<Range<usize>>,
    pub line: usize,
}

impl ModelObject {
    /// Returns true if the object is of a class, in any case of letters.
    pub fn is(&self, class: &str) -> bool {
        self.class.eq_ignore_ascii_case(class)
    }

    /// Returns the name of the object, or the first field of a class without names.
    pub fn name(&self) -> &str {
        self.fields.first().map_or("", |field| field.text.trim())
    }

    /// Returns the text of a field: the `place`th of IDF, counted from 1, which epJSON calls `key`.
    /// Empty if there is none.
    pub fn text(&self, place: usize, key: &str) -> &str {
        self.field(place, key).map_or("", |field| field.text.trim())
    }

    /// Returns the texts of all fields.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.fields.iter().map(|field| field.text.trim())
    }

    pub(super) fn field(&self, place: usize, key: &str) -> Option<&ModelField> {
        let keyed = self.fields.iter().any(|field| !field.key.is_empty());
        match keyed {
            true => self.fields.iter().find(|field| field.key == key),
            false => self.fields.get(place.checked_sub(1)?),
        }
    }

    /// Returns the object's name for messages: class and name.
    pub fn title(&self) -> String {
        format!("{} `{}`", self.class, self.name())
    }
}
