//! City models. In: a CityJSON object of version 1.0 to 2.0 (`.city.json`, `.json`), a sequence of
//! features (`.city.jsonl`, `.jsonl`), or a service's answer that wraps features (3DBAG). Out:
//! polygons with holes, named after city objects, with materials named after semantic surfaces.
//!
//! A face takes its material from its semantics, otherwise from the type of its object. Faces of
//! buildings without semantics take it from their tilt. Colours in `appearance` are made for
//! pictures, not reflectances, and are not read; neither is `geographicalExtent`. Attributes are
//! passed on to results.

mod answers;
pub(super) mod document;
pub(super) mod frame;
pub(super) mod nested;
pub(super) mod objects;
mod openings;
mod refuse;
pub(super) mod surfaces;
pub(super) mod templates;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::path::Path;

use crate::formats::ReadOptions;
use crate::geometry::Geometry;
use crate::text::{excerpt, without_byte_order_mark};
use answers::Answer;
use document::{Document, Lod};
use frame::Frame;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::{Message, counted, with_list};
use heliotile_files::input;
use heliotile_files::input::budget::WorkBudget;
use objects::Reader;
pub(super) use surfaces::name_by_tilt;
use templates::Template;

/// Hint on how to repair a damaged file.
const MEND: &str = "validate the file (cjval) or export it again: it is not valid CityJSON";

/// Reads a city model. A name that ends with `.jsonl` means a sequence.
pub(super) fn parse(bytes: &[u8], file: &Path, asked: &ReadOptions) -> Result<Geometry> {
    let asked = asked.lod.as_deref().map(|text| level(text, file)).transpose()?;
    let bytes = without_byte_order_mark(bytes);
    if bytes.trim_ascii().is_empty() {
        return Err(Error::input(file, None, "the file is empty", "export the city model again"));
    }
    if is_sequence(bytes, file) {
        return sequence(bytes, file, asked);
    }
    if let Some(answer) = answers::of(bytes) {
        return answered(answer, file, asked);
    }
    let mut document = refuse::document(bytes, file, None)?;
    refuse::other_kinds(&document, bytes, file, None)?;
    let (header, geometry) = Header::new(&mut document, file)?;
    let mut reader = header.reader(file, asked, geometry);
    reader.add(&document)?;
    finish(reader)
}

/// Reads a service's answer: the header in its metadata, and one feature or several.
fn answered(answer: Answer, file: &Path, asked: Option<Lod>) -> Result<Geometry> {
    let Answer { mut metadata, features } = answer;
    refuse::version(&metadata, file)?;
    let (header, geometry) = Header::new(&mut metadata, file)?;
    let mut reader = header.reader(file, asked, geometry);
    for feature in &features {
        reader.add(feature)?;
    }
    finish(reader)
}

/// Returns true for a sequence of features, one a line: by the name of the file, or because a
/// complete first line is followed by another one.
fn is_sequence(bytes: &[u8], file: &Path) -> bool {
    if ["jsonl", "cityjsonl"].contains(&input::ending(file).as_str()) {
        return true;
    }
    let first = bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let more = bytes.get(first.len()..).unwrap_or_default().trim_ascii_start().starts_with(b"{");
    more && first.trim_ascii_end().ends_with(b"}")
}

/// Reads a sequence: the first line is the header, every other line a feature with its own vertices
/// (CityJSON 2.0.1, section 7).
fn sequence(bytes: &[u8], file: &Path, asked: Option<Lod>) -> Result<Geometry> {
    let mut lines = (1..).zip(bytes.split(|byte| *byte == b'\n')).filter(|(_, text)| !text.trim_ascii().is_empty());
    let (line, text) = lines.next().unwrap_or((1, b""));
    let mut first = refuse::document(text, file, Some(line))?;
    refuse::other_kinds(&first, text, file, Some(line))?;
    let (header, geometry) = Header::new(&mut first, file)?;
    let mut reader = header.reader(file, asked, geometry);
    reader.line = Some(line);
    reader.add(&first)?;
    drop(first);
    for (line, text) in lines {
        let feature = refuse::document(text, file, Some(line))?;
        refuse::other_than_features(&feature, file, line)?;
        reader.line = Some(line);
        reader.add(&feature)?;
    }
    finish(reader)
}

/// Header of a file: the parts that apply to all its objects.
struct Header<'a> {
    frame: Frame,
    templates: Vec<Template<'a>>,
}

impl<'a> Header<'a> {
    fn new(document: &mut Document<'a>, file: &Path) -> Result<(Header<'a>, Geometry)> {
        let mut geometry = Geometry::default();
        if let Some(text) = &document.reference_system {
            geometry.reference = frame::reference(&text.0, file, &mut geometry.warnings)?;
        }
        let frame = Frame::new(document, file)?;
        let templates = templates::prepare(std::mem::take(&mut document.templates))
            .map_err(|what| Error::input(file, None, what, MEND))?;
        Ok((Header { frame, templates }, geometry))
    }

    fn reader<'f>(&'a self, file: &'f Path, asked: Option<Lod>, geometry: Geometry) -> Reader<'f, 'a> {
        Reader {
            file,
            line: None,
            asked,
            frame: self.frame,
            templates: &self.templates,
            geometry,
            objects: 0,
            levels: BTreeSet::new(),
            instanced: 0,
            budget: WorkBudget::of_file(file),
            coarser: Vec::new(),
            skipped: Vec::new(),
            mend: MEND,
        }
    }
}

/// Returns the geometry that was read, or an error that says why there is none.
pub(super) fn finish(reader: Reader) -> Result<Geometry> {
    let Reader { file, mut geometry, objects, levels, asked, coarser, skipped, mend, .. } = reader;
    if geometry.face_count() > 0 {
        let cut = openings::cut_openings(&mut geometry);
        if cut > 0 {
            let what = counted(cut as u64, "opening");
            geometry
                .doubts
                .push(format!("{what} (windows, doors) lie on walls and roofs without holes: cut out of them").into());
        }
        if let Some((first, others)) = coarser.split_first() {
            let count = counted(coarser.len() as u64, "building");
            let sentence = format!(
                "{count} (`{}`) read in a coarser level of detail: the finest one has no walls; state `lod` to choose a level",
                excerpt(first.as_bytes())
            );
            geometry.doubts.push(with_list(sentence, others.iter().cloned()));
        }
        geometry.warnings.extend(left_out(file, &skipped, mend));
        return Ok(geometry);
    }
    if let Some(first) = skipped.into_iter().next() {
        return Err(first);
    }
    if objects == 0 {
        return Err(Error::input(
            file,
            None,
            "the file holds no city objects",
            "export the city model with its objects",
        ));
    }
    let reasons: Vec<String> =
        geometry.left_out.iter().map(|(reason, count)| format!("{count} left out {reason}")).collect();
    let reasons = if reasons.is_empty() { String::new() } else { format!(": {}", reasons.join(", ")) };
    let what = format!("none of the {objects} city objects has a surface{reasons}");
    let only_outlines = geometry.left_out.contains_key(objects::OUTLINES);
    let levels: Vec<String> = levels.iter().map(Lod::to_string).collect();
    let hint = match asked {
        None if only_outlines => {
            "export walls and roofs (LoD 1 or finer): the file holds flat outlines of buildings (LoD 0)".to_owned()
        }
        Some(asked) => {
            format!("give one of the levels of detail that the file holds: {} (requested: {asked})", levels.join(", "))
        }
        None => "export surfaces or solids; points and lines shade nothing".into(),
    };
    Err(Error::input(file, None, what, hint))
}

/// Returns a sentence on the objects that are left out because their geometry is wrong, with a list
/// of all of them.
fn left_out(file: &Path, skipped: &[Error], mend: &str) -> Option<Message> {
    let words = |error: &Error| match error {
        Error::Input { what, line: Some(line), .. } => format!("line {line}, {}", what.plain()),
        Error::Input { what, .. } => what.plain(),
        other => other.to_string(),
    };
    let (first, others) = skipped.split_first()?;
    let sentence = format!(
        "{}: {} left out because of wrong geometry: {}; {mend}",
        file.display(),
        counted(skipped.len() as u64, "city object"),
        words(first)
    );
    Some(with_list(sentence, others.iter().map(words)))
}

/// Returns the level of detail in a user's text.
pub(super) fn level(text: &str, file: &Path) -> Result<Lod> {
    Lod::parse(text).ok_or_else(|| {
        let what = format!("level of detail `{}` is not a number", excerpt(text.as_bytes()));
        Error::input(file, None, what, "give a number such as 1, 1.3 or 2.2")
    })
}
