//! Spill: sorting of records that do not fit in memory. In: byte records in any order. Out: the
//! same records by key, read one after the other, as often as wanted.
//!
//! Runs that exceed the budget go to unnamed temporary files. The operating system removes them
//! when the program ends, even after a crash. Replay uses such files, too, for what it cannot keep
//! in memory. The module does not interpret the records.

mod batch;
mod merge;
mod run;
mod scratch;
mod sorter;

pub use merge::Sorted;
pub use scratch::{SystemTemp, TempFiles};
pub use sorter::Sorter;

use std::io;
use std::path::Path;

use heliotile_core::error::Error;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::units::Bytes;

/// Returns the memory of this machine, bytes; `None` where no `/proc/meminfo` states it.
fn machine_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let kibibytes = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?.trim().strip_suffix(" kB")?;
    kibibytes.parse::<u64>().ok()?.checked_mul(1024)
}

/// Fails with a sentence if a budget is more than the memory of this machine: lists are sized by
/// their budget, and the system would end the program. The default is never refused.
pub fn check_memory(budget: Bytes) -> Result<Bytes, String> {
    match machine_memory() {
        Some(most) if budget.0 > most.max(MemoryBudget::DEFAULT.total()) => {
            Err(format!("this machine has {:.1} GiB: give at most that", most as f64 / f64::from(1 << 30)))
        }
        _ => Ok(budget),
    }
}

/// Least memory, bytes: less leaves no room for a tile.
const MIN_MEMORY: u64 = 64 << 20;

/// Reads the memory to work in, at most that of this machine.
pub fn parse_memory(text: &str) -> Result<MemoryBudget, String> {
    match text.parse()? {
        Bytes(bytes) if bytes < MIN_MEMORY => Err("give at least 64MiB".into()),
        bytes => check_memory(bytes).map(MemoryBudget::from),
    }
}

/// Returns the error for a record that cannot be read back: the temporary file in `folder` is
/// damaged.
pub fn damaged(folder: &Path) -> Error {
    Error::io(folder, "read a temporary file in")(io::ErrorKind::InvalidData.into())
}

/// Reads a number that was pushed as eight bytes.
pub fn number_of(payload: &[u8], folder: &Path) -> heliotile_core::error::Result<u64> {
    payload.try_into().map(u64::from_le_bytes).map_err(|_| damaged(folder))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 64 MiB and the default are fine on every machine, and 2^60 bytes on none that states its
    /// memory.
    #[test]
    fn more_memory_than_the_machine_has_is_refused() {
        assert_eq!(check_memory(Bytes(64 << 20)), Ok(Bytes(64 << 20)));
        assert!(check_memory(Bytes(MemoryBudget::DEFAULT.total())).is_ok());
        assert_eq!(check_memory(Bytes(1 << 60)).is_err(), machine_memory().is_some());
        assert!(!cfg!(target_os = "linux") || machine_memory().is_some_and(|bytes| bytes > 64 << 20));
    }
}
