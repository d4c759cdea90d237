//! Text form of EnergyPlus models. In: the bytes of an IDF file. Out: its objects, with fields
//! named by their position.
//!
//! `Class, field, field;` with `!` before comments (Input Output Reference, chapter "Input Data
//! Dictionary").

use std::ops::Range;
use std::path::Path;

use crate::coordinate::MAX_COORDINATE_M;
use crate::formats::energyplus::layout::Layout;
use crate::formats::energyplus::model::{Model, Object, Value};
use crate::model_version::ModelVersion;
use crate::text::{excerpt, without_byte_order_mark};
use heliotile_core::error::{Error, Result};

/// Version that is assumed where a file states none: the newest known one.
const NEWEST: ModelVersion = ModelVersion { major: u16::MAX, minor: 0 };

/// Reads all objects of known classes. Their fields are in the order of the `assumed` version, or
/// else of the version that the file states.
pub(super) fn parse(bytes: &[u8], file: &Path, assumed: Option<ModelVersion>) -> Result<Model> {
    let version = match assumed {
        Some(version) => Some(version),
        None => version(bytes, file)?,
    };
    let mut reader = Reader {
        file,
        version: version.unwrap_or(NEWEST),
        model: Model { version, ..Model::default() },
        current: None,
    };
    idf_fields(bytes, file, |field| reader.take(field))?;
    Ok(reader.model)
}

/// Returns the version of a file. It may stand anywhere in the file, but it decides the meaning of
/// all fields.
fn version(bytes: &[u8], file: &Path) -> Result<Option<ModelVersion>> {
    let mut of_version = false;
    let mut found = None;
    idf_fields(bytes, file, |field| {
        if found.is_none() && of_version && field.place == 1 {
            found = ModelVersion::parse(&String::from_utf8_lossy(field.text));
        }
        of_version = field.place == 0 && field.text.eq_ignore_ascii_case(b"version");
        Ok(found.is_none())
    })?;
    Ok(found)
}

/// A field of an object of an IDF file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IdfField<'a> {
    /// Position in the object; 0 is the class.
    pub place: usize,
    /// Text without blanks around it.
    pub text: &'a [u8],
    /// Line on which the field ends, counted from 1.
    pub line: usize,
    /// True for the last field of an object.
    pub last: bool,
    /// Range of bytes of the file that hold the text; empty, before the closing mark, for an empty
    /// field. `None` if the text goes over several lines.
    pub span: Option<Range<usize>>,
    /// Position of the comma or semicolon behind the field, bytes from the start of the file.
    pub end: usize,
}

/// Passes all fields of all objects of an IDF file to `take`, until it returns `false`.
pub fn idf_fields(bytes: &[u8], file: &Path, mut take: impl FnMut(IdfField) -> Result<bool>) -> Result<()> {
    // The part of a field that stands in the lines before.
    let mut begun = Vec::new();
    let (mut place, mut line_of_object) = (0, 0);
    let whole = bytes.len();
    let bytes = without_byte_order_mark(bytes);
    let mut line_start = whole - bytes.len();
    // Only files of the old Macintosh hold no LF at all.
    let end_of_line = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
    for (line, text) in (1..).zip(bytes.split(|&byte| byte == end_of_line)) {
        let mut rest = text.split(|&byte| byte == b'!').next().unwrap_or_default().trim_ascii();
        // Position of a part of the line in the file.
        let at = |part: &[u8]| line_start + (part.as_ptr() as usize - text.as_ptr() as usize);
        if rest.starts_with(b"##") {
            return Err(Error::Unsupported {
                what: format!("{}, line {line}", file.display()).into(),
                found: format!("the macro `{}`", excerpt(rest)),
                supported: "IDF without macros: run EP-Macro, or save the model from its editor".into(),
            });
        }
        while let Some(end) = rest.iter().position(|&byte| byte == b',' || byte == b';') {
            let (piece, after) = rest.split_at(end);
            let last = after.first() == Some(&b';');
            rest = after.get(1..).unwrap_or_default();
            if place == 0 && begun.is_empty() {
                line_of_object = line;
            }
            let end = at(piece) + piece.len();
            let text = piece.trim_ascii();
            let start = if text.is_empty() { end } else { at(text) };
            let span = begun.is_empty().then(|| start..start + text.len());
            begun.extend_from_slice(piece);
            if !take(IdfField { place, text: begun.trim_ascii(), line, last, span, end })? {
                return Ok(());
            }
            begun.clear();
            place = if last { 0 } else { place + 1 };
        }
        if !rest.is_empty() {
            if place == 0 && begun.is_empty() {
                line_of_object = line;
            }
            begun.extend_from_slice(rest);
            begun.push(b' ');
        }
        line_start += text.len() + 1;
    }
    if place > 0 || !begun.is_empty() {
        let what = "the object that begins here does not end";
        return Err(Error::input(file, line_of_object, what, "put `;` behind its last field"));
    }
    Ok(())
}

struct Reader<'f> {
    file: &'f Path,
    version: ModelVersion,
    model: Model,
    /// Object being read, if its class is known.
    current: Option<Current>,
}

struct Current {
    object: Object,
    order: Vec<&'static str>,
    /// Coordinates of a vertex that is not complete.
    coordinates: Vec<f64>,
}

impl Reader<'_> {
    fn take(&mut self, field: IdfField) -> Result<bool> {
        if field.place == 0 {
            self.begin(&field)?;
        } else if let Some(current) = &mut self.current {
            current.take(self.file, &field)?;
        }
        if field.last
            && let Some(current) = self.current.take()
        {
            let number = self.model.objects.len() + 1;
            self.model.objects.push(current.finish(self.file, number)?);
        }
        Ok(true)
    }

    fn begin(&mut self, field: &IdfField) -> Result<()> {
        if field.text.is_empty() && !field.last {
            let what = "an object without a class begins here";
            return Err(Error::input(self.file, field.line, what, "write `Class, field, field;`"));
        }
        let layout = std::str::from_utf8(field.text).ok().and_then(Layout::of_class);
        self.current = layout.map(|layout| Current {
            object: Object { layout, name: String::new(), line: field.line, fields: Vec::new(), vertices: Vec::new() },
            order: layout.order(self.version),
            coordinates: Vec::new(),
        });
        Ok(())
    }
}

impl Current {
    fn take(&mut self, file: &Path, field: &IdfField) -> Result<()> {
        let text = || String::from_utf8_lossy(field.text).into_owned();
        let layout = self.object.layout;
        match self.order.get(field.place - 1) {
            Some(&"name") => self.object.name = text(),
            // An empty field states nothing.
            Some(key) if !field.text.is_empty() => self.object.fields.push((key, Value::Text(text()))),
            None if layout.has_vertices => {
                // A list may end with blanks, but must not contain any.
                let number = std::str::from_utf8(field.text).ok().and_then(|word| word.parse::<f64>().ok());
                match number.filter(|number| number.abs() <= MAX_COORDINATE_M) {
                    Some(number) => self.coordinates.push(number),
                    None if field.text.is_empty() && field.last => {}
                    None => return Err(vertex_error(file, field.line, &self.object.title(), &text())),
                }
                if let [x, y, z] = *self.coordinates {
                    self.object.vertices.push([x, y, z]);
                    self.coordinates.clear();
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn finish(mut self, file: &Path, number: usize) -> Result<Object> {
        if !self.coordinates.is_empty() {
            let left = self.coordinates.len();
            let what = format!("{left} coordinates are left over after {} vertices", self.object.vertices.len());
            return Err(self.object.error(file, what, "give x, y and z of every vertex"));
        }
        if !self.object.layout.is_named() {
            self.object.name = format!("{} {number}", self.object.layout.class);
        }
        Ok(self.object)
    }
}

fn vertex_error(file: &Path, line: usize, title: &str, found: &str) -> Error {
    let shown = crate::text::excerpt(found.as_bytes());
    let what = format!("{title}: a coordinate is `{shown}`, not a number of at most 1e9 in size");
    Error::input(file, line, what, "write a decimal number with a point, in metres")
}
