//! Temporary storage for values that need not stay in memory. In: bytes by position. Out: the bytes
//! again. The caller of the engine chooses where it lies; [`InMemory`] keeps it in memory.

use std::fmt::Debug;
use std::sync::{PoisonError, RwLock};

use crate::error::{Error, Result};

/// Temporary storage of bytes by position. Its bytes are gone when it is dropped. Many threads may
/// use it at once.
pub trait Scratch: Send + Sync {
    /// Writes all bytes at a position. Bytes before the position that were not written yet are
    /// zero.
    fn write(&self, offset: u64, bytes: &[u8]) -> Result<()>;

    /// Fills `bytes` from a position; all of them must have been written.
    fn read(&self, offset: u64, bytes: &mut [u8]) -> Result<()>;
}

/// Place where temporary storage is made.
pub trait ScratchSpace: Debug + Sync {
    /// Returns new, empty storage.
    fn scratch(&self) -> Result<Box<dyn Scratch>>;
}

/// Temporary storage in memory, for programs without a file system. Bytes that a memory budget
/// sends there still take memory.
#[derive(Clone, Copy, Debug, Default)]
pub struct InMemory;

impl ScratchSpace for InMemory {
    fn scratch(&self) -> Result<Box<dyn Scratch>> {
        Ok(Box::new(MemoryScratch::default()))
    }
}

#[derive(Default)]
struct MemoryScratch {
    bytes: RwLock<Vec<u8>>,
}

impl Scratch for MemoryScratch {
    fn write(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        // A thread that panicked while it held the lock has left whole bytes, because bytes are
        // only copied.
        let mut all = self.bytes.write().unwrap_or_else(PoisonError::into_inner);
        let (start, end) = range(offset, bytes.len())?;
        if all.len() < end {
            let more = end - all.len();
            all.try_reserve(more).map_err(|_| too_much(offset, bytes.len()))?;
            all.resize(end, 0);
        }
        all[start..end].copy_from_slice(bytes);
        Ok(())
    }

    fn read(&self, offset: u64, bytes: &mut [u8]) -> Result<()> {
        let all = self.bytes.read().unwrap_or_else(PoisonError::into_inner);
        let (start, end) = range(offset, bytes.len())?;
        let held = all.get(start..end).ok_or_else(|| Error::Limit {
            what: "end of a read from temporary storage".into(),
            value: end as u64,
            max: all.len() as u64,
        })?;
        bytes.copy_from_slice(held);
        Ok(())
    }
}

fn range(offset: u64, length: usize) -> Result<(usize, usize)> {
    let start = usize::try_from(offset).ok();
    let range = start.and_then(|start| Some((start, start.checked_add(length)?)));
    range.filter(|&(_, end)| isize::try_from(end).is_ok()).ok_or_else(|| too_much(offset, length))
}

/// Returns the error for more bytes than there are addresses or memory.
fn too_much(offset: u64, length: usize) -> Error {
    Error::Limit {
        what: "size of the temporary storage in memory, in bytes,".into(),
        value: offset.saturating_add(length as u64),
        max: isize::MAX as u64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 200 pieces of 7 bytes that are written in reverse order come back, and skipped bytes are 0.
    /// It is an error to read one byte too far and to write at 2^64 - 4.
    #[test]
    fn bytes_written_in_any_order_come_back() {
        let scratch = InMemory.scratch().expect("memory");
        for piece in (0..200_u8).rev() {
            scratch.write(u64::from(piece) * 10, &[piece; 7]).expect("written");
        }
        let mut bytes = [9; 1997];
        scratch.read(0, &mut bytes).expect("read");
        for (i, byte) in bytes.iter().enumerate() {
            assert_eq!(usize::from(*byte), if i % 10 < 7 { i / 10 } else { 0 });
        }
        assert!(scratch.read(1, &mut bytes).is_err());
        assert!(scratch.write(u64::MAX - 3, &[1; 2]).is_err());
        assert!(scratch.write(u64::MAX - 3, &[1; 9]).is_err());
    }
}
