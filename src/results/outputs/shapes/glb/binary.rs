//! Binary part of a glTF file. In: arrays one after the other. Out: their views, each at a multiple
//! of 8 bytes, and all bytes. The bytes wait in an unnamed temporary file, because the JSON in
//! front of them states their number.

use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::outputs::sink::Sink;
use heliotile_core::error::{Error, Result};

/// glTF target of a view of vertices; `INDICES` is that of the triangles between them.
pub const ARRAY: u32 = 34962;
pub const INDICES: u32 = 34963;

/// Alignment of views, bytes.
const ALIGNED: u64 = 8;

/// Collector of arrays.
pub struct Binary {
    file: BufWriter<File>,
    path: PathBuf,
    /// Beginning, end and target of each view.
    views: Vec<(u64, u64, Option<u32>)>,
    length: u64,
}

impl Binary {
    /// Creates a collector for a file at `path`.
    pub fn new(path: &Path) -> Result<Self> {
        let file = tempfile::tempfile().map_err(Error::io(path, "create a temporary file for"))?;
        let file = BufWriter::with_capacity(1 << 20, file);
        Ok(Binary { file, path: path.to_owned(), views: Vec::new(), length: 0 })
    }

    /// Begins a view and returns its index; bytes that are put from now on belong to it.
    pub fn begin(&mut self, target: Option<u32>) -> Result<usize> {
        let start = self.length.next_multiple_of(ALIGNED);
        let gap = [0; ALIGNED as usize];
        let gap = gap.get(..(start - self.length) as usize).unwrap_or_default();
        self.file.write_all(gap).map_err(Error::io(&self.path, "write a temporary file for"))?;
        self.length = start;
        self.views.push((start, start, target));
        Ok(self.views.len() - 1)
    }

    pub fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.file.write_all(bytes).map_err(Error::io(&self.path, "write a temporary file for"))?;
        self.length += bytes.len() as u64;
        if let Some((_, end, _)) = self.views.last_mut() {
            *end = self.length;
        }
        Ok(())
    }

    /// Returns the views as glTF lists them, and the length of the buffer.
    pub fn views(&self) -> (Vec<Value>, u64) {
        let view = |(start, end, target): &(u64, u64, Option<u32>)| {
            let mut view = json!({"buffer": 0, "byteOffset": start, "byteLength": (end - start).max(1)});
            if let (Some(view), Some(target)) = (view.as_object_mut(), target) {
                view.insert("target".into(), json!(target));
            }
            view
        };
        (self.views.iter().map(view).collect(), self.length())
    }

    /// Returns the number of bytes, padding included.
    pub fn length(&self) -> u64 {
        self.length.max(1).next_multiple_of(ALIGNED)
    }

    /// Copies all bytes to the sink.
    pub fn copy_to(self, sink: &mut Sink) -> Result<()> {
        let (path, filled, length) = (self.path.clone(), self.length(), self.length);
        let copy = || -> io::Result<()> {
            let mut file = self.file.into_inner().map_err(|error| error.into_error())?;
            file.rewind()?;
            io::copy(&mut file, sink)?;
            sink.write_all(&vec![0; (filled - length) as usize])
        };
        copy().map_err(Error::io(&path, "write to"))
    }
}
