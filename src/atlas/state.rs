//! What there is of a part: its files by their names in the folder of the atlas, and its state.

use std::path::PathBuf;

use crate::plan::PlannedPart;

/// The folder of parts in that of an atlas.
pub(crate) const FOLDER: &str = "parts";

/// The archive of a part.
pub(crate) const ARCHIVE: &str = "site.helio";

/// Says that no receiver lies in a part.
pub(crate) const NOTHING: &str = "no-receivers.txt";

/// What is there of a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PartState<A = PathBuf> {
    /// Nothing that is finished.
    Missing,
    /// It has no receiver.
    Empty,
    /// Its archive.
    Built(A),
}

impl PlannedPart {
    /// Its archive, by its name in the folder of the atlas.
    pub fn archive(&self) -> String {
        self.beside(ARCHIVE)
    }

    /// What stands there instead if no receiver lies in it.
    pub fn empty_marker(&self) -> String {
        self.beside(NOTHING)
    }

    /// Another file of its folder, likewise.
    pub fn beside(&self, file: &str) -> String {
        format!("{FOLDER}/{}/{file}", self.name)
    }
}

impl PartState {
    /// What there is, in a word.
    pub fn word(&self) -> &'static str {
        match self {
            PartState::Built(_) => "built",
            PartState::Empty => "empty",
            PartState::Missing => "missing",
        }
    }
}
