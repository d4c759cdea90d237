//! Sorted run of records in a temporary file. Each record is its key length and payload length as
//! u32, then both.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use heliotile_core::error::{Error, Result};

/// Number of bytes of the two lengths in front of every record.
pub(super) const LENGTHS: usize = 8;

/// Key and its payload.
pub(super) type Record = (Vec<u8>, Vec<u8>);

/// Encodes the two lengths that go in front of a record.
pub(super) fn lengths(key: &[u8], payload: &[u8]) -> Result<[u8; LENGTHS]> {
    let mut bytes = [0; LENGTHS];
    for (slot, (what, part)) in bytes.chunks_exact_mut(4).zip([("key", key), ("payload", payload)]) {
        let length = u32::try_from(part.len()).map_err(|_| Error::Limit {
            what: format!("bytes in the {what} of a record").into(),
            value: part.len() as u64,
            max: u64::from(u32::MAX),
        })?;
        slot.copy_from_slice(&length.to_le_bytes());
    }
    Ok(bytes)
}

/// Decodes key length and payload length, as [`lengths`] encodes them.
pub(super) fn parse_lengths([a, b, c, d, e, f, g, h]: [u8; LENGTHS]) -> (usize, usize) {
    (u32::from_le_bytes([a, b, c, d]) as usize, u32::from_le_bytes([e, f, g, h]) as usize)
}

/// Position of a run in its file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    start: u64,
    end: u64,
}

/// Writer of runs, one after the other, into one temporary file.
pub(super) struct RunWriter {
    folder: PathBuf,
    file: BufWriter<File>,
    start: u64,
    end: u64,
}

impl RunWriter {
    pub(super) fn create(folder: &Path, buffer_bytes: usize) -> Result<Self> {
        let file = tempfile::tempfile_in(folder).map_err(Error::io(folder, "create a temporary file in"))?;
        let file = BufWriter::with_capacity(buffer_bytes, file);
        Ok(RunWriter { folder: folder.to_owned(), file, start: 0, end: 0 })
    }

    pub(super) fn append(&mut self, parts: &[&[u8]]) -> Result<()> {
        for part in parts {
            self.file.write_all(part).map_err(Error::io(&self.folder, "write a temporary file in"))?;
            self.end += part.len() as u64;
        }
        Ok(())
    }

    pub(super) fn append_record(&mut self, key: &[u8], payload: &[u8]) -> Result<()> {
        self.append(&[&lengths(key, payload)?, key, payload])
    }

    /// Ends the run of all records appended since the last call, and returns its position.
    pub(super) fn end_run(&mut self) -> Run {
        let run = Run { start: self.start, end: self.end };
        self.start = self.end;
        run
    }

    pub(super) fn finish(self) -> Result<Arc<File>> {
        let file = self.file.into_inner().map_err(io::IntoInnerError::into_error);
        file.map(Arc::new).map_err(Error::io(&self.folder, "write a temporary file in"))
    }
}

/// Reader of the records of one run, in order.
pub(super) struct RunReader {
    folder: PathBuf,
    section: BufReader<Section>,
    /// Number of bytes of the run that are not read yet.
    left: u64,
}

impl RunReader {
    pub(super) fn new(file: &Arc<File>, run: Run, buffer_bytes: usize, folder: &Path) -> Self {
        let section = Section { file: file.clone(), at: run.start, end: run.end };
        let section = BufReader::with_capacity(buffer_bytes, section);
        RunReader { folder: folder.to_owned(), section, left: run.end - run.start }
    }

    pub(super) fn next(&mut self) -> Result<Option<Record>> {
        self.read().map_err(Error::io(&self.folder, "read a temporary file in"))
    }

    fn read(&mut self) -> io::Result<Option<Record>> {
        if self.left == 0 {
            return Ok(None);
        }
        let mut head = [0; LENGTHS];
        self.section.read_exact(&mut head)?;
        let (key, payload) = parse_lengths(head);
        let length = (LENGTHS + key + payload) as u64;
        let Some(left) = self.left.checked_sub(length) else {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "a record is longer than its run"));
        };
        self.left = left;
        let mut record = (vec![0; key], vec![0; payload]);
        self.section.read_exact(&mut record.0)?;
        self.section.read_exact(&mut record.1)?;
        Ok(Some(record))
    }

    #[cfg(test)]
    pub(super) fn buffered(&self) -> usize {
        self.section.capacity()
    }
}

/// Reader of a part of a file that several readers share. Only one may read at a time, because they
/// share the position of the file.
struct Section {
    file: Arc<File>,
    at: u64,
    end: u64,
}

impl Read for Section {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let wanted = usize::try_from(self.end - self.at).map_or(buffer.len(), |left| left.min(buffer.len()));
        let mut file = &*self.file;
        file.seek(SeekFrom::Start(self.at))?;
        let count = file.read(buffer.get_mut(..wanted).unwrap_or_default())?;
        if count == 0 && wanted > 0 {
            return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "it ends too early"));
        }
        self.at += count as u64;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file that lost its last 1 or 30 bytes, or whose lengths point beyond the run, gives an
    /// error that names the folder.
    #[test]
    fn a_shortened_run_is_an_error_that_names_the_folder() {
        let folder = tempfile::tempdir().expect("a scratch folder");
        let write = || {
            let mut writer = RunWriter::create(folder.path(), 16).expect("created");
            for i in 0..3_u8 {
                writer.append_record(&[i; 5], &[i; 10]).expect("written");
            }
            let run = writer.end_run();
            (writer.finish().expect("written"), run)
        };
        let read = |file: &Arc<File>, run| {
            let mut reader = RunReader::new(file, run, 7, folder.path());
            std::iter::from_fn(|| reader.next().transpose()).collect::<Result<Vec<_>>>()
        };
        let (file, run) = write();
        assert_eq!(read(&file, run).expect("whole").len(), 3);
        for lost in [1, 30] {
            file.set_len(run.end - lost).expect("cut");
            let message = read(&file, run).expect_err("short").to_string();
            let start = format!("cannot read a temporary file in {}: ", folder.path().display());
            assert!(message.starts_with(&start) && message.ends_with("it ends too early"), "{message}");
        }
        let (file, run) = write();
        (&*file).seek(SeekFrom::Start(run.start + 3)).expect("inside");
        (&*file).write_all(&[0xff]).expect("written");
        let message = read(&file, run).expect_err("long").to_string();
        assert!(message.ends_with("a record is longer than its run"), "{message}");
    }
}
