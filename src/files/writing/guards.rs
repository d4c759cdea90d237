//! Guards against replacing files. In: an output, and the files that it is made from. Out: an error
//! if the output must not be replaced.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use heliotile_core::archive::format;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::is_address;

use super::claim::{OWN_NAME, refuse_same};

/// Refuses an output that would replace one of the inputs, or that is no regular file (a folder, a
/// device).
pub fn guard_output(output: &Path, inputs: &[&Path]) -> Result<()> {
    match fs::metadata(output) {
        Ok(found) if !found.is_file() => {
            let what = "is a folder or a device, no file can be put in its place";
            Err(Error::input(output, None, what, OWN_NAME).because(Problem::other_kind("folder or device")))
        }
        _ => refuse_same(output, inputs),
    }
}

/// Refuses to replace a file that is not an archive.
pub fn guard_archive(output: &Path) -> Result<()> {
    match starts_as_archive(output) {
        Some(false) => {
            let hint = "give the archive a name of its own, or remove the file";
            Err(Error::input(output, None, "exists and is not an archive; it would be replaced", hint)
                .because(Problem::Exists))
        }
        _ => Ok(()),
    }
}

/// Refuses a name that is not that of an archive. A file that exists and is no archive is left to
/// [`guard_archive`], which gives the better message.
pub fn check_archive_name(path: &Path) -> Result<()> {
    let named = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("helio"));
    if named || path.exists() && starts_as_archive(path) != Some(true) {
        return Ok(());
    }
    let hint = format!("name it {}", path.with_extension("helio").display());
    Err(Error::input(path, None, "does not end with .helio, the ending of archives", hint).because(Problem::Ending))
}

/// Returns true if a file is an archive by its name or by its first bytes. Every web address counts
/// as an archive.
pub fn is_archive(path: &Path) -> bool {
    is_address(&path.to_string_lossy())
        || path.extension().is_some_and(|ending| ending == "helio")
        || starts_as_archive(path) == Some(true)
}

/// Returns true if a file begins like an archive; `None` if it is empty or cannot be read.
pub fn starts_as_archive(path: &Path) -> Option<bool> {
    let mut head = Vec::new();
    File::open(path).and_then(|file| file.take(format::MAGIC.len() as u64).read_to_end(&mut head)).ok()?;
    (!head.is_empty()).then(|| head == format::MAGIC)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A note of 4 bytes, shorter than the first bytes of an archive, is refused as an output. An
    /// empty file and a missing one are not.
    #[test]
    fn a_note_of_4_bytes_is_not_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("site.helio");
        assert!(guard_archive(&path).is_ok());
        for (bytes, refused) in [(&b""[..], false), (b"mine", true), (&format::MAGIC, false)] {
            fs::write(&path, bytes).expect("a file");
            assert_eq!(guard_archive(&path).is_err(), refused, "{} bytes", bytes.len());
        }
    }
}
