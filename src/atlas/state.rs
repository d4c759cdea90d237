//! State of a part. In: a part of a plan. Out: names of its files in the folder of the atlas, and a
//! word for its state.

use std::path::PathBuf;

use crate::plan::PlannedPart;

/// Name of the folder of parts in the folder of the atlas.
pub(crate) const FOLDER: &str = "parts";

/// File name of the archive of a part.
pub(crate) const ARCHIVE: &str = "site.helio";

/// File name of the marker that no receiver lies in a part.
pub(crate) const NOTHING: &str = "no-receivers.txt";

/// State of a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PartState<A = PathBuf> {
    /// The part has no finished file.
    Missing,
    /// The part has no receiver.
    Empty,
    /// The part has an archive.
    Built(A),
}

impl PlannedPart {
    /// Returns the name of the part's archive, relative to the folder of the atlas.
    pub fn archive(&self) -> String {
        self.beside(ARCHIVE)
    }

    /// Returns the name of the marker of a part without receivers, relative to the folder of the
    /// atlas.
    pub fn empty_marker(&self) -> String {
        self.beside(NOTHING)
    }

    /// Returns the name of another file of the part, relative to the folder of the atlas.
    pub fn beside(&self, file: &str) -> String {
        format!("{FOLDER}/{}/{file}", self.name)
    }
}

impl PartState {
    /// Returns the state as a word.
    pub fn word(&self) -> &'static str {
        match self {
            PartState::Built(_) => "built",
            PartState::Empty => "empty",
            PartState::Missing => "missing",
        }
    }
}
