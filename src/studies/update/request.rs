//! Request for an update. In: options. Out: the archive before, the edits, the density of new
//! receivers.

use std::path::PathBuf;

use crate::covering::{CoverRequest, Density};
use heliotile_scene::edit::SceneEdits;
use heliotile_scene::request::SceneRequest;

/// Request for an update.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UpdateRequest {
    /// Archive before the edits: a path or an address.
    pub before: PathBuf,
    /// Archive to write.
    pub output: PathBuf,
    /// Edits of the scene's objects.
    pub edits: SceneEdits,
    /// Scene files that are added, in the coordinates of the scene; their materials may also be
    /// given to objects.
    pub add: SceneRequest,
    /// Surfaces that get receivers, on new objects and on objects with another shape.
    pub cover: CoverRequest,
    /// Density of the new receivers; `None`: spacing as in the archive.
    pub density: Option<Density>,
    /// True if an interrupted update of other edits in the same place is discarded.
    pub fresh: bool,
}
