//! The right of one run to write an output. In: inputs and outputs of a run. Out: a guard that no
//! other run can hold at the same time, or an error if an output is also an input, another output,
//! or being written.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use heliotile_core::error::{Error, Problem, Result};

use super::copy::folder_of;
use super::file_lock::FileLock;
use super::regular::{is_named, open_regular};

/// Outputs that commands of this process claim, resolved.
static CLAIMED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Inputs that commands of this process read, and that no file may replace.
static INPUTS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Claim of a file or of a folder. It is a locked, empty file `.NAME.lock` beside the output, which
/// is removed with the claim; the lock of a process that was killed is free.
#[derive(Debug)]
pub(super) struct Claim {
    path: PathBuf,
    lock: FileLock,
    /// Folders around the output that were created for the lock, innermost first.
    around: Vec<PathBuf>,
}

impl Claim {
    /// Claims a file.
    pub(super) fn of_file(output: &Path) -> Result<Claim> {
        let path = lock_of(output);
        match Claim::at(&path) {
            Ok(claim) => Ok(claim),
            Err(ClaimError::Held) => Err(held(output)),
            Err(ClaimError::Io(source)) => Err(Error::io(output, "create")(source)),
        }
    }

    /// Claims a folder, which need not exist, and creates the folders around it.
    fn of_folder(output: &Path) -> Result<Claim> {
        let beside = lock_of(output);
        let missing = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
        let around: Vec<PathBuf> = output.ancestors().skip(1).take_while(missing).map(Path::to_path_buf).collect();
        if let Some(innermost) = around.first() {
            fs::create_dir_all(innermost).map_err(Error::io(output, "create"))?;
        }
        match Claim::at(&beside) {
            Ok(mut claim) => {
                claim.around = around;
                Ok(claim)
            }
            Err(ClaimError::Held) => Err(held(output)),
            // The folder can be written and the one around it cannot.
            Err(ClaimError::Io(_)) if output.is_dir() => match Claim::at(&output.join(".lock")) {
                Ok(claim) => Ok(claim),
                Err(ClaimError::Held) => Err(held(output)),
                Err(ClaimError::Io(source)) => Err(Error::io(output, "write into")(source)),
            },
            Err(ClaimError::Io(source)) => Err(Error::io(output, "create")(source)),
        }
    }

    /// Locks the file at `path`. Between opening and locking, the process that held the lock may
    /// have removed the file, so the name must still refer to the locked file; if not, both are
    /// tried again.
    fn at(path: &Path) -> std::result::Result<Claim, ClaimError> {
        for _ in 0..64 {
            let file =
                open_regular(path, OpenOptions::new().read(true).write(true).create(true).truncate(false).to_owned())?;
            let Some(lock) = FileLock::try_new(file)? else { return Err(ClaimError::Held) };
            let borrowed: &File = std::borrow::Borrow::borrow(&lock);
            if is_named(borrowed, path).map_err(|_| io::Error::from(io::ErrorKind::NotFound))? {
                return Ok(Claim { path: path.to_path_buf(), lock, around: Vec::new() });
            }
        }
        Err(ClaimError::Held)
    }
}

impl Drop for Claim {
    /// Removes the lock file while it is locked. A file of this name with content is the user's.
    /// Folders that were created and stayed empty go, too.
    fn drop(&mut self) {
        let file: &File = std::borrow::Borrow::borrow(&self.lock);
        if file.metadata().is_ok_and(|about| about.len() == 0) {
            let _ = fs::remove_file(&self.path);
        }
        for folder in &self.around {
            let _ = fs::remove_dir(folder);
        }
    }
}

enum ClaimError {
    /// Another run holds the claim.
    Held,
    Io(io::Error),
}

impl From<io::Error> for ClaimError {
    fn from(source: io::Error) -> Self {
        ClaimError::Io(source)
    }
}

/// Output of a run.
#[derive(Clone, Debug)]
pub struct ClaimedOutput {
    path: PathBuf,
    /// Files that the run writes: the output and what stands beside it, or names in a folder.
    files: Vec<PathBuf>,
    kind: OutputKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OutputKind {
    File,
    Folder,
    /// The writer of archives has a lock of its own, and several runs share a folder of parts.
    Shared,
}

impl ClaimedOutput {
    /// Returns a file that is written with `beside` beside it.
    pub fn file(path: &Path, beside: Vec<PathBuf>) -> Self {
        let files = [vec![path.to_path_buf()], beside].concat();
        ClaimedOutput { path: path.to_path_buf(), files, kind: OutputKind::File }
    }

    /// Returns an archive, with the names that its writer uses until it is complete.
    pub fn archive(path: &Path) -> Self {
        let beside = |ending: &str| {
            let mut name = path.as_os_str().to_os_string();
            name.push(ending);
            PathBuf::from(name)
        };
        let files = vec![path.to_path_buf(), beside(".partial"), beside(".partial.log")];
        ClaimedOutput { path: path.to_path_buf(), files, kind: OutputKind::Shared }
    }

    /// Returns a folder of one run, in which it writes files of these names.
    pub fn folder(path: &Path, names: &[&str]) -> Self {
        let files = names.iter().map(|name| path.join(name)).collect();
        ClaimedOutput { path: path.to_path_buf(), files, kind: OutputKind::Folder }
    }

    /// Returns a folder that runs share.
    pub fn shared(path: &Path) -> Self {
        ClaimedOutput { path: path.to_path_buf(), files: Vec::new(), kind: OutputKind::Shared }
    }
}

/// Guard of a run: while it lives, no other run writes its outputs, and no file replaces an input.
#[derive(Debug)]
pub struct OutputGuard {
    claims: Vec<Claim>,
    claimed: Vec<PathBuf>,
    inputs: Vec<PathBuf>,
}

impl OutputGuard {
    /// Compares the outputs of a run with its inputs and with each other, by what they are, and
    /// claims them.
    pub fn new(inputs: &[&Path], outputs: &[ClaimedOutput]) -> Result<Self> {
        let mut before: Vec<&Path> = Vec::new();
        for output in outputs {
            for file in &output.files {
                refuse_same(file, inputs)?;
                if let Some(other) = before.iter().find(|other| same_place(other, file)) {
                    let same = Problem::SameFile { other: other.to_path_buf() };
                    let what = "is named for two outputs, of which one would be lost";
                    return Err(Error::input(file, None, what, OWN_NAME).because(same));
                }
            }
            before.extend(output.files.iter().map(PathBuf::as_path));
        }
        let mut guard = OutputGuard { claims: Vec::new(), claimed: Vec::new(), inputs: Vec::new() };
        for ClaimedOutput { path, kind, .. } in outputs {
            let claim = match kind {
                OutputKind::File => Claim::of_file(path)?,
                OutputKind::Folder => Claim::of_folder(path)?,
                OutputKind::Shared => continue,
            };
            guard.claims.push(claim);
            guard.claimed.push(resolved(path));
        }
        guard.inputs = inputs.iter().map(|input| input.to_path_buf()).collect();
        list(&CLAIMED).extend(guard.claimed.iter().cloned());
        list(&INPUTS).extend(guard.inputs.iter().cloned());
        Ok(guard)
    }
}

impl Drop for OutputGuard {
    fn drop(&mut self) {
        for (all, mine) in [(&CLAIMED, &self.claimed), (&INPUTS, &self.inputs)] {
            let mut all = list(all);
            for path in mine {
                if let Some(place) = all.iter().position(|other| other == path) {
                    all.swap_remove(place);
                }
            }
        }
        self.claims.clear();
    }
}

/// Refuses to replace an input of a command of this process.
pub(super) fn guard_inputs(output: &Path) -> Result<()> {
    refuse_same(output, &list(&INPUTS))
}

/// Returns true if a command of this process has claimed a file or a folder around it.
pub(super) fn is_claimed(file: &Path) -> bool {
    let file = resolved(file);
    list(&CLAIMED).iter().any(|claimed| file.starts_with(claimed))
}

/// Returns true if two paths lead to one file: the same file of the disk, through links, other
/// spellings and, where the file system ignores it, letter case; or, if neither exists, the same
/// name in one folder.
pub fn same_place(a: &Path, b: &Path) -> bool {
    match (a.exists(), b.exists()) {
        (true, true) => same_entry(a, b),
        (false, false) => {
            let [(a, in_a), (b, in_b)] = [a, b].map(|path| (path.file_name(), folder_of(path)));
            let names = || match (a, b) {
                (Some(a), Some(b)) if a == b => true,
                (Some(a), Some(b)) => {
                    a.to_string_lossy().to_lowercase() == b.to_string_lossy().to_lowercase() && ignores_case(in_a)
                }
                _ => false,
            };
            (in_a == in_b || same_entry(in_a, in_b)) && names()
        }
        _ => false,
    }
}

/// Returns true if two paths are one file or folder of the disk.
#[cfg(unix)]
fn same_entry(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let entry = |path: &Path| fs::metadata(path).map(|about| (about.dev(), about.ino()));
    matches!((entry(a), entry(b)), (Ok(a), Ok(b)) if a == b)
}

/// Returns true if two paths are one file or folder of the disk.
#[cfg(not(unix))]
fn same_entry(a: &Path, b: &Path) -> bool {
    matches!((fs::canonicalize(a), fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}

/// Returns true if a folder is also found under its name in other letters.
fn ignores_case(folder: &Path) -> bool {
    let Ok(folder) = fs::canonicalize(folder) else { return false };
    let Some(name) = folder.file_name().map(|name| name.to_string_lossy()) else { return false };
    let other = if name.to_uppercase() == *name { name.to_lowercase() } else { name.to_uppercase() };
    other != *name && same_entry(&folder, &folder.with_file_name(other))
}

/// Returns an absolute path without links, also if its last parts do not exist.
fn resolved(path: &Path) -> PathBuf {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let known = whole.ancestors().find_map(|part| Some((part, fs::canonicalize(part).ok()?)));
    match known {
        Some((part, real)) => match whole.strip_prefix(part) {
            Ok(rest) if !rest.as_os_str().is_empty() => real.join(rest),
            _ => real,
        },
        None => whole,
    }
}

/// Returns the path of the lock of an output.
fn lock_of(output: &Path) -> PathBuf {
    // A folder may be given as `.` or `..`, which have no names.
    let output = if output.file_name().is_some() { output.to_path_buf() } else { resolved(output) };
    let mut name = std::ffi::OsString::from(".");
    name.push(output.file_name().unwrap_or_default());
    name.push(".lock");
    folder_of(&output).join(name)
}

fn held(output: &Path) -> Error {
    Error::input(output, None, "is being written by another run", "wait for it to end, or give another name")
        .because(Problem::Busy)
}

/// Advice for an output that is another file as well.
pub(super) const OWN_NAME: &str = "give the output a name of its own";

/// Refuses a file to write that is one of the inputs.
pub(super) fn refuse_same(file: &Path, inputs: &[impl AsRef<Path>]) -> Result<()> {
    let Some(other) = inputs.iter().map(AsRef::as_ref).find(|input| same_place(input, file)) else { return Ok(()) };
    let same = Problem::SameFile { other: other.to_path_buf() };
    Err(Error::input(file, None, "is also an input, and would be replaced", OWN_NAME).because(same))
}

fn list(of: &'static Mutex<Vec<PathBuf>>) -> MutexGuard<'static, Vec<PathBuf>> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(inputs: &[&Path], outputs: &[ClaimedOutput]) -> String {
        OutputGuard::new(inputs, outputs).err().map_or(String::new(), |error| error.to_string())
    }

    /// An output is refused that is an input, or another output, in 7 spellings: plain, with a dot,
    /// through a link, through a linked folder, by a hard link, absent twice, and as the file
    /// beside a table. Names of their own are not refused.
    #[test]
    #[cfg(unix)]
    fn outputs_are_compared_by_what_they_are() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a.csv"), "a").expect("written");
        fs::create_dir(at("d")).expect("made");
        std::os::unix::fs::symlink(at("a.csv"), at("link.csv")).expect("a link");
        std::os::unix::fs::symlink(folder.path(), at("d/up")).expect("a link");
        fs::hard_link(at("a.csv"), at("hard.csv")).expect("a link");
        let one = |name: &str| vec![ClaimedOutput::file(&at(name), Vec::new())];
        for name in ["a.csv", "./a.csv", "link.csv", "d/up/a.csv", "hard.csv"] {
            assert!(said(&[&at("a.csv")], &one(name)).contains("is also an input"), "{name}");
        }
        let two = [one("new.csv"), one("d/up/new.csv")].concat();
        assert!(said(&[], &two).contains("is named for two outputs"));
        let beside = ClaimedOutput::file(&at("t.csv"), vec![at("t.csv-metadata.json")]);
        assert!(said(&[], &[beside, one("t.csv-metadata.json").remove(0)]).contains("two outputs"));
        assert_eq!(said(&[&at("a.csv")], &[one("b.csv"), one("B.csv"), one("d/b.csv")].concat()), "");
    }

    /// A folder is claimed by 1 run at a time, with the files in it, and is free again afterwards;
    /// 0 files of the claim stay.
    #[test]
    fn a_folder_belongs_to_one_run() {
        let folder = tempfile::tempdir().expect("a folder");
        let output = folder.path().join("out");
        let outputs = [ClaimedOutput::folder(&output, &["a.csv"])];
        let guard = OutputGuard::new(&[], &outputs).expect("claimed");
        assert!(is_claimed(&output.join("b/c.csv")) && !is_claimed(&folder.path().join("c.csv")));
        assert!(said(&[], &outputs).contains("is being written by another run"));
        drop(guard);
        assert_eq!(said(&[], &outputs), "");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0);
    }

    /// While a run reads an input, 1 file that would replace it is refused, whatever writes it.
    #[test]
    fn inputs_of_a_run_are_not_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let input = folder.path().join("w.csv");
        fs::write(&input, "w").expect("written");
        let guard = OutputGuard::new(&[&input], &[]).expect("a guard");
        assert!(super::super::whole_file::WholeFile::create(&input).is_err());
        drop(guard);
        assert!(super::super::whole_file::WholeFile::create(&input).is_ok());
    }
}
