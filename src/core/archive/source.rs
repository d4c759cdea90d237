//! Bytes of a file, by position. In: a path or an open file. Out: owned copies of ranges. The only `unsafe` of the crate.
//!
//! Everything is copied out, so no reference into a mapping lives longer than a copy, and what was checked is what is used.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

use memmap2::Mmap;

use crate::error::{Error, Result};

/// How an archive is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Access {
    /// Through a mapping: fastest once the file is in memory
    #[default]
    Mapped,
    /// By reads at a position: for files that others may shorten, and network file systems
    Read,
}

/// A file of fixed length.
#[derive(Debug)]
pub struct Source {
    path: Arc<Path>,
    file: File,
    map: Option<Mmap>,
    length: u64,
}

impl Source {
    /// Opens a file for reading; its length is taken now and does not change.
    pub fn open(path: &Path, access: Access) -> Result<Self> {
        let file = File::open(path).map_err(Error::io(path, "open"))?;
        let about = file.metadata().map_err(Error::io(path, "read the length of"))?;
        if !about.is_file() {
            return Err(Error::input(path, None, "is not a file", "name an archive, such as site.helio"));
        }
        let map = match access {
            Access::Mapped if about.len() > 0 => Some(map(&file).map_err(Error::io(path, "map"))?),
            _ => None,
        };
        Ok(Source { path: Arc::from(path), file, map, length: about.len() })
    }

    pub fn path(&self) -> &Arc<Path> {
        &self.path
    }

    pub fn length(&self) -> u64 {
        self.length
    }

    /// A copy of `length` bytes at `offset`. Nothing is allocated for a range that is not inside the file.
    pub fn read(&self, offset: u64, length: u64) -> Result<Vec<u8>> {
        self.copy(offset, length).map_err(Error::io(&self.path, "read"))
    }

    fn copy(&self, offset: u64, length: u64) -> io::Result<Vec<u8>> {
        let outside = || io::Error::from(io::ErrorKind::UnexpectedEof);
        let end = offset.checked_add(length).filter(|&end| end <= self.length).ok_or_else(outside)?;
        if let Some(map) = &self.map {
            let range = usize::try_from(offset).ok().zip(usize::try_from(end).ok());
            let bytes = range.and_then(|(start, end)| map.get(start..end)).ok_or_else(outside)?;
            return Ok(bytes.to_vec());
        }
        let mut bytes = vec![0; usize::try_from(length).map_err(|_| outside())?];
        read_exact_at(&self.file, &mut bytes, offset)?;
        Ok(bytes)
    }
}

/// Maps a whole file for reading.
#[allow(unsafe_code)]
fn map(file: &File) -> io::Result<Mmap> {
    // SAFETY: the mapping must not change or shrink while a reference into it lives. Archives are published by rename and
    // never written in place (`writer.rs`), so no process of ours does that. If another one does, `copy` above is the only
    // place that holds a reference, for the time of a copy: changed bytes are then a wrong checksum of that copy; a
    // file that is shortened ends the process by SIGBUS, which `Access::Read` avoids. Test that would break it: `access_agrees`.
    unsafe { Mmap::map(file) }
}

/// Fills `bytes` from a position of the file.
#[cfg(unix)]
pub fn read_exact_at(file: &File, bytes: &mut [u8], offset: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, offset)
}

/// Writes all `bytes` at a position of the file.
#[cfg(unix)]
pub fn write_all_at(file: &File, bytes: &[u8], offset: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::write_all_at(file, bytes, offset)
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

/// Writes all `bytes` at a position of the file.
#[cfg(windows)]
pub fn write_all_at(file: &File, mut bytes: &[u8], mut offset: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        let count = std::os::windows::fs::FileExt::seek_write(file, bytes, offset)?;
        match bytes.split_at_checked(count) {
            Some((_, rest)) if count > 0 => bytes = rest,
            _ => return Err(io::ErrorKind::WriteZero.into()),
        }
        offset = offset.saturating_add(count as u64);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mapping and plain reads give the same bytes for all 10 011 ranges of a 140-byte file, and the same error outside it.
    #[test]
    fn access_agrees() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let content: Vec<u8> = (0..140).collect();
        std::fs::write(&path, &content).unwrap();
        let [mapped, plain] = [Access::Mapped, Access::Read].map(|access| Source::open(&path, access).unwrap());
        let mut ranges = 0;
        for start in 0..=140_u64 {
            for end in start..=140 {
                let expected = &content[start as usize..end as usize];
                assert_eq!(mapped.read(start, end - start).unwrap(), expected);
                assert_eq!(plain.read(start, end - start).unwrap(), expected);
                ranges += 1;
            }
        }
        assert_eq!(ranges, 10_011);
        for (offset, length) in [(0, 141), (140, 1), (u64::MAX, 1), (1, u64::MAX), (0, 1 << 60)] {
            for source in [&mapped, &plain] {
                let error = source.read(offset, length).unwrap_err();
                assert!(matches!(&error, Error::Io { action: "read", .. }), "{error}");
            }
        }
    }

    /// A file shortened under plain reads is an error of that read, not the end of the process.
    #[test]
    fn a_shortened_file_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, [1; 9000]).unwrap();
        let source = Source::open(&path, Access::Read).unwrap();
        std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(100).unwrap();
        assert_eq!(source.read(0, 100).unwrap().len(), 100);
        assert!(matches!(source.read(50, 100), Err(Error::Io { .. })));
        assert!(Source::open(folder.path(), Access::Read).is_err());
    }
}
