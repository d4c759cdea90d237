//! Where work keeps what does not fit into memory.

use std::path::PathBuf;

use heliotile_core::memory::MemoryBudget;

/// Folder and memory budget of a piece of work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Workspace {
    /// Folder of temporary files.
    pub folder: PathBuf,
    /// Memory budget for all that a build holds besides the scene and its tree.
    pub memory: MemoryBudget,
}
