//! Messages of the program besides its tables. In: sentences. Out: results on standard output,
//! remarks that `--quiet` leaves out, and last of all warnings and notes of one line each, whose
//! lists `--verbose` shows.

use std::borrow::Cow;
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::cli::worded_text;
use heliotile::text::Message;
use heliotile::{Error, Result};

/// Amount of messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Volume {
    /// Results, warnings and errors.
    Quiet,
    /// Also progress, remarks and notes.
    #[default]
    Usual,
    /// Also the details of the work and the lists behind warnings.
    Verbose,
}

static VOLUME: AtomicU8 = AtomicU8::new(Volume::Usual as u8);

/// Warnings and notes that wait for the results of the command.
static WAITING: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Sets the amount of messages for the whole program.
pub fn set_volume(volume: Volume) {
    VOLUME.store(volume as u8, Ordering::Relaxed);
}

pub fn is_quiet() -> bool {
    VOLUME.load(Ordering::Relaxed) == Volume::Quiet as u8
}

pub fn is_verbose() -> bool {
    VOLUME.load(Ordering::Relaxed) == Volume::Verbose as u8
}

/// Writes a result to standard output; a reader that has closed it is no error.
pub fn say(text: &str) -> Result<()> {
    match std::io::stdout().lock().write_all(visible(text).as_bytes()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::io(Path::new("standard output"), "write to")(e)),
        _ => Ok(()),
    }
}

/// Writes a remark on what was done to standard output, unless `--quiet` is given.
pub fn remark(text: impl Into<Message>) -> Result<()> {
    if is_quiet() { Ok(()) } else { say(&worded_text(&text.into())) }
}

/// Writes a remark to standard error, for commands whose standard output may be a table, unless
/// `--quiet` is given.
pub fn remark_aside(text: impl Into<Message>) {
    if !is_quiet() {
        aside(&worded_text(&text.into()));
    }
}

/// Keeps a note for the end of the command, unless `--quiet` is given: a fact that the user may
/// want to know and that is no problem.
pub fn note(text: impl Into<Message>) {
    if !is_quiet() {
        keep("note", &text.into());
    }
}

/// Keeps a warning for the end of the command: its first line, and with `--verbose` the list behind
/// it.
pub fn warn(text: impl Into<Message>) {
    keep("warning", &text.into());
}

/// Keeps a line for the end of the command, once.
fn keep(kind: &str, text: &Message) {
    let line = format!("{kind}: {}\n", shortened(&worded_text(text), is_verbose()));
    let mut waiting = WAITING.lock().unwrap_or_else(PoisonError::into_inner);
    if !waiting.contains(&line) {
        waiting.push(line);
    }
}

/// Writes the warnings, then the notes, to standard error, each kind in its order.
pub fn tell_waiting() {
    let mut lines = std::mem::take(&mut *WAITING.lock().unwrap_or_else(PoisonError::into_inner));
    lines.sort_by_key(|line| line.starts_with("note: "));
    aside(&lines.concat());
}

/// Writes to standard error; a closed one must not end the work.
pub fn aside(text: &str) {
    let _ = std::io::stderr().lock().write_all(visible(text).as_bytes());
}

/// Returns a text without control characters but ends of lines and tabs: names come from files of
/// strangers, and a terminal would obey their escape sequences.
fn visible(text: &str) -> Cow<'_, str> {
    let is_hidden = |c: char| c.is_control() && c != '\n' && c != '\t';
    if text.contains(is_hidden) { text.replace(is_hidden, "\u{fffd}").into() } else { text.into() }
}

/// Returns the first line of a warning, or with `verbose` all of it.
fn shortened(text: &str, verbose: bool) -> Cow<'_, str> {
    match text.split_once('\n') {
        Some((first, _)) if !verbose => format!("{first} (-v lists them)").into(),
        _ => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile::text::with_list;

    /// A text with 9 control characters keeps the tab and the end of its line; all others are
    /// replaced.
    #[test]
    fn control_characters_do_not_reach_the_terminal() {
        let text = "\u{1b}]0;title\u{7}\u{1b}[2J\u{9b}31m\ta\r\u{7f}\0\n";
        assert_eq!(text.chars().filter(|c| c.is_control()).count(), 9);
        let shown = visible(text);
        assert_eq!(shown.chars().filter(|c| c.is_control()).collect::<String>(), "\t\n");
        assert_eq!(shown.matches('\u{fffd}').count(), 7);
        assert_eq!(visible("a\tb\n"), "a\tb\n");
    }

    /// A warning with a list of 3 is printed as its first line, with a hint how to see the list; a
    /// short one stays as it is.
    #[test]
    fn lists_are_printed_only_with_verbose() {
        let text = with_list("3 materials are odd", ["a", "b", "c"].map(String::from));
        assert_eq!(shortened(&text.plain(), false), "3 materials are odd (-v lists them)");
        assert_eq!(
            shortened(&text.plain(), true).lines().collect::<Vec<_>>(),
            ["3 materials are odd", "  a", "  b", "  c"]
        );
        assert_eq!(shortened("one is odd", false), "one is odd");
    }
}
