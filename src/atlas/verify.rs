//! Checks of archives. In: the place of an archive or of an atlas. Out: every part of each archive
//! that is not as it was written.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::about::built;
use crate::opened::Atlas;
use heliotile_core::archive::{Access, VerifyReport};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::counted;
use heliotile_remote::naming::shown;
use heliotile_remote::places::{open_archive, verify_archive};
use heliotile_requests::{DefaultRequest, Request};

/// Request for a check.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct VerifyRequest {
    /// Archive to check, or the folder of an atlas: a path or an address.
    #[field(name = "archive", positional, required, input = Archive)]
    pub place: PathBuf,
    /// Also decode every layer and follow every reference between blocks.
    pub deep: bool,
    /// Way to read the archive.
    #[field(name = "io", default = "pread", neutral)]
    pub access: Access,
}

/// Result of the check of one archive.
#[derive(Debug)]
pub struct CheckedArchive {
    /// Name of the archive for messages.
    pub archive: PathBuf,
    /// Blocks that are not as they were written.
    pub report: VerifyReport,
    /// Reason why the archive does not belong to its part of an atlas.
    pub misplaced: Option<Error>,
}

impl VerifyRequest {
    /// Checks the archive, or the archives of the built parts of the atlas, and passes each result
    /// to `take`.
    pub fn each(&self, mut take: impl FnMut(CheckedArchive) -> Result<()>) -> Result<()> {
        let check = |path: &Path| {
            let report = verify_archive(path, self.access, self.deep)?;
            Ok(CheckedArchive { archive: shown(path), report, misplaced: None })
        };
        let Some(atlas) = Atlas::find(&self.place)? else { return take(check(&self.place)?) };
        for (part, path) in built(&atlas)? {
            let mut checked = check(&path)?;
            if checked.is_good() {
                let opened = open_archive(&path, self.access)?;
                checked.misplaced = atlas.check_place(part, &opened).err();
            }
            take(checked)?;
        }
        Ok(())
    }
}

impl CheckedArchive {
    /// Returns true if no problem was found.
    pub fn is_good(&self) -> bool {
        self.report.problems.is_empty() && self.misplaced.is_none()
    }

    /// Describes all problems, one a line, and how much was checked.
    pub fn text(&self) -> String {
        let mut out = String::new();
        for problem in &self.report.problems {
            // Writing to a string cannot fail.
            let _ = writeln!(out, "{} at byte {}: {}", problem.part, problem.offset, problem.reason);
        }
        let VerifyReport { blocks, stored_bytes, problems, .. } = &self.report;
        let (archive, blocks, bad) = (self.archive.display(), counted(*blocks, "block"), problems.len());
        let _ = writeln!(out, "{archive}: {blocks}, {stored_bytes} bytes checked, {bad} bad");
        self.misplaced.iter().for_each(|error| {
            let _ = writeln!(out, "{error}");
        });
        out
    }

    /// Describes harmless oddities of the archive.
    pub fn warning(&self) -> Option<String> {
        let (archive, trailing) = (self.archive.display(), self.report.trailing_bytes);
        let bytes = counted(trailing, "byte");
        (trailing > 0).then(|| {
            format!("{archive}: ignored {bytes} after the archive's end; harmless, `truncate -s -{trailing}` removes the excess")
        })
    }
}
