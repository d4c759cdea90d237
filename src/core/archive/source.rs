//! Bytes of an archive with the name that messages give them. In: a path, or any [`ReadAt`]. Out:
//! owned copies of ranges.

#[cfg(any(unix, windows))]
use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

use crate::archive::format::Entry;
#[cfg(all(feature = "mmap", any(unix, windows)))]
use crate::archive::mapping::MappedFile;
#[cfg(any(unix, windows))]
use crate::archive::read_at::OpenFile;
use crate::archive::read_at::ReadAt;
use crate::error::{Error, Result};
use crate::named::NamedValues;

/// Way in which an archive is read from a file system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Access {
    /// Access through a mapping: fastest once the file is in memory. Without the feature `mmap` it
    /// is [`Access::Read`].
    #[default]
    Mapped,
    /// Reads at a position: for files that other programs may shorten, and network file systems.
    Read,
}

/// A fixed number of bytes, and their name.
#[derive(Debug)]
pub struct Source {
    name: Arc<Path>,
    bytes: Box<dyn ReadAt>,
    length: u64,
}

impl Source {
    /// Returns a source of bytes from any holder; messages call it `name`.
    pub fn new(name: &Path, bytes: Box<dyn ReadAt>) -> Self {
        Source { name: Arc::from(name), length: bytes.length(), bytes }
    }

    /// Opens a file for reading. Its length is taken now and does not change.
    #[cfg(any(unix, windows))]
    pub fn open(path: &Path, access: Access) -> Result<Self> {
        let file = File::open(path).map_err(Error::io(path, "open"))?;
        let about = file.metadata().map_err(Error::io(path, "read the length of"))?;
        if !about.is_file() {
            return Err(Error::input(path, None, "is not a file", "name an archive, such as site.helio"));
        }
        Ok(Source::new(path, bytes_of(file, access).map_err(Error::io(path, "map"))?))
    }

    /// Returns the file's path, or the name that was given with the bytes.
    pub fn path(&self) -> &Arc<Path> {
        &self.name
    }

    /// Returns the number of bytes.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Returns a copy of `length` bytes at `offset`. Nothing is allocated for a range outside the
    /// file.
    pub fn read(&self, offset: u64, length: u64) -> Result<Vec<u8>> {
        let copied = self.inside(offset, length).and_then(|length| self.bytes.copy_at(offset, length));
        copied.map_err(Error::unread(&self.name))
    }

    /// Returns the stored bytes of a block. Nothing is allocated for a block outside the file.
    pub fn read_block(&self, block: &Entry) -> Result<Vec<u8>> {
        let copied = self.inside(block.offset, block.stored.into()).and_then(|_| self.bytes.copy_block(block));
        copied.map_err(Error::unread(&self.name))
    }

    /// Announces blocks that will be read soon.
    pub fn expect(&self, blocks: &[Entry]) {
        self.bytes.expect(blocks);
    }

    fn inside(&self, offset: u64, length: u64) -> io::Result<usize> {
        let end = offset.checked_add(length).filter(|&end| end <= self.length);
        end.and_then(|_| usize::try_from(length).ok()).ok_or_else(|| io::ErrorKind::UnexpectedEof.into())
    }
}

#[cfg(all(feature = "mmap", any(unix, windows)))]
fn bytes_of(file: File, access: Access) -> io::Result<Box<dyn ReadAt>> {
    Ok(match access {
        Access::Mapped => Box::new(MappedFile::new(&file)?),
        Access::Read => Box::new(OpenFile::new(file)?),
    })
}

#[cfg(all(not(feature = "mmap"), any(unix, windows)))]
fn bytes_of(file: File, _: Access) -> io::Result<Box<dyn ReadAt>> {
    Ok(Box::new(OpenFile::new(file)?))
}

impl NamedValues for Access {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("map", "Map the file into memory: fastest once the file is cached", Access::Mapped),
        (
            "pread",
            "Read pieces of the file: for files that other programs may shorten, and network file systems",
            Access::Read,
        ),
    ];
}

crate::serde_by_name!(Access);

crate::parse_by_name!(Access);

#[cfg(test)]
mod tests {
    use super::*;

    /// A mapping, plain reads, a vector and shared memory give the same bytes for all 10 011 ranges
    /// of 140 bytes, copied out and read into a buffer, and the same error outside them.
    #[test]
    fn every_access_reads_equal_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let content: Vec<u8> = (0..140).collect();
        std::fs::write(&path, &content).unwrap();
        let files = [Access::Mapped, Access::Read].map(|access| Source::open(&path, access).unwrap());
        let memory: [Box<dyn ReadAt>; 2] = [Box::new(content.clone()), Box::new(Arc::<[u8]>::from(&content[..]))];
        let sources: Vec<Source> = files.into_iter().chain(memory.map(|bytes| Source::new(&path, bytes))).collect();
        let mut ranges = 0;
        for start in 0..=140_u64 {
            for end in start..=140 {
                let expected = &content[start as usize..end as usize];
                for source in &sources {
                    assert_eq!(source.read(start, end - start).unwrap(), expected);
                    let mut bytes = vec![0; expected.len()];
                    source.bytes.read_at(start, &mut bytes).unwrap();
                    assert_eq!(bytes, expected);
                }
                ranges += 1;
            }
        }
        assert_eq!((ranges, sources.len()), (10_011, 4));
        for (offset, length) in [(0, 141), (140, 1), (u64::MAX, 1), (1, u64::MAX), (0, 1 << 60)] {
            for source in &sources {
                assert_eq!(source.length(), 140);
                let error = source.read(offset, length).unwrap_err();
                assert!(matches!(&error, Error::Io { action: "read", .. }), "{error}");
                assert!(length > 200 || source.bytes.read_at(offset, &mut vec![0; length as usize]).is_err());
            }
        }
    }

    /// A file that is shortened under plain reads is an error of that read and does not end the
    /// process. An empty file has 0 bytes with either access.
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
        std::fs::write(&path, []).unwrap();
        for access in [Access::Mapped, Access::Read] {
            assert_eq!(Source::open(&path, access).unwrap().length(), 0);
        }
    }
}
