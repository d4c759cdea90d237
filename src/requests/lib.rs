//! Requests that declare their fields once. In: structs with `#[derive(Request)]`. Out: rows, from
//! which each face makes its options, keywords, types and pages; and fields filled from texts.
//!
//! A face is a way to ask: the command line, Python, the page. This crate knows none of them, reads
//! no file and computes nothing.

#![deny(missing_docs)]

mod message;
mod problem;
#[cfg(test)]
mod tests;

#[cfg(test)]
extern crate self as heliotile_requests;

use std::num::ParseIntError;
use std::path::{Path, PathBuf};

pub use heliotile_requests_derive::{DefaultRequest, Request, message};
pub use message::{Message, Named, Piece, Words};
pub use problem::{Problem, Refused, Wrong, complete};

/// Request of a user: a struct with defaults, whose fields faces fill.
pub trait Request {
    /// Returns the fields, those of flattened structs among them.
    fn rows() -> Vec<Row>;

    /// Returns the groups of fields that exclude or need each other, those of flattened structs
    /// among them.
    fn groups() -> Vec<Group>;

    /// Fills a field from texts. Returns false if there is no field of this name; an error says
    /// what is wrong with a text.
    fn fill(&mut self, name: &str, texts: &[String]) -> Result<bool, Wrong>;

    /// Refuses a number outside of the range of its field, however the request was filled.
    fn in_range(&self) -> Result<(), Refused> {
        Ok(())
    }

    /// Hands on every file that the request names.
    fn files(&self, each: &mut dyn FnMut(&'static str, Role, &Path));

    /// Returns the fields whose files are others than their kind says.
    fn skips(&self) -> Vec<&'static str> {
        Vec::new()
    }
}

/// A field as faces show it.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name, which options and provenance share.
    pub name: &'static str,
    /// Name in Python, if it is another.
    pub python: Option<&'static str>,
    /// Letter of a short option.
    pub short: Option<char>,
    /// Placeholder of the value, if it is not the name in capital letters.
    pub metavar: Option<&'static str>,
    /// Explanation of the field.
    pub help: Message,
    /// Heading above the field and its neighbours.
    pub heading: Option<&'static str>,
    /// Effect of the field on results and files.
    pub role: Role,
    /// How values look.
    pub form: Form,
    /// Number of values.
    pub many: Many,
    /// Text of the default value.
    pub default: Option<String>,
    /// True if there is no default.
    pub required: bool,
    /// True if the value needs no option in front of it.
    pub positional: bool,
    /// True if giving the flag makes the field false.
    pub negated: bool,
    /// Separator of values within a text.
    pub delimiter: Option<char>,
    /// True if several values may stand behind one option.
    pub several: bool,
    /// True if values may begin with a dash.
    pub hyphen: bool,
    /// Fields, one of which must be filled too.
    pub requires: &'static [&'static str],
    /// Fields that must not be filled too.
    pub conflicts: &'static [&'static str],
    /// Says what is wrong with a text.
    pub test: fn(&str) -> Result<(), Wrong>,
}

impl Row {
    /// Returns the name in Python. A flag that switches something off, such as `no_ground`, is
    /// there the thing itself, `ground=False`.
    pub fn in_python(&self) -> &'static str {
        self.python.unwrap_or_else(|| self.name.strip_prefix("no_").filter(|_| self.is_off()).unwrap_or(self.name))
    }

    /// Returns true for a flag that switches something off.
    pub fn is_off(&self) -> bool {
        self.many == Many::Flag && self.name.starts_with("no_")
    }

    /// Returns the texts of the default value, each of them alone.
    pub fn default_texts(&self) -> Option<Vec<String>> {
        let text = self.default.as_deref()?;
        Some(match self.delimiter.filter(|_| self.many == Many::List) {
            Some(delimiter) => text.split(delimiter).map(str::to_owned).collect(),
            None => vec![text.to_owned()],
        })
    }

    /// Returns true if results state the field.
    pub fn is_stated(&self) -> bool {
        matches!(self.role, Role::Value | Role::Input(_))
    }
}

/// Effect of a field on results and files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Changes values: part of the provenance.
    Value,
    /// File that is read: part of the provenance, and never overwritten.
    Input(InputKind),
    /// File that is written: none of the inputs, and no part of the provenance.
    Output(OutputKind),
    /// Changes what it costs, or how results look: no part of the provenance.
    Neutral,
}

/// Kind of a file that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputKind {
    /// File of a scene.
    Scene,
    /// Archive, atlas, or file of a scene.
    SceneOrArchive,
    /// Archive or atlas, a path or an address.
    Archive,
    /// Weather file.
    Weather,
    /// Table of receivers.
    Receivers,
    /// Table of conditions.
    Conditions,
    /// Any file: its reader decides.
    Any,
}

/// Kind of a file or folder that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputKind {
    /// Archive.
    Archive,
    /// Table, in the format of its ending.
    Table,
    /// Table or map, in the format of its ending.
    Results,
    /// Table as CSV.
    Csv,
    /// Any other file.
    File,
    /// Folder of one run, with names of tables that it writes there.
    Folder(&'static [&'static str]),
}

/// Number of values of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Many {
    /// One value.
    One,
    /// One value or none.
    Optional,
    /// Any number of values.
    List,
    /// None: the field is true or false.
    Flag,
}

/// Fields that exclude or need each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Group {
    /// Rule for them.
    pub kind: GroupKind,
    /// Their names.
    pub names: &'static [&'static str],
}

/// Rule for a group of fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroupKind {
    /// One of them must be filled, and no other.
    ExactlyOne,
    /// No more than one may be filled.
    AtMostOne,
    /// One or several must be filled.
    AnyOf,
}

/// How values of a type look in every face.
#[derive(Clone, Copy, Debug)]
pub struct Form {
    /// Type in Python.
    pub python: &'static str,
    /// True for numbers, which may be negative.
    pub is_number: bool,
    /// Names and meanings of the only values there are; empty: any that can be read.
    pub choices: fn() -> Vec<(&'static str, &'static str)>,
}

impl Form {
    /// Form of a field that is true or false.
    pub const FLAG: Form = Form { python: "bool", is_number: false, choices: Vec::new };
    /// Form of a text.
    pub const TEXT: Form = Form { python: "str", is_number: false, choices: Vec::new };
    /// Form of a path.
    pub const PATH: Form = Form { python: "str | os.PathLike[str]", is_number: false, choices: Vec::new };
    /// Form of a whole number.
    pub const WHOLE: Form = Form { python: "int", is_number: true, choices: Vec::new };
    /// Form of a number.
    pub const NUMBER: Form = Form { python: "float", is_number: true, choices: Vec::new };
}

/// A type whose values are read from texts.
pub trait Parse: Sized {
    /// Returns how values look: as texts, unless a type says otherwise.
    fn form() -> Form {
        Form::TEXT
    }

    /// Reads a value. An error says what is wrong and what to give.
    fn parse(text: &str) -> Result<Self, Wrong>;

    /// Returns the file that a value names.
    fn path(&self) -> Option<&Path> {
        None
    }
}

impl Parse for String {
    fn parse(text: &str) -> Result<Self, Wrong> {
        Ok(text.to_owned())
    }
}

impl Parse for PathBuf {
    fn form() -> Form {
        Form::PATH
    }

    fn parse(text: &str) -> Result<Self, Wrong> {
        if text.is_empty() { Err("a value is required".into()) } else { Ok(text.into()) }
    }

    fn path(&self) -> Option<&Path> {
        Some(self)
    }
}

impl Parse for f64 {
    fn form() -> Form {
        Form::NUMBER
    }

    fn parse(text: &str) -> Result<Self, Wrong> {
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(unreadable(text, format!("`{text}` is not a number"))),
        }
    }
}

macro_rules! whole_numbers {
    ($($number:ty),+) => {$(
        impl Number for $number {
            fn as_f64(&self) -> f64 {
                *self as f64
            }
        }

        impl Parse for $number {
            fn form() -> Form {
                Form::WHOLE
            }

            fn parse(text: &str) -> Result<Self, Wrong> {
                text.parse().map_err(|error: ParseIntError| unreadable(text, error.to_string()))
            }
        }
    )+};
}

whole_numbers!(u16, u32, u64, usize, i32);

/// Numbers, separated by commas.
impl<const N: usize> Parse for [f64; N] {
    fn parse(text: &str) -> Result<Self, Wrong> {
        let numbers: Vec<f64> = text.split(',').map(|part| f64::parse(part.trim())).collect::<Result<_, _>>()?;
        numbers.try_into().map_err(|_| unreadable(text, format!("give {N} numbers, separated by commas")))
    }
}

impl<T: Parse> Parse for Box<T> {
    fn form() -> Form {
        T::form()
    }

    fn parse(text: &str) -> Result<Self, Wrong> {
        T::parse(text).map(Box::new)
    }

    fn path(&self) -> Option<&Path> {
        self.as_ref().path()
    }
}

impl<R: Request> Request for Box<R> {
    fn rows() -> Vec<Row> {
        R::rows()
    }

    fn groups() -> Vec<Group> {
        R::groups()
    }

    fn fill(&mut self, name: &str, texts: &[String]) -> Result<bool, Wrong> {
        self.as_mut().fill(name, texts)
    }

    fn in_range(&self) -> Result<(), Refused> {
        self.as_ref().in_range()
    }

    fn files(&self, each: &mut dyn FnMut(&'static str, Role, &Path)) {
        self.as_ref().files(each);
    }
}

/// A name and its value, `NAME=VALUE`.
impl<T: Parse> Parse for (String, T) {
    fn parse(text: &str) -> Result<Self, Wrong> {
        let (name, value) = text.split_once('=').filter(|(name, _)| !name.is_empty()).ok_or("give NAME=VALUE")?;
        Ok((name.to_owned(), T::parse(value)?))
    }

    fn path(&self) -> Option<&Path> {
        self.1.path()
    }
}

/// Implements [`Parse`] for types that implement `FromStr` with an error that becomes [`Wrong`]; a
/// function behind `=>` returns the file that a value names.
#[macro_export]
macro_rules! parse_by_text {
    ($($type:ty: $form:expr $(=> $file:path)?),+ $(,)?) => {$(
        impl $crate::Parse for $type {
            fn form() -> $crate::Form {
                $form
            }

            fn parse(text: &str) -> ::std::result::Result<Self, $crate::Wrong> {
                text.parse().map_err(::std::convert::Into::into)
            }

            $(fn path(&self) -> ::std::option::Option<&::std::path::Path> {
                $file(self)
            })?
        }
    )+};
}

/// Returns the last text, which counts if an option is repeated. For the derive.
pub fn last(texts: &[String]) -> Result<&str, Wrong> {
    texts.last().map(String::as_str).ok_or_else(|| "a value is required".into())
}

/// Returns the value of a flag: true without a text. For the derive.
pub fn flag(texts: &[String]) -> Result<bool, Wrong> {
    match texts.last().map(String::as_str) {
        None | Some("true" | "True") => Ok(true),
        Some("false" | "False") => Ok(false),
        Some(other) => Err(unreadable(other, format!("`{other}` is neither true nor false"))),
    }
}

/// Returns a number within a range; `says` is the advice for any other text. For the derive.
pub fn within<T: Number>(
    read: Result<T, Wrong>,
    text: &str,
    range: std::ops::RangeInclusive<T>,
    says: Option<&str>,
) -> Result<T, Wrong> {
    let (least, most) = (range.start(), range.end());
    let problem = match read {
        Ok(number) if range.contains(&number) => return Ok(number),
        Ok(number) => Problem::OutOfRange { found: number.as_f64(), least: least.as_f64(), most: most.as_f64() },
        // The reader of the type says more than a range.
        Err(wrong) if !wrong.hint.is_empty() => return Err(wrong),
        Err(wrong) => wrong.problem,
    };
    let hint = says.unwrap_or_default().to_owned();
    Err(Wrong { problem, what: format!("{text} is not in {least}..={most}"), hint })
}

/// Number with a range.
pub trait Number: PartialOrd + std::fmt::Display {
    /// Returns the number as `f64`.
    fn as_f64(&self) -> f64;
}

impl Number for f64 {
    fn as_f64(&self) -> f64 {
        *self
    }
}

fn unreadable(text: &str, what: String) -> Wrong {
    Wrong { problem: Problem::Unreadable { found: text.to_owned() }, ..what.into() }
}

/// How a struct shows the rows of a flattened one. For the derive.
pub struct Under<'a> {
    /// Heading of the rows.
    pub heading: Option<&'static str>,
    /// Names of rows that are left out.
    pub without: &'a [&'a str],
    /// Names of rows, and the texts of their defaults.
    pub defaults: &'a [(&'a str, &'a str)],
    /// Fields, one of which must be filled with any of the rows.
    pub needs: &'static [&'static str],
}

/// Returns the rows of a flattened struct. For the derive.
pub fn under<R: Request>(under: Under) -> Vec<Row> {
    let mut rows = R::rows();
    rows.retain(|row| !under.without.contains(&row.name));
    for row in &mut rows {
        row.heading = under.heading.or(row.heading);
        let other = under.defaults.iter().find(|(name, _)| *name == row.name);
        row.default = other.map(|(_, text)| (*text).to_owned()).or(row.default.take());
        if !under.needs.is_empty() {
            row.requires = under.needs;
        }
    }
    rows
}

/// Returns the groups of a flattened struct; one that has lost a field says nothing any more. For
/// the derive.
pub fn groups_under<R: Request>(without: &[&str]) -> Vec<Group> {
    let mut groups = R::groups();
    groups.retain(|group| !group.names.iter().any(|name| without.contains(name)));
    groups
}

/// Fills the fields of a request, each with its texts.
pub fn filled<R: Request + Default>(given: &[(String, Vec<String>)]) -> Result<R, Refused> {
    let mut request = R::default();
    for (name, texts) in given {
        match request.fill(name, texts) {
            Ok(true) => {}
            Ok(false) => {
                let problem = Problem::unknown(name, R::rows().iter().map(|row| row.name));
                return Err(Wrong { problem, ..Wrong::from("there is no such option") }.in_field(name));
            }
            Err(wrong) => return Err(wrong.in_field(name)),
        }
    }
    Ok(request)
}
