//! What the program says besides its tables. In: sentences. Out: results on standard output, remarks that `--quiet` leaves out, warnings of
//! one line each, whose lists `--verbose` shows.

use std::borrow::Cow;
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU8, Ordering};

use crate::cli::worded_text;
use heliotile_core::error::{Error, Result};

/// How much is said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Volume {
    /// Results, warnings and errors.
    Quiet,
    /// Progress and remarks besides.
    #[default]
    Usual,
    /// Lists behind warnings besides.
    Verbose,
}

static VOLUME: AtomicU8 = AtomicU8::new(Volume::Usual as u8);

/// From now on so much is said.
pub fn set_volume(volume: Volume) {
    VOLUME.store(volume as u8, Ordering::Relaxed);
}

pub fn is_quiet() -> bool {
    VOLUME.load(Ordering::Relaxed) == Volume::Quiet as u8
}

/// Writes what was asked for to standard output; a reader that went away is no error.
pub fn say(text: &str) -> Result<()> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::io(Path::new("standard output"), "write to")(e)),
        _ => Ok(()),
    }
}

/// Says what was done, unless nobody wants to know.
pub fn remark(text: &str) -> Result<()> {
    if is_quiet() { Ok(()) } else { say(&worded_text(text)) }
}

/// The same where standard output may be a table.
pub fn remark_aside(text: &str) {
    if !is_quiet() {
        aside(&worded_text(text));
    }
}

/// Says what a user may want to know and what nothing is wrong with, beside a table.
pub fn note(text: &str) {
    remark_aside(&format!("note: {text}\n"));
}

/// Prints a warning of a command that goes on: its first line, and the list behind that if it is wanted.
pub fn warn(text: &str) {
    let verbose = VOLUME.load(Ordering::Relaxed) == Volume::Verbose as u8;
    aside(&format!("warning: {}\n", worded_text(&shortened(text, verbose))));
}

/// Writes to standard error; one that is closed must not end the work.
pub fn aside(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// The first line of a warning; all of it where lists are wanted.
fn shortened(text: &str, verbose: bool) -> Cow<'_, str> {
    match text.split_once('\n') {
        Some((first, _)) if !verbose => format!("{first} (-v lists them)").into(),
        _ => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::text::with_list;

    /// Of a warning with a list of 3 the first line is said, with a word on how to see the 3 others; a short one stays as it is.
    #[test]
    fn lists_are_for_those_who_ask() {
        let text = with_list("3 materials are odd", ["a", "b", "c"].map(String::from));
        assert_eq!(shortened(&text, false), "3 materials are odd (-v lists them)");
        assert_eq!(shortened(&text, true).lines().collect::<Vec<_>>(), ["3 materials are odd", "  a", "  b", "  c"]);
        assert_eq!(shortened("one is odd", false), "one is odd");
    }
}
