//! A model as text that is edited in place. In: the bytes of an IDF or epJSON file. Out: its
//! objects, and the bytes with values that were set and objects that were added or removed; all
//! other bytes stay.

mod epjson;
mod idf;
mod object;

use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::new_object::NewObject;
use heliotile_core::error::{Error, Problem, Result};
use object::ModelField;
pub use object::ModelObject;

/// File format of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    Idf,
    EpJson,
}

/// A model, and the edits to it.
pub struct Document {
    pub file: PathBuf,
    pub form: Form,
    pub objects: Vec<ModelObject>,
    pub(super) bytes: Vec<u8>,
    /// Byte ranges with their replacements; no two overlap.
    edits: Vec<(Range<usize>, Vec<u8>)>,
    added: Vec<NewObject>,
}

/// A new text for a field of one object.
#[derive(Clone, Debug)]
pub(super) struct FieldEdit {
    /// Index of the object in the model.
    pub object: usize,
    pub place: usize,
    pub key: &'static str,
    pub text: String,
}

impl Document {
    /// Reads a model; the extension of its file name says which form it has.
    pub fn read(file: &Path, bytes: Vec<u8>) -> Result<Document> {
        let ending = file.extension().map_or(String::new(), |ending| ending.to_string_lossy().to_lowercase());
        let form = match ending.as_str() {
            "idf" | "imf" => Form::Idf,
            "epjson" | "json" => Form::EpJson,
            _ => {
                let what = "is not named like a model of EnergyPlus: the name must end with .idf or .epJSON";
                return Err(Error::input(file, None, what, "give the model first, and its surroundings with {scene}")
                    .because(Problem::Ending));
            }
        };
        let objects = match form {
            Form::Idf => idf::objects(&bytes, file)?,
            Form::EpJson => epjson::objects(&bytes, file)?,
        };
        Ok(Document { file: file.to_owned(), form, objects, bytes, edits: Vec::new(), added: Vec::new() })
    }

    /// Returns the extension of the model's form, `idf` or `epJSON`.
    pub fn ending(&self) -> &'static str {
        match self.form {
            Form::Idf => "idf",
            Form::EpJson => "epJSON",
        }
    }

    /// Returns the objects of a class, in the order of the file.
    pub fn of<'d>(&'d self, class: &'d str) -> impl Iterator<Item = &'d ModelObject> {
        self.objects.iter().filter(move |object| object.is(class))
    }

    /// Returns the text of a field of the first object of a class; empty if there is none.
    pub fn first_text(&self, class: &str, place: usize, key: &str) -> &str {
        self.objects.iter().find(|object| object.is(class)).map_or("", |object| object.text(place, key))
    }

    /// Sets a field of all objects of a class; an object without the field gets it.
    pub fn set(&mut self, class: &str, place: usize, key: &str, value: &str) -> Result<()> {
        let quoted = self.form == Form::EpJson && value.parse::<f64>().is_err();
        let text = if quoted { serde_json::Value::from(value).to_string() } else { value.to_owned() };
        let mut edits = Vec::new();
        for object in self.objects.iter().filter(|object| object.is(class)) {
            let Some(field) = object.field(place, key) else {
                edits.push(self.missing(object, place, key, &text));
                continue;
            };
            let Some(span) = field.span.clone() else { return Err(self.in_lines(object, field)) };
            edits.push((span, text.clone().into_bytes()));
        }
        self.edits.extend(edits);
        Ok(())
    }

    /// Sets fields of single objects; objects without the field are skipped.
    pub(super) fn edit(&mut self, edits: Vec<FieldEdit>) -> Result<()> {
        for edit in edits {
            let Some(object) = self.objects.get(edit.object) else { continue };
            let Some(field) = object.field(edit.place, edit.key) else { continue };
            let Some(span) = field.span.clone() else { return Err(self.in_lines(object, field)) };
            let text = match self.form {
                Form::Idf => edit.text,
                Form::EpJson => serde_json::Value::from(edit.text).to_string(),
            };
            self.edits.push((span, text.into_bytes()));
        }
        Ok(())
    }

    /// Returns the error of a field that cannot be changed, as its text goes over several lines.
    fn in_lines(&self, object: &ModelObject, field: &ModelField) -> Error {
        let what = format!("{}: the field `{}` goes over several lines", object.title(), field.text.trim());
        Error::input(&self.file, field.line, what, "write it on one line, because heliotile has to change it")
    }

    /// Returns the insertion of a field that an object lacks: at its end in IDF, at its beginning
    /// in epJSON.
    fn missing(&self, object: &ModelObject, place: usize, key: &str, text: &str) -> (Range<usize>, Vec<u8>) {
        let (at, text) = match self.form {
            Form::Idf => {
                let blanks = place.saturating_sub(object.fields.len());
                (object.span.end.saturating_sub(1), ", ".repeat(blanks) + text)
            }
            Form::EpJson => {
                let more = if object.fields.len() > 1 { ", " } else { "" };
                (object.span.start + 1, format!("{}: {text}{more}", serde_json::Value::from(key)))
            }
        };
        (at..at, text.into_bytes())
    }

    /// Removes the objects for which `leaves` returns true, and returns their number. References to
    /// them stay.
    pub fn remove(&mut self, leaves: impl Fn(&ModelObject) -> bool) -> usize {
        let all = std::mem::take(&mut self.objects);
        let (gone, kept): (Vec<ModelObject>, Vec<ModelObject>) = all.into_iter().partition(leaves);
        self.objects = kept;
        let spans: Vec<Range<usize>> = gone.iter().map(|object| object.span.clone()).collect();
        match self.form {
            Form::Idf => self.edits.extend(spans.into_iter().map(|span| (span, Vec::new()))),
            Form::EpJson => self.edits.extend(epjson::removed(&self.bytes, &spans)),
        }
        gone.len()
    }

    /// Adds an object behind all others.
    pub fn add(&mut self, object: NewObject) {
        self.added.push(object);
    }

    /// Returns the model with all edits.
    pub fn bytes(&self) -> Vec<u8> {
        let mut edits = self.edits.clone();
        match self.form {
            Form::Idf => edits.push(idf::appended(&self.bytes, &self.added)),
            Form::EpJson => edits.extend(epjson::inserted(&self.bytes, &self.added)),
        }
        edits.sort_by_key(|(span, _)| (span.start, span.end));
        let (mut out, mut from) = (Vec::with_capacity(self.bytes.len()), 0);
        for (span, text) in edits {
            out.extend_from_slice(self.bytes.get(from..span.start).unwrap_or_default());
            out.extend_from_slice(&text);
            from = span.end;
        }
        out.extend_from_slice(self.bytes.get(from..).unwrap_or_default());
        out
    }
}
