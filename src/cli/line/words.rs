//! The words of the command line: those of the process, or those that another program runs it with.

use std::ffi::OsString;
use std::sync::OnceLock;

static GIVEN: OnceLock<Vec<OsString>> = OnceLock::new();

/// Takes words in place of the process' own, the program's name first; only the first ones that are given count.
pub fn give(words: Vec<OsString>) {
    GIVEN.get_or_init(|| words);
}

/// The words, the program's name first.
pub fn words() -> Vec<OsString> {
    GIVEN.get().cloned().unwrap_or_else(|| std::env::args_os().collect())
}
