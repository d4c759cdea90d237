//! A temporary file for values that need not stay in memory; it has no name and is gone with the program.

use std::fs::File;
use std::path::{Path, PathBuf};

use crate::archive::read_at::{read_exact_at, write_all_at};
use crate::error::{Error, Result};

/// Bytes by position. Many threads may use it at once.
#[derive(Debug)]
pub struct Scratch {
    folder: PathBuf,
    file: File,
}

impl Scratch {
    /// A new empty file in `folder`.
    pub fn new(folder: &Path) -> Result<Self> {
        let file = tempfile::tempfile_in(folder).map_err(Error::io(folder, "create a temporary file in"))?;
        Ok(Scratch { folder: folder.to_path_buf(), file })
    }

    /// Writes all bytes at a position.
    pub fn write(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        write_all_at(&self.file, bytes, offset).map_err(Error::io(&self.folder, "write a temporary file in"))
    }

    /// Fills `bytes` from a position.
    pub fn read(&self, offset: u64, bytes: &mut [u8]) -> Result<()> {
        read_exact_at(&self.file, bytes, offset).map_err(Error::io(&self.folder, "read a temporary file in"))
    }
}
