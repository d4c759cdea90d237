//! Failures of requests. In: errors of the core. Out: a kind, a message and a hint, for the page to
//! show.

use heliotile_core::error::Error;
use heliotile_core::text::{Message, Named};
use serde::Serialize;

/// Separator between a message of the core and its hint.
const TO_FIX: &str = "\n  to fix: ";

/// Kinds that the page tells apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    NoArchive,
    Version,
    Cut,
    Damaged,
    /// The archive lies elsewhere than the one that the page shows it with.
    OtherPlace,
    /// The host could not provide bytes; the host knows why.
    Source,
    Other,
}

/// Failure of a request.
#[derive(Debug, Serialize)]
pub struct Failure {
    pub kind: Kind,
    pub message: String,
    /// Hint about what to do; empty if the message says it.
    pub hint: String,
}

impl Failure {
    /// Makes a failure that the core does not know of.
    pub fn new(kind: Kind, message: impl Into<String>, hint: impl Into<String>) -> Self {
        Failure { kind, message: message.into(), hint: hint.into() }
    }

    /// Returns this failure with another kind.
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

/// Returns a text in the words of the page.
pub fn worded_text(text: &Message) -> String {
    text.in_words(&in_page)
}

/// Returns field names in plain words, and the program's commands for tasks that the page cannot
/// do.
fn in_page(named: Named) -> Option<String> {
    match named {
        Named::Field(field) => Some(field.replace('_', " ")),
        Named::Command(_) => None,
    }
}
