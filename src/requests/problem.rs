//! Problems of requests and of tables. In: nothing. Out: their kinds, which a caller tells apart
//! without reading a text; and the check which fields of a request are filled.

use std::fmt;
use std::path::PathBuf;

use crate::{Group, GroupKind, Message, Piece, Row};

/// Kind of a problem, with what was found.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Problem {
    /// None of those below.
    #[default]
    Other,
    /// A field that must be filled is not.
    Missing,
    /// A field is filled beside another that excludes it.
    Excludes {
        /// Name of the other field.
        other: String,
    },
    /// A field is filled without one that it needs.
    Needs {
        /// Names of fields, each of which would do.
        others: Vec<String>,
    },
    /// A text is not of the kind that is read.
    Unreadable {
        /// The text.
        found: String,
    },
    /// A number is too small or too large.
    OutOfRange {
        /// The number.
        found: f64,
        /// Smallest number allowed.
        least: f64,
        /// Largest number allowed.
        most: f64,
    },
    /// A name is not known.
    Unknown {
        /// The name.
        found: String,
        /// Known names.
        known: Vec<String>,
    },
    /// A table lacks a column.
    NoColumn {
        /// Name of the column.
        column: String,
    },
    /// A file to write is a file to read, or another one to write.
    SameFile {
        /// The other file.
        other: PathBuf,
    },
    /// This name is given twice, or stands for two things.
    Duplicate(String),
    /// A value of a file, in a column or under a key, cannot be used.
    Value {
        /// Name of the column or the key.
        name: String,
        /// The value.
        found: String,
    },
    /// A file lacks something that the request needs: `area`, `humidity`, `scene`.
    Lacks(&'static str),
    /// A file, or what was chosen of it, holds nothing to work with.
    Empty,
    /// A point or a receiver lies where it cannot be used.
    Misplaced,
    /// The name of a file does not have the ending of its kind.
    Ending,
    /// A file is of another kind than is needed: its kind.
    OtherKind(String),
    /// A file is of this version, which is not read.
    OtherVersion(String),
    /// A file was made from other inputs, or with other settings, than it is used with.
    OtherInputs,
    /// Two files are of different sites.
    OtherSite,
    /// A file that would be replaced is there already.
    Exists,
    /// Another run writes the file.
    Busy,
    /// A file is damaged or cut off.
    Damaged,
}

impl Problem {
    /// Returns the problem of a field beside another that excludes it.
    pub fn excludes(other: &str) -> Self {
        Problem::Excludes { other: other.to_owned() }
    }

    /// Returns the problem of a field without another that it needs.
    pub fn needs(other: &str) -> Self {
        Problem::Needs { others: vec![other.to_owned()] }
    }

    /// Returns the problem of a name that is given twice.
    pub fn duplicate(found: impl Into<String>) -> Self {
        Problem::Duplicate(found.into())
    }

    /// Returns the problem of a value in a column or under a key.
    pub fn value(name: impl Into<String>, found: impl Into<String>) -> Self {
        Problem::Value { name: name.into(), found: found.into() }
    }

    /// Returns the problem of a file of another kind.
    pub fn other_kind(found: impl Into<String>) -> Self {
        Problem::OtherKind(found.into())
    }

    /// Returns the problem of a table that lacks a column.
    pub fn no_column(column: &str) -> Self {
        Problem::NoColumn { column: column.to_owned() }
    }

    /// Returns the problem of a name that is none of those known.
    pub fn unknown<'a>(found: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        Problem::Unknown { found: found.to_owned(), known: known.into_iter().map(str::to_owned).collect() }
    }

    /// Returns the name of the kind.
    pub fn name(&self) -> &'static str {
        match self {
            Problem::Other => "other",
            Problem::Missing => "missing",
            Problem::Excludes { .. } => "excludes",
            Problem::Needs { .. } => "needs",
            Problem::Unreadable { .. } => "unreadable",
            Problem::OutOfRange { .. } => "out-of-range",
            Problem::Unknown { .. } => "unknown",
            Problem::NoColumn { .. } => "no-column",
            Problem::SameFile { .. } => "same-file",
            Problem::Duplicate(_) => "duplicate",
            Problem::Value { .. } => "value",
            Problem::Lacks(_) => "lacks",
            Problem::Empty => "empty",
            Problem::Misplaced => "misplaced",
            Problem::Ending => "ending",
            Problem::OtherKind(_) => "other-kind",
            Problem::OtherVersion(_) => "other-version",
            Problem::OtherInputs => "other-inputs",
            Problem::OtherSite => "other-site",
            Problem::Exists => "exists",
            Problem::Busy => "busy",
            Problem::Damaged => "damaged",
        }
    }
}

/// Reason why a text is not the value of a field.
#[derive(Clone, Debug, PartialEq)]
pub struct Wrong {
    /// Kind of the problem.
    pub problem: Problem,
    /// Description of what is wrong; empty if the advice says it.
    pub what: String,
    /// Advice on what to give; empty if there is none.
    pub hint: String,
}

impl Wrong {
    /// Returns the reason for a name that is none of those known.
    pub fn unknown(found: &str, known: impl IntoIterator<Item = &'static str>) -> Self {
        let known: Vec<&str> = known.into_iter().collect();
        let hint = format!("give one of {}", known.join(", "));
        Wrong { problem: Problem::unknown(found, known), what: format!("`{found}` is not a known value"), hint }
    }

    /// Returns the reason with the text as what was found, unless the problem tells more.
    pub fn found(mut self, text: &str) -> Self {
        if self.problem == Problem::Other {
            self.problem = Problem::Unreadable { found: text.to_owned() };
        }
        self
    }

    /// Returns the refusal of a request whose field has this text.
    pub fn in_field(self, field: &str) -> Refused {
        let Wrong { problem, what, hint } = self;
        let or = |text: String, usual: &'static str| if text.is_empty() { usual.into() } else { Message::from(text) };
        let (what, hint) = (or(what, "cannot be used"), or(hint, "give another value"));
        Refused { fields: vec![field.to_owned()], problem, what, hint }
    }
}

/// A sentence of the form `it is 3: give 1 or 2`, or a part of it.
impl From<String> for Wrong {
    fn from(text: String) -> Self {
        let (what, hint) = match text.split_once(": give ") {
            Some((what, advice)) => (what.to_owned(), format!("give {advice}")),
            None if text.starts_with("give ") => (String::new(), text),
            None => (text, String::new()),
        };
        Wrong { problem: Problem::Other, what, hint }
    }
}

impl From<&str> for Wrong {
    fn from(what: &str) -> Self {
        what.to_owned().into()
    }
}

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let between = if self.what.is_empty() || self.hint.is_empty() { "" } else { ": " };
        write!(f, "{}{between}{}", self.what, self.hint)
    }
}

impl std::error::Error for Wrong {}

/// Refusal of a request: its field, or several fields; what is wrong; and what to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Refused {
    /// Names of the fields.
    pub fields: Vec<String>,
    /// Kind of the problem.
    pub problem: Problem,
    /// Description of what is wrong.
    pub what: Message,
    /// Advice on what to do; empty if the description says it.
    pub hint: Message,
}

/// Checks which fields are filled: those that must be, and those that exclude or need each other.
pub fn complete(rows: &[Row], groups: &[Group], filled: &[&str]) -> Result<(), Refused> {
    let refused = |fields: &[&str], problem, what: Message, hint: &'static str| {
        let fields = fields.iter().map(|&field| field.to_owned()).collect();
        Err(Refused { fields, problem, what, hint: hint.into() })
    };
    let is_filled = |name: &&str| filled.contains(name);
    let is_known = |name: &&str| rows.iter().any(|row| row.name == *name);
    let named = |field| Message::new([Piece::Field(field)]);
    for row in rows {
        if row.required && !is_filled(&row.name) {
            return refused(&[row.name], Problem::Missing, "is not given".into(), "give it too");
        }
        if !is_filled(&row.name) {
            continue;
        }
        if let Some(other) = row.conflicts.iter().find(|other| is_filled(other) && is_known(other)) {
            let what = Message::from("does not go together with ").and(named(other));
            return refused(
                &[row.name],
                Problem::Excludes { other: (*other).to_owned() },
                what,
                "leave one of the two out",
            );
        }
        let needed: Vec<&'static str> = row.requires.iter().copied().filter(|name| is_known(name)).collect();
        if !needed.is_empty() && !needed.iter().any(is_filled) {
            let all = Message::joined(needed.iter().map(|name| named(name)), " or ");
            let what = Message::from("belongs to ").and(all).and(", which is not given");
            let others = needed.iter().map(|&name| name.to_owned()).collect();
            return refused(&[row.name], Problem::Needs { others }, what, "give that too, or leave this out");
        }
    }
    for group in groups {
        let names: Vec<&'static str> = group.names.iter().copied().filter(|name| is_known(name)).collect();
        let given: Vec<&'static str> = names.iter().copied().filter(is_filled).collect();
        let (least, most) = match group.kind {
            GroupKind::ExactlyOne => (1, 1),
            GroupKind::AtMostOne => (0, 1),
            GroupKind::AnyOf => (1, usize::MAX),
        };
        if names.len() > 1 && !(least..=most).contains(&given.len()) {
            let (problem, what, hint) = match given.as_slice() {
                [_, other, ..] => (
                    Problem::Excludes { other: (*other).to_owned() },
                    "only one of them can be given",
                    "leave the others out",
                ),
                _ => (Problem::Missing, "none of them is given", "give one of them"),
            };
            return refused(&names, problem, what.into(), hint);
        }
    }
    Ok(())
}
