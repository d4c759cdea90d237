//! Bytes by position. In: what holds an archive's bytes (memory, an open file, a mapping, ranges of a server). Out: owned copies of
//! ranges, so that what was checked is what is used.

use std::fmt::Debug;
#[cfg(any(unix, windows))]
use std::fs::File;
use std::io;
use std::sync::Arc;

use crate::archive::format::Entry;

/// Bytes of a fixed number that many threads may read.
pub trait ReadAt: Debug + Send + Sync {
    /// Number of bytes; it does not change.
    fn length(&self) -> u64;

    /// Fills `bytes` from a position; an error of kind `UnexpectedEof` if there are not as many.
    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()>;

    /// A copy of `length` bytes from a position, for which the caller has made sure that they exist. What holds its bytes in memory
    /// copies them into fresh memory without clearing that first.
    fn copy_at(&self, offset: u64, length: usize) -> io::Result<Vec<u8>> {
        let mut bytes = vec![0; length];
        self.read_at(offset, &mut bytes)?;
        Ok(bytes)
    }

    /// Blocks that will be read soon, in any order: who fetches from afar may begin now and ask for neighbours at once. Nothing fails
    /// here, and who holds the bytes already does nothing.
    fn expect(&self, _blocks: &[Entry]) {}

    /// The stored bytes of a block, for which the caller has made sure that they are inside. Whether they are right is for the caller to
    /// check: an entry has their checksum, by which others may keep copies of blocks.
    fn copy_block(&self, block: &Entry) -> io::Result<Vec<u8>> {
        self.copy_at(block.offset, usize::try_from(block.stored).map_err(|_| io::ErrorKind::UnexpectedEof)?)
    }
}

/// A range of bytes in memory, or `UnexpectedEof`.
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

/// An open file, read at positions: for files that others may shorten, and network file systems.
#[cfg(any(unix, windows))]
#[derive(Debug)]
pub struct OpenFile {
    file: File,
    length: u64,
}

#[cfg(any(unix, windows))]
impl OpenFile {
    /// Takes the file's length now; bytes beyond it do not count, and a file that is shortened gives errors.
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
