//! Work that a file may expand to. In: the length of the file, and what a reader is about to make
//! of it. Out: an error before a small file fills the memory.

use std::path::Path;

use heliotile_core::error::{Error, Result};

/// Bytes that any file may expand to.
const FREE: u64 = 512 << 20;
/// Most bytes that a byte of a file may expand to beyond that: that of a packed city becomes about
/// 20.
const TIMES: u64 = 200;
/// Most bytes that any file may expand to.
const MAX: u64 = 10 << 30;

/// Bytes of memory that instances, templates and dictionaries of one file may expand to, estimated.
#[derive(Clone, Copy, Debug)]
pub struct WorkBudget {
    most: u64,
    spent: u64,
}

impl WorkBudget {
    /// Returns the budget of a file of `length` bytes, with the files that it names.
    pub fn new(length: u64) -> Self {
        WorkBudget { most: length.saturating_mul(TIMES).clamp(FREE, MAX), spent: 0 }
    }

    /// Returns the budget of the file at `path`.
    pub fn of_file(path: &Path) -> Self {
        WorkBudget::new(std::fs::metadata(path).map_or(0, |found| found.len()))
    }

    /// Spends `count` times `each` bytes; `things` names in the error what expands.
    pub fn spend(&mut self, count: u64, each: u64, things: &str, file: &Path) -> Result<()> {
        self.spent = self.spent.saturating_add(count.saturating_mul(each));
        if self.spent <= self.most {
            return Ok(());
        }
        let what = format!(
            "its {things} expand to more than {} MiB; a file may expand to {} MiB, or {TIMES} times its length",
            self.most >> 20,
            FREE >> 20
        );
        Err(Error::input(file, None, what, "export it in parts, or without repeated use of the same parts"))
    }
}

/// Most bytes that a file read as a whole may unpack to: a machine of 16 GB can hold them and the
/// scene made of them.
const MAX_WHOLE: u64 = 4 << 30;

/// Bytes that any machine can hold: up to this size the ratio of unpacked to packed bytes is not
/// limited, beyond it to [`MAX_TIMES`].
const HARMLESS: u64 = 256 << 20;

/// Largest ratio of unpacked to packed bytes: text is usually packed to a twentieth, bombs to a
/// thousandth.
const MAX_TIMES: u64 = 200;

/// Most bytes that a file read piece by piece may unpack to: 100 million receivers are a tenth of
/// that.
pub(super) const MAX_STREAMED: u64 = 64 << 30;

/// Returns the number of bytes that `packed` bytes of a file read as a whole may unpack to.
pub(super) fn most(packed: u64) -> u64 {
    packed.saturating_mul(MAX_TIMES).clamp(HARMLESS, MAX_WHOLE)
}

/// Returns the number of bytes that `packed` bytes of a file read piece by piece may unpack to.
pub(super) fn most_streamed(packed: u64) -> u64 {
    packed.saturating_mul(MAX_TIMES).clamp(HARMLESS, MAX_STREAMED)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of 1 kB may expand to 512 MiB, one of 10 MB to 2 GB, one of 1 TB to 10
    /// GiB, and no byte more, whatever the order of its parts; the message names file and parts.
    #[test]
    fn small_files_expand_to_a_fixed_size() {
        for (length, most) in [(1000, FREE), (10_000_000, 2_000_000_000), (1_000_000_000_000, MAX)] {
            let mut budget = WorkBudget::new(length);
            budget.spend(most / 4, 3, "templates", Path::new("a.json")).expect("three quarters");
            budget.spend(1, most - most / 4 * 3, "templates", Path::new("a.json")).expect("all of it");
            let message = budget.spend(1, 1, "templates", Path::new("a.json")).expect_err("more").to_string();
            let said = format!("a.json: its templates expand to more than {} MiB", most >> 20);
            assert!(message.starts_with(&said), "{message}");
        }
        assert!(WorkBudget::new(1).spend(u64::MAX, u64::MAX, "templates", Path::new("a.json")).is_err());
    }
}
