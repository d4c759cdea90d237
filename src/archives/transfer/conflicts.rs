//! Conflicts between two archives. In: conflicts one by one. Out: an error with their number and
//! the first few by name.

use std::path::Path;

use heliotile_core::error::{Error, Result};
use heliotile_core::text::counted;

/// Largest number of names in a message.
const NAMED: usize = 10;

/// Conflicts of a merge.
#[derive(Debug, Default)]
pub struct Conflicts {
    names: Vec<String>,
    count: u64,
}

impl Conflicts {
    pub fn add(&mut self, name: impl FnOnce() -> String) {
        self.count += 1;
        if self.names.len() < NAMED {
            self.names.push(name());
        }
    }

    /// Returns an error that lists the conflicts, if there are any.
    pub fn check(&self, first: &Path, second: &Path) -> Result<()> {
        if self.count == 0 {
            return Ok(());
        }
        let what =
            format!("cannot be merged with {}: {}", first.display(), listed(self.count, "conflict", &self.names));
        let hint = "see `{command:archive diff}`; build one of the two again, or leave receivers out with `{command:archive extract}`";
        Err(Error::input(second, None, what, hint))
    }
}

/// Formats `12 receivers: a, b, ...`; names may be fewer than the count.
pub fn listed(count: u64, thing: &str, names: &[String]) -> String {
    let more = if count > names.len() as u64 { ", ..." } else { "" };
    format!("{}: {}{more}", counted(count, thing), names.join(", "))
}
