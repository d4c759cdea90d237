//! Bytes by position. In: a holder of an archive's bytes (memory, an open file, a mapping, ranges
//! of a server). Out: owned copies of ranges, so that the bytes that were checked are the bytes
//! that are used.

use std::fmt::Debug;
#[cfg(any(unix, windows))]
use std::fs::File;
use std::io;
use std::sync::Arc;

use crate::archive::format::Entry;

/// Source of a fixed number of bytes that many threads may read.
pub trait ReadAt: Debug + Send + Sync {
    /// Returns the number of bytes; it does not change.
    fn length(&self) -> u64;

    /// Fills `bytes` from a position; an error of kind `UnexpectedEof` if the source ends before.
    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()>;

    /// Returns a copy of `length` bytes from a position. The caller has made sure that they exist.
    /// A source in memory copies them into fresh memory without clearing that first.
    fn copy_at(&self, offset: u64, length: usize) -> io::Result<Vec<u8>> {
        let mut bytes = vec![0; length];
        self.read_at(offset, &mut bytes)?;
        Ok(bytes)
    }

    /// Announces blocks that will be read soon, in any order. A remote may begin to fetch them now,
    /// neighbours in one request. A source that holds the bytes already does nothing. The call
    /// never fails.
    fn expect(&self, _blocks: &[Entry]) {}

    /// Returns the stored bytes of a block. The caller has made sure that they lie inside, and
    /// checks that they are right. The entry has their checksum, by which a cache may keep copies
    /// of blocks.
    fn copy_block(&self, block: &Entry) -> io::Result<Vec<u8>> {
        self.copy_at(block.offset, usize::try_from(block.stored).map_err(|_| io::ErrorKind::UnexpectedEof)?)
    }
}

/// Returns a range of bytes in memory, or `UnexpectedEof`.
pub(super) fn range(bytes: &[u8], offset: u64, length: usize) -> io::Result<&[u8]> {
    let start = usize::try_from(offset).ok();
    let range = start.and_then(|start| Some(start..start.checked_add(length)?));
    range.and_then(|range| bytes.get(range)).ok_or_else(|| io::ErrorKind::UnexpectedEof.into())
}

impl ReadAt for Arc<[u8]> {
    fn length(&self) -> u64 {
        self.len() as u64
    }

    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        bytes.copy_from_slice(range(self, offset, bytes.len())?);
        Ok(())
    }

    fn copy_at(&self, offset: u64, length: usize) -> io::Result<Vec<u8>> {
        Ok(range(self, offset, length)?.to_vec())
    }
}

impl ReadAt for Vec<u8> {
    fn length(&self) -> u64 {
        self.len() as u64
    }

    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        bytes.copy_from_slice(range(self, offset, bytes.len())?);
        Ok(())
    }

    fn copy_at(&self, offset: u64, length: usize) -> io::Result<Vec<u8>> {
        Ok(range(self, offset, length)?.to_vec())
    }
}

/// An open file, read at positions: for files that other programs may shorten, and network file
/// systems.
#[cfg(any(unix, windows))]
#[derive(Debug)]
pub struct OpenFile {
    file: File,
    length: u64,
}

#[cfg(any(unix, windows))]
impl OpenFile {
    /// Takes the file's length now. Bytes that are added later do not count, and a file that is
    /// shortened gives errors.
    pub fn new(file: File) -> io::Result<Self> {
        let length = file.metadata()?.len();
        Ok(OpenFile { file, length })
    }
}

#[cfg(any(unix, windows))]
impl ReadAt for OpenFile {
    fn length(&self) -> u64 {
        self.length
    }

    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        read_exact_at(&self.file, bytes, offset)
    }
}

/// Fills `bytes` from a position of the file.
#[cfg(unix)]
pub fn read_exact_at(file: &File, bytes: &mut [u8], offset: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, offset)
}

/// Fills `bytes` from a position of the file.
#[cfg(windows)]
pub fn read_exact_at(file: &File, mut bytes: &mut [u8], mut offset: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        let count = std::os::windows::fs::FileExt::seek_read(file, bytes, offset)?;
        match bytes.split_at_mut_checked(count) {
            Some((_, rest)) if count > 0 => bytes = rest,
            _ => return Err(io::ErrorKind::UnexpectedEof.into()),
        }
        offset = offset.saturating_add(count as u64);
    }
    Ok(())
}
