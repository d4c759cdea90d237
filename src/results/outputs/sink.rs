//! Sink of a table: the standard output, or a file that appears under its name only when it is
//! complete.

use std::io::{self, BufWriter, Stdout, Write};
use std::path::{Path, PathBuf};

use heliotile_core::error::{Error, Result};
use heliotile_files::writing::whole_file::WholeFile;

/// Byte sink of a table.
pub struct Sink {
    target: Target,
    path: PathBuf,
    bytes: u64,
}

enum Target {
    /// Standard output; `None` once the reader has gone, after which bytes are dropped.
    Stdout(Option<Stdout>),
    /// File; `None` once finished.
    File(Option<BufWriter<WholeFile>>),
}

/// Writes texts, by name, into an existing folder; files get their names once all are written.
pub fn write_texts<N: AsRef<str>>(folder: &Path, texts: &[(N, String)]) -> Result<()> {
    let mut sinks = Vec::new();
    for (name, text) in texts {
        let path = folder.join(name.as_ref());
        let mut sink = Sink::file(&path)?;
        sink.write_all(text.as_bytes()).map_err(Error::io(&path, "write to"))?;
        sinks.push(sink);
    }
    sinks.into_iter().try_for_each(|sink| sink.finish().map(|_| ()))
}

/// Writes `bytes` to a file, whole or not at all.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut sink = Sink::file(path)?;
    sink.write_all(bytes).map_err(Error::io(path, "write to"))?;
    sink.finish().map(|_| ())
}

impl Sink {
    pub fn stdout() -> Self {
        let path = PathBuf::from("standard output");
        Sink { target: Target::Stdout(Some(io::stdout())), path, bytes: 0 }
    }

    /// Opens a file that appears as `path` with [`Sink::finish`]. A sink that is dropped before
    /// leaves nothing.
    pub fn file(path: &Path) -> Result<Self> {
        let file = BufWriter::with_capacity(1 << 20, WholeFile::create(path)?);
        Ok(Sink { target: Target::File(Some(file)), path: path.to_path_buf(), bytes: 0 })
    }

    /// Returns the name for messages.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the final path of the file; `None` for the standard output.
    pub fn file_path(&self) -> Option<&Path> {
        match &self.target {
            Target::Stdout(_) => None,
            Target::File(_) => Some(&self.path),
        }
    }

    /// Returns true if the reader of the output has gone away (`heliotile ... | head`): further
    /// rows need not be made.
    pub fn is_closed(&self) -> bool {
        matches!(self.target, Target::Stdout(None))
    }

    /// Makes the file visible, flushed, synced to disk and renamed, and returns the number of
    /// bytes.
    pub fn finish(mut self) -> Result<u64> {
        self.flush().map_err(Error::io(&self.path, "write to"))?;
        if let Target::File(file) = &mut self.target
            && let Some(file) = file.take()
        {
            let file = file.into_inner().map_err(|error| Error::io(&self.path, "write to")(error.into_error()))?;
            file.finish()?;
        }
        Ok(self.bytes)
    }

    /// Turns a closed pipe into success with `otherwise`: the reader has seen enough.
    fn pipe<T>(&mut self, result: io::Result<T>, otherwise: T) -> io::Result<T> {
        match (&mut self.target, result) {
            (Target::Stdout(out), Err(e)) if e.kind() == io::ErrorKind::BrokenPipe => {
                *out = None;
                Ok(otherwise)
            }
            (_, result) => result,
        }
    }
}

impl Write for Sink {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        let result = match &mut self.target {
            Target::Stdout(Some(out)) => out.write(buffer),
            Target::File(Some(file)) => file.write(buffer),
            _ => return Ok(buffer.len()),
        };
        let written = self.pipe(result, buffer.len())?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        let result = match &mut self.target {
            Target::Stdout(Some(out)) => out.flush(),
            Target::File(Some(file)) => file.flush(),
            _ => Ok(()),
        };
        self.pipe(result, ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The file does not exist before `finish`; a dropped sink leaves nothing (0 files); a finished
    /// one leaves 1 file.
    #[test]
    fn a_file_appears_only_when_it_is_finished() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("t.csv");
        let count = || std::fs::read_dir(folder.path()).expect("a folder").count();
        let mut sink = Sink::file(&path).expect("created");
        sink.write_all(b"half").expect("written");
        assert!(!path.exists());
        drop(sink);
        assert_eq!(count(), 0);
        let mut sink = Sink::file(&path).expect("created");
        sink.write_all(b"whole").expect("written");
        assert_eq!(sink.finish().expect("finished"), 5);
        assert_eq!((count(), std::fs::read(&path).expect("read").len()), (1, 5));
    }

    /// A missing folder is an error that names the file.
    #[test]
    fn a_missing_folder_is_an_error_that_names_the_file() {
        let text = Sink::file(Path::new("/no/such/t.csv")).err().map(|e| e.to_string());
        assert!(text.is_some_and(|t| t.starts_with("cannot create /no/such/t.csv")));
    }
}
