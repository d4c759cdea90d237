//! A file mapped into memory. In: an open file. Out: copies of its bytes. This file has the only
//! `unsafe` of the crate.
//!
//! All bytes are copied out, so no reference into a mapping lives longer than a copy.

use std::fs::File;
use std::io;

use memmap2::Mmap;

use crate::archive::read_at::{ReadAt, range};

/// File that is read through a mapping.
#[derive(Debug)]
pub struct MappedFile {
    /// The mapping; `None` for an empty file, which cannot be mapped.
    map: Option<Mmap>,
}

impl MappedFile {
    /// Maps a whole file for reading.
    #[allow(unsafe_code)]
    pub fn new(file: &File) -> io::Result<Self> {
        if file.metadata()?.len() == 0 {
            return Ok(MappedFile { map: None });
        }
        // SAFETY: the mapping must not change or shrink while a reference into it lives. Archives
        // are published by rename and never written in place (`writer.rs`), so no process of ours
        // does that. If another one does, the copies below are the only places that hold a
        // reference, for the time of a copy: changed bytes are then a wrong checksum of that copy;
        // a file that is shortened ends the process by SIGBUS, which `Access::Read` avoids. Test
        // that would break it: `every_access_reads_equal_bytes`.
        unsafe { Mmap::map(file) }.map(|map| MappedFile { map: Some(map) })
    }

    fn bytes(&self) -> &[u8] {
        self.map.as_deref().unwrap_or_default()
    }
}

impl ReadAt for MappedFile {
    fn length(&self) -> u64 {
        self.bytes().len() as u64
    }

    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        bytes.copy_from_slice(range(self.bytes(), offset, bytes.len())?);
        Ok(())
    }

    fn copy_at(&self, offset: u64, length: usize) -> io::Result<Vec<u8>> {
        Ok(range(self.bytes(), offset, length)?.to_vec())
    }
}
