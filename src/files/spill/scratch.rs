//! Temporary files for data that the engine cannot keep in memory. They have no name, and the
//! operating system removes them when the program ends, even after a crash.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use heliotile_core::archive::read_at::read_exact_at;
use heliotile_core::error::{Error, Result};
use heliotile_core::light::scratch::{Scratch, ScratchSpace};

use crate::writing::regular::write_all_at;

/// Temporary storage as files in a given folder.
#[derive(Clone, Debug)]
pub struct TempFiles {
    folder: Arc<Path>,
}

impl TempFiles {
    /// Creates temporary storage in `folder`, which must exist when the first file is made.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        TempFiles { folder: folder.into().into() }
    }
}

impl ScratchSpace for TempFiles {
    fn scratch(&self) -> Result<Box<dyn Scratch>> {
        let file = tempfile::tempfile_in(&self.folder);
        let file = file.map_err(Error::io(&self.folder, "create a temporary file in"))?;
        Ok(Box::new(TempFile { folder: Arc::clone(&self.folder), file }))
    }
}

/// Temporary storage in the folder that the operating system provides for it.
#[derive(Clone, Copy, Debug, Default)]
pub struct SystemTemp;

impl ScratchSpace for SystemTemp {
    fn scratch(&self) -> Result<Box<dyn Scratch>> {
        TempFiles::new(std::env::temp_dir()).scratch()
    }
}

struct TempFile {
    folder: Arc<Path>,
    file: File,
}

impl Scratch for TempFile {
    fn write(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        write_all_at(&self.file, bytes, offset).map_err(Error::io(&self.folder, "write a temporary file in"))
    }

    fn read(&self, offset: u64, bytes: &mut [u8]) -> Result<()> {
        read_exact_at(&self.file, bytes, offset).map_err(Error::io(&self.folder, "read a temporary file in"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 200 pieces of 7 bytes, written in reverse order, come back, and skipped bytes are 0. Reading
    /// one byte too far is an error. The folder shows 0 names, and the error for a missing folder
    /// names it.
    #[test]
    fn bytes_come_back() {
        let folder = tempfile::tempdir().expect("a scratch folder");
        let scratch = TempFiles::new(folder.path()).scratch().expect("a file");
        for piece in (0..200_u8).rev() {
            scratch.write(u64::from(piece) * 10, &[piece; 7]).expect("written");
        }
        let mut bytes = [9; 1997];
        scratch.read(0, &mut bytes).expect("read");
        for (i, byte) in bytes.iter().enumerate() {
            assert_eq!(usize::from(*byte), if i % 10 < 7 { i / 10 } else { 0 });
        }
        assert!(scratch.read(1, &mut bytes).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
        let missing = folder.path().join("gone");
        let error = TempFiles::new(missing).scratch().err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error.contains("cannot create a temporary file in") && error.contains("gone"), "{error}");
    }
}
