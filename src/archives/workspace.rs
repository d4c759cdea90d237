//! Where work keeps what does not fit into memory, and archives that work does not take.

use std::path::PathBuf;

use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::memory::MemoryBudget;

/// Folder and memory budget of a piece of work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Workspace {
    /// Folder of temporary files.
    pub folder: PathBuf,
    /// Memory budget for all that a build holds besides the scene and its tree.
    pub memory: MemoryBudget,
}

/// Refuses a preview: some of its layers are from before a change of its scene.
pub fn complete(archive: &Archive) -> Result<()> {
    if archive.manifest().preview.is_none() {
        return Ok(());
    }
    let what = "the archive is a preview: part of its light is from before its scene was changed";
    Err(Error::input(archive.path(), None, what, "complete it: give the command that made it, without {preview}")
        .because(Problem::other_kind("preview")))
}
