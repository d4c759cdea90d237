//! An object as a file. In: an object that was opened. Out: a file that gets its name once all
//! bytes have arrived and were checked.

use std::io::Write;
use std::path::Path;

use heliotile_core::archive::read_at::OpenFile;
use heliotile_core::archive::{ReadAt, verify_bytes};
use heliotile_core::error::{Error, Result};

use crate::stores::remote_file::RemoteFile;

/// Bytes that are requested and written at a time.
const STEP: u64 = 16 << 20;

/// Writes the object to a file and calls `came` with the number of bytes of each step. An archive
/// is checked block by block before it gets its name. Errors: a file of that name, unless
/// `replace`; bytes that cannot be read, or are damaged.
pub fn download(file: &RemoteFile, to: &Path, replace: bool, came: impl Fn(u64)) -> Result<()> {
    let folder = to.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut partial =
        tempfile::Builder::new().prefix(".copy-").tempfile_in(folder).map_err(Error::io(folder, "create a file in"))?;
    let mut at = 0;
    while at < file.length() {
        let step = STEP.min(file.length() - at);
        let bytes =
            file.copy_at(at, usize::try_from(step).unwrap_or(usize::MAX)).map_err(Error::unread(file.name()))?;
        partial.write_all(&bytes).map_err(Error::io(to, "write"))?;
        at += step;
        came(step);
    }
    partial.as_file().sync_all().map_err(Error::io(to, "sync"))?;
    if file.is_archive() {
        let copy = OpenFile::new(partial.reopen().map_err(Error::io(to, "open a copy of"))?)
            .map_err(Error::io(to, "read a copy of"))?;
        let report = verify_bytes(file.name(), copy, false)?;
        if let Some(problem) = report.problems.first() {
            let what = format!(
                "is damaged in the store, or was damaged during the copy: {} at byte {}: {}",
                problem.part, problem.offset, problem.reason
            );
            return Err(Error::input(
                file.name(),
                None,
                what,
                "copy it again; if the damage is the same, `{command:archive verify}` lists all of it",
            ));
        }
    }
    // The name comes last: a file of that name is whole and checked.
    open_to_all(partial.as_file());
    let persisted = if replace { partial.persist(to) } else { partial.persist_noclobber(to) };
    persisted.map(drop).map_err(|error| match error.error.kind() {
        std::io::ErrorKind::AlreadyExists => {
            Error::input(to, None, "is there already", "give it another name, or replace it with {replace}")
        }
        _ => Error::io(to, "rename a copy to")(error.error),
    })
}

/// Gives a temporary file, which only its owner may read, the permissions of an ordinary file
/// (0644).
#[cfg(unix)]
fn open_to_all(file: &std::fs::File) {
    use std::os::unix::fs::PermissionsExt;
    // The file is whole even if its permissions cannot be changed.
    let _ = file.set_permissions(std::fs::Permissions::from_mode(0o644));
}

#[cfg(not(unix))]
fn open_to_all(_: &std::fs::File) {}
