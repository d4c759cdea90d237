//! Whether archives are whole. In: the place of an archive or of an atlas. Out: every part of each that is not as it was written.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::about::built;
use crate::opened::Atlas;
use heliotile_core::archive::{Access, VerifyReport};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::counted;
use heliotile_remote::naming::shown;
use heliotile_remote::places::{open_archive, verify_archive};

/// What is asked of a check.
#[derive(Clone, Debug)]
pub struct VerifyRequest {
    /// Path or address of an archive or of an atlas.
    pub place: PathBuf,
    /// Whether every layer is decoded and every reference between blocks followed, too.
    pub deep: bool,
    /// How files are read.
    pub access: Access,
}

/// What was found of an archive.
#[derive(Debug)]
pub struct CheckedArchive {
    /// The archive, as messages name it.
    pub archive: PathBuf,
    /// What of it is not as it was written.
    pub report: VerifyReport,
    /// Why it is not the archive of its part, in an atlas.
    pub misplaced: Option<Error>,
}

impl VerifyRequest {
    /// Checks the archive, or those of the parts of the atlas that are built, and hands on what was found of each.
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
    /// Whether nothing is wrong with it.
    pub fn is_good(&self) -> bool {
        self.report.problems.is_empty() && self.misplaced.is_none()
    }

    /// All that is wrong, a line each, and how much was checked.
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

    /// What is odd about it and harmless.
    pub fn warning(&self) -> Option<String> {
        let (archive, trailing) = (self.archive.display(), self.report.trailing_bytes);
        let bytes = counted(trailing, "byte");
        (trailing > 0).then(|| {
            format!("{archive}: ignored {bytes} behind the archive's end; harmless, `truncate -s -{trailing}` cuts off what is too much")
        })
    }
}
