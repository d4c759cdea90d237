//! Requests that declare their fields once. In: structs with `#[derive(Request)]`. Out: rows, from
//! which each face makes its options, keywords, types and pages; and fields filled from texts.
//!
//! A face is a way to ask: the command line, Python, the page. This crate knows none of them, reads
//! no file and computes nothing.

#![deny(missing_docs)]

#[cfg(test)]
extern crate self as heliotile_requests;

use std::num::ParseIntError;
use std::path::{Path, PathBuf};

pub use heliotile_requests_derive::Request;

/// Request of a user: a struct with defaults, whose fields faces fill.
pub trait Request {
    /// Returns the fields, those of flattened structs among them.
    fn rows() -> Vec<Row>;

    /// Returns the groups of fields that exclude or need each other, those of flattened structs
    /// among them.
    fn groups() -> Vec<Group>;

    /// Fills a field from texts. Returns false if there is no field of this name; an error says
    /// what is wrong with a text.
    fn fill(&mut self, name: &str, texts: &[String]) -> Result<bool, String>;

    /// Hands on every file that the request names.
    fn files(&self, each: &mut dyn FnMut(&'static str, Role, &Path));

    /// Returns the fields whose files are others than their kind says.
    fn skips(&self) -> Vec<&'static str> {
        Vec::new()
    }

    /// Checks what rows cannot say. An error names the field and says what is wrong.
    fn check(&self) -> Result<(), (&'static str, String)> {
        Ok(())
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
    pub help: String,
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
    pub test: fn(&str) -> Result<(), String>,
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
    /// Folder that several runs may write into.
    SharedFolder,
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
    /// Returns how values look.
    fn form() -> Form;

    /// Reads a value. An error says what is wrong and what to give.
    fn parse(text: &str) -> Result<Self, String>;

    /// Returns the file that a value names.
    fn path(&self) -> Option<&Path> {
        None
    }
}

impl Parse for String {
    fn form() -> Form {
        Form::TEXT
    }

    fn parse(text: &str) -> Result<Self, String> {
        Ok(text.to_owned())
    }
}

impl Parse for PathBuf {
    fn form() -> Form {
        Form::PATH
    }

    fn parse(text: &str) -> Result<Self, String> {
        if text.is_empty() { Err("a value is required".to_owned()) } else { Ok(text.into()) }
    }

    fn path(&self) -> Option<&Path> {
        Some(self)
    }
}

impl Parse for f64 {
    fn form() -> Form {
        Form::NUMBER
    }

    fn parse(text: &str) -> Result<Self, String> {
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(format!("`{text}` is not a number")),
        }
    }
}

macro_rules! whole_numbers {
    ($($number:ty),+) => {$(
        impl Parse for $number {
            fn form() -> Form {
                Form::WHOLE
            }

            fn parse(text: &str) -> Result<Self, String> {
                text.parse().map_err(|error: ParseIntError| error.to_string())
            }
        }
    )+};
}

whole_numbers!(u16, u32, u64, usize, i32);

/// Numbers, separated by commas.
impl<const N: usize> Parse for [f64; N] {
    fn form() -> Form {
        Form::TEXT
    }

    fn parse(text: &str) -> Result<Self, String> {
        let numbers: Vec<f64> = text.split(',').map(|part| f64::parse(part.trim())).collect::<Result<_, _>>()?;
        numbers.try_into().map_err(|_| format!("give {N} numbers, separated by commas"))
    }
}

impl<T: Parse> Parse for Box<T> {
    fn form() -> Form {
        T::form()
    }

    fn parse(text: &str) -> Result<Self, String> {
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

    fn fill(&mut self, name: &str, texts: &[String]) -> Result<bool, String> {
        self.as_mut().fill(name, texts)
    }

    fn files(&self, each: &mut dyn FnMut(&'static str, Role, &Path)) {
        self.as_ref().files(each);
    }

    fn check(&self) -> Result<(), (&'static str, String)> {
        self.as_ref().check()
    }
}

/// A name and its value, `NAME=VALUE`.
impl<T: Parse> Parse for (String, T) {
    fn form() -> Form {
        Form::TEXT
    }

    fn parse(text: &str) -> Result<Self, String> {
        let (name, value) = text.split_once('=').filter(|(name, _)| !name.is_empty()).ok_or("give NAME=VALUE")?;
        Ok((name.to_owned(), T::parse(value)?))
    }

    fn path(&self) -> Option<&Path> {
        self.1.path()
    }
}

/// Implements [`Parse`] for types that implement `FromStr` with a text as error.
#[macro_export]
macro_rules! parse_by_text {
    ($($type:ty: $form:expr),+ $(,)?) => {$(
        impl $crate::Parse for $type {
            fn form() -> $crate::Form {
                $form
            }

            fn parse(text: &str) -> ::std::result::Result<Self, ::std::string::String> {
                text.parse().map_err(|error| ::std::string::ToString::to_string(&error))
            }
        }
    )+};
}

/// Returns the last text, which counts if an option is repeated. For the derive.
pub fn last(texts: &[String]) -> Result<&str, String> {
    texts.last().map(String::as_str).ok_or_else(|| "a value is required".to_owned())
}

/// Returns the value of a flag: true without a text. For the derive.
pub fn flag(texts: &[String]) -> Result<bool, String> {
    match texts.last().map(String::as_str) {
        None | Some("true" | "True") => Ok(true),
        Some("false" | "False") => Ok(false),
        Some(other) => Err(format!("`{other}` is neither true nor false")),
    }
}

/// Returns a number within a range; `says` is the answer to any other text. For the derive.
pub fn within<T: PartialOrd + std::fmt::Display>(
    read: Result<T, String>,
    text: &str,
    range: std::ops::RangeInclusive<T>,
    says: Option<&str>,
) -> Result<T, String> {
    match read {
        Ok(number) if range.contains(&number) => Ok(number),
        _ => Err(says.map_or_else(|| format!("{text} is not in {}..={}", range.start(), range.end()), str::to_owned)),
    }
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

/// Fills the fields of a request, each with its texts. An error names the field.
pub fn filled<R: Request + Default>(given: &[(String, Vec<String>)]) -> Result<R, (String, String)> {
    let mut request = R::default();
    for (name, texts) in given {
        match request.fill(name, texts) {
            Ok(true) => {}
            Ok(false) => return Err((name.clone(), "there is no such option".to_owned())),
            Err(what) => return Err((name.clone(), what)),
        }
    }
    request.check().map_err(|(name, what)| (name.to_owned(), what))?;
    Ok(request)
}

/// Problem of a field: its name, or several names; what is wrong; and what to do. Names of other
/// fields stand in braces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Name of the field, or names with commas.
    pub field: String,
    /// Description of what is wrong.
    pub what: String,
    /// Advice on what to do.
    pub hint: &'static str,
}

/// Checks which fields are filled: those that must be, and those that exclude or need each other.
pub fn complete(rows: &[Row], groups: &[Group], filled: &[&str]) -> Result<(), Problem> {
    let problem = |field: &str, what: String, hint| Err(Problem { field: field.to_owned(), what, hint });
    let is_filled = |name: &&str| filled.contains(name);
    let is_known = |name: &&str| rows.iter().any(|row| row.name == *name);
    let listed = |names: &[&str], or: &str| {
        names.iter().filter(|name| is_known(name)).map(|name| format!("{{{name}}}")).collect::<Vec<_>>().join(or)
    };
    for row in rows {
        if row.required && !is_filled(&row.name) {
            return problem(row.name, "is not given".to_owned(), "give it too");
        }
        if !is_filled(&row.name) {
            continue;
        }
        if let Some(other) = row.conflicts.iter().find(|other| is_filled(other) && is_known(other)) {
            return problem(row.name, format!("does not go together with {{{other}}}"), "leave one of the two out");
        }
        let needed: Vec<&str> = row.requires.iter().copied().filter(|name| is_known(name)).collect();
        if !needed.is_empty() && !needed.iter().any(is_filled) {
            let what = format!("belongs to {}, which is not given", listed(&needed, " or "));
            return problem(row.name, what, "give that too, or leave this out");
        }
    }
    for group in groups {
        let names: Vec<&str> = group.names.iter().copied().filter(|name| is_known(name)).collect();
        let count = names.iter().filter(|name| is_filled(name)).count();
        let (least, most) = match group.kind {
            GroupKind::ExactlyOne => (1, 1),
            GroupKind::AtMostOne => (0, 1),
            GroupKind::AnyOf => (1, usize::MAX),
        };
        if names.len() > 1 && !(least..=most).contains(&count) {
            let (what, hint) = match count {
                0 => ("none of them is given", "give one of them"),
                _ => ("only one of them can be given", "leave the others out"),
            };
            return problem(&names.join(", "), what.to_owned(), hint);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Place.
    #[derive(Debug, Default, PartialEq, Request)]
    struct Place {
        /// Latitude, degrees
        #[field(range = -90.0..=90.0, says = "give degrees from -90 to 90", metavar = "DEGREES")]
        latitude_deg: Option<f64>,
    }

    /// A request with fields of each kind.
    #[derive(Debug, Default, PartialEq, Request)]
    #[request(at_most_one("steps", "rule"))]
    struct Asked {
        /// Weather file
        #[field(input = Weather, short = 'w', required)]
        weather: PathBuf,
        #[field(flatten, heading = "Place")]
        place: Place,
        /// Number of sun positions
        #[field(range = 1..=60)]
        steps: Option<u16>,
        /// Rules, by name
        #[field(delimiter = ',')]
        rule: Vec<String>,
        /// Leave the scene out.
        #[field(negated = "no_scene")]
        with_scene: bool,
        /// Schedules of reflectances
        #[field(input = Any, metavar = "GROUP=FILE")]
        schedule: Vec<(String, PathBuf)>,
        /// Folder to write
        #[field(output = Folder(&["receivers.csv"]), conflicts("rule"), python = "to", neutral)]
        folder: Option<PathBuf>,
        #[field(skip)]
        known: u8,
    }

    fn asked(given: &[(&str, &[&str])]) -> Result<Asked, (String, String)> {
        let text = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
        let given: Vec<_> = given.iter().map(|(name, texts)| ((*name).to_owned(), text(texts))).collect();
        filled(&given)
    }

    /// Seven rows have the names of their fields without units, their forms and roles; a flattened
    /// struct's stand under its heading.
    #[test]
    fn rows_follow_the_fields() {
        let rows = Asked::rows();
        let names: Vec<&str> = rows.iter().map(|row| row.name).collect();
        assert_eq!(names, ["weather", "latitude", "steps", "rule", "no_scene", "schedule", "folder"]);
        let [weather, latitude, steps, rule, no_scene, schedule, folder] = rows.as_slice() else { panic!("{names:?}") };
        assert_eq!((weather.short, weather.role), (Some('w'), Role::Input(InputKind::Weather)));
        assert_eq!(
            (latitude.heading, latitude.metavar, latitude.many),
            (Some("Place"), Some("DEGREES"), Many::Optional)
        );
        assert_eq!((steps.form.python, steps.role), ("int", Role::Value));
        assert_eq!((rule.many, rule.delimiter), (Many::List, Some(',')));
        assert_eq!(
            (no_scene.many, no_scene.negated, no_scene.help.as_str()),
            (Many::Flag, true, "Leave the scene out")
        );
        assert_eq!(schedule.many, Many::List);
        assert_eq!(folder.role, Role::Output(OutputKind::Folder(&["receivers.csv"])));
        assert_eq!((folder.conflicts, folder.python), (["rule"].as_slice(), Some("to")));
        assert_eq!(Asked::groups(), [Group { kind: GroupKind::AtMostOne, names: &["steps", "rule"] }]);
        assert!(weather.required && (steps.test)("61").is_err() && (steps.test)("60").is_ok());
    }

    /// Texts fill fields; files come with their roles. Five wrong texts are refused, each with its
    /// field.
    #[test]
    fn texts_fill_fields() {
        let all = asked(&[
            ("weather", &["a.epw", "b.epw"]),
            ("latitude", &["52.1"]),
            ("rule", &["one", "two"]),
            ("no_scene", &[]),
            ("schedule", &["roof=roof.csv"]),
        ]);
        let all = all.expect("a request");
        assert_eq!((all.weather.as_path(), all.place.latitude_deg), (Path::new("b.epw"), Some(52.1)));
        assert_eq!((all.rule.len(), all.with_scene, all.folder.is_none(), all.known), (2, false, true, 0));
        let mut files = Vec::new();
        all.files(&mut |name, role, path| files.push((name, role, path.to_owned())));
        let any = Role::Input(InputKind::Any);
        assert_eq!(files[0], ("weather", Role::Input(InputKind::Weather), "b.epw".into()));
        assert_eq!(files[1..], [("schedule", any, "roof.csv".into())]);
        for (name, text, says) in [
            ("latitude", "91", "give degrees from -90 to 90"),
            ("steps", "0", "0 is not in 1..=60"),
            ("steps", "two", "two is not in"),
            ("schedule", "roof", "give NAME=VALUE"),
            ("weather", "", "a value is required"),
        ] {
            let refused = asked(&[(name, &[text])]).expect_err(text);
            assert!(refused.0 == name && refused.1.contains(says), "{refused:?}");
        }
        assert_eq!(asked(&[("weathr", &["a"])]).expect_err("misspelt").0, "weathr");
    }

    /// Two of 5 sets of filled fields are complete: the others lack what is required, or name two
    /// fields that exclude each other.
    #[test]
    fn fields_exclude_and_need_each_other() {
        let complete =
            |filled: &[&str]| complete(&Asked::rows(), &Asked::groups(), filled).map_err(|problem| problem.field);
        assert_eq!(complete(&["weather"]), Ok(()));
        assert_eq!(complete(&["weather", "rule", "latitude"]), Ok(()));
        assert_eq!(complete(&["rule"]), Err("weather".to_owned()));
        assert_eq!(complete(&["weather", "rule", "folder"]), Err("folder".to_owned()));
        assert_eq!(complete(&["weather", "rule", "steps"]), Err("steps, rule".to_owned()));
    }
}
