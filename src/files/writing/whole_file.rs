//! Files that appear whole. In: a path, then bytes. Out: the file under its name once it is
//! complete, or nothing.
//!
//! Bytes go to `.NAME.XXXXXX.partial` beside the file, a new file of a random name, which replaces
//! the file at the end. While it is written, this process holds the claim of the output, so two
//! runs into one name never mix. A run that was killed leaves its partial file: the next run into
//! the same name removes it.

use std::fs::{self, Permissions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use heliotile_core::error::{Error, Result};
use tempfile::NamedTempFile;

use super::claim::{Claim, guard_inputs, is_claimed};
use super::copy::folder_of;

/// Ending of the names of unfinished files.
const PARTIAL: &str = ".partial";

/// Unfinished files of this process, for [`remove_unfinished`].
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// File being written, which is not seen under its name yet. One that is dropped before
/// [`WholeFile::finish`] leaves nothing.
#[derive(Debug)]
pub struct WholeFile {
    path: PathBuf,
    partial: NamedTempFile,
    _listed: Listed,
    /// Claim of this file alone; `None` where a claim of the whole command holds it.
    _claim: Option<Claim>,
}

impl WholeFile {
    /// Starts a file. It is an error if another run writes it, or if it is an input of this run.
    pub fn create(path: &Path) -> Result<Self> {
        let Some(name) = path.file_name() else {
            return Err(Error::input(path, None, "cannot be a file", "give the output a name of its own"));
        };
        guard_inputs(path)?;
        let claim = if is_claimed(path) { None } else { Some(Claim::of_file(path)?) };
        let mut start = std::ffi::OsString::from(".");
        start.push(name);
        start.push(".");
        let folder = folder_of(path);
        remove_left_overs(folder, &start);
        let mut builder = tempfile::Builder::new();
        builder.prefix(&start).suffix(PARTIAL);
        let builder = with_usual_permissions(&mut builder);
        let partial = builder.tempfile_in(folder).map_err(|source| Error::io(path, "create")(plain(source)))?;
        let listed = Listed::new(partial.path());
        Ok(WholeFile { path: path.to_path_buf(), partial, _listed: listed, _claim: claim })
    }

    /// Returns the name that the file will have.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Syncs the file and gives it its name.
    pub fn finish(self) -> Result<()> {
        self.partial.as_file().sync_all().map_err(Error::io(&self.path, "write"))?;
        let WholeFile { path, partial, _listed, _claim } = self;
        partial.persist(&path).map(drop).map_err(|e| Error::io(&path, "rename to")(e.error))
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.partial.as_file_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.partial.as_file_mut().flush()
    }
}

/// Entry in the list of unfinished files.
#[derive(Debug)]
struct Listed(PathBuf);

impl Listed {
    fn new(path: &Path) -> Self {
        unfinished().push(path.to_path_buf());
        Listed(path.to_path_buf())
    }
}

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().retain(|path| *path != self.0);
    }
}

/// Removes the unfinished files of this process, which is about to end.
pub fn remove_unfinished() {
    for path in unfinished().drain(..) {
        let _ = fs::remove_file(path);
    }
}

fn unfinished() -> std::sync::MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the unfinished files of killed runs. The caller holds the claim, so none is in use.
fn remove_left_overs(folder: &Path, start: &std::ffi::OsStr) {
    let start = start.to_string_lossy();
    let ours = unfinished().clone();
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let random = name.to_string_lossy().strip_prefix(&*start).and_then(|rest| rest.strip_suffix(PARTIAL)).map(
            // `.a.csv.X.partial` belongs to `a.csv`, and `.a.csv.b.X.partial` to `a.csv.b`.
            |random| !random.is_empty() && random.bytes().all(|byte| byte.is_ascii_alphanumeric()),
        );
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if random == Some(true) && is_file && !ours.contains(&entry.path()) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Lets others read the file as far as the user's mask allows, like any other file.
#[cfg(unix)]
fn with_usual_permissions<'b, 'p, 's>(builder: &'b mut tempfile::Builder<'p, 's>) -> &'b mut tempfile::Builder<'p, 's> {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(Permissions::from_mode(0o666))
}

/// Returns the builder: other systems have no such mask.
#[cfg(not(unix))]
fn with_usual_permissions<'b, 'p, 's>(builder: &'b mut tempfile::Builder<'p, 's>) -> &'b mut tempfile::Builder<'p, 's> {
    builder
}

/// Returns an error without the temporary name that `tempfile` adds.
fn plain(source: io::Error) -> io::Error {
    source.raw_os_error().map_or(source, io::Error::from_raw_os_error)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder").flatten();
        let mut names: Vec<String> = entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// A file of 3 bytes appears when it is finished, replaces the old one, and leaves 0 other
    /// files; a dropped one leaves the old one. Leftovers of killed runs into the name are removed,
    /// those of 2 other names and a file of the user stay.
    #[test]
    fn files_appear_whole_or_not_at_all() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let kept = [".a.csv.b.Xy12Zz.partial", ".b.csv.Xy12Zz.partial", "a.csv.partial"];
        kept.iter()
            .chain(&[".a.csv.Xy12Zz.partial", "a.csv"])
            .for_each(|name| fs::write(at(name), "old").expect("old"));
        let mut dropped = WholeFile::create(&at("a.csv")).expect("a file");
        dropped.write_all(b"lost").expect("written");
        assert_eq!(names(folder.path()).len(), 6, "{:?}", names(folder.path()));
        drop(dropped);
        assert_eq!(fs::read(at("a.csv")).expect("the old one"), b"old");
        let mut file = WholeFile::create(&at("a.csv")).expect("a file");
        file.write_all(b"new").expect("written");
        assert_eq!(fs::read(at("a.csv")).expect("the old one"), b"old");
        file.finish().expect("finished");
        assert_eq!(fs::read(at("a.csv")).expect("the new one"), b"new");
        assert_eq!(names(folder.path()), [kept[0], kept[1], "a.csv", kept[2]]);
    }

    /// A second writer of a name is refused while the first has it, 2 of 2 in this process; once
    /// the first is done the name is free.
    #[test]
    fn one_writer_has_a_name_at_a_time() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.csv");
        let first = WholeFile::create(&path).expect("a file");
        for other in [path.clone(), folder.path().join("./a.csv")] {
            let refused = WholeFile::create(&other).expect_err("a second writer").to_string();
            assert!(refused.contains("is being written by another"), "{refused}");
        }
        first.finish().expect("finished");
        assert!(WholeFile::create(&path).is_ok());
        assert_eq!(names(folder.path()), ["a.csv"]);
    }

    /// A link of the old temporary name leads to a file that keeps its 4 bytes.
    #[test]
    #[cfg(unix)]
    fn links_are_not_followed() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        fs::write(at("mine.txt"), "mine").expect("written");
        for name in ["a.csv.partial", "a.csv"] {
            std::os::unix::fs::symlink(at("mine.txt"), at(name)).expect("a link");
        }
        let mut file = WholeFile::create(&at("a.csv")).expect("a file");
        file.write_all(b"new").expect("written");
        file.finish().expect("finished");
        assert_eq!(fs::read(at("mine.txt")).expect("a file"), b"mine");
        assert_eq!(fs::read(at("a.csv")).expect("a file"), b"new");
    }
}
