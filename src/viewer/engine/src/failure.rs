//! Why a request could not be answered. In: errors of the core. Out: what the page needs to say so:
//! a kind, a message, what to do.

use heliotile_core::error::Error;
use heliotile_core::text::{Named, with_fields};
use serde::Serialize;

/// What stands between a message of the core and its hint.
const TO_FIX: &str = "\n  to fix: ";

/// Kinds that the page tells apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    NoArchive,
    Version,
    Cut,
    Damaged,
    /// The archive lies elsewhere than the one that it is to be shown with.
    OtherPlace,
    /// Bytes could not be had; the host knows why.
    Source,
    Other,
}

/// A failure.
#[derive(Debug, Serialize)]
pub struct Failure {
    pub kind: Kind,
    pub message: String,
    /// What to do; empty where the message says it.
    pub hint: String,
}

impl Failure {
    /// One that the core does not know of.
    pub fn new(kind: Kind, message: impl Into<String>, hint: impl Into<String>) -> Self {
        Failure { kind, message: message.into(), hint: hint.into() }
    }

    /// The same error, of another kind.
    pub fn of_kind(self, kind: Kind) -> Self {
        Failure { kind, ..self }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let kind = match &error {
            Error::Corrupt { .. } | Error::Defect { .. } => Kind::Damaged,
            Error::Io { .. } => Kind::Source,
            _ => Kind::Other,
        };
        let text = error.in_words(&in_page).to_string();
        match text.split_once(TO_FIX) {
            Some((message, hint)) => Failure::new(kind, message, hint),
            None => Failure::new(kind, text, ""),
        }
    }
}

/// A text in the words of the page.
pub fn worded_text(text: &str) -> String {
    with_fields(text, &in_page)
}

/// Names as people say them, and the program for what the page cannot do.
fn in_page(named: Named) -> Option<String> {
    Some(match named {
        Named::Field(field) => field.replace('_', " "),
        Named::Command(command) => format!("heliotile {}", command.replace('_', " --")),
    })
}
