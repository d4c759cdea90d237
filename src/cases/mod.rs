//! Requests of the commands. In: fields that a face fills, each declared once. Out: the requests of
//! the library, with the memory to work in and the files to write.

mod archives;
mod commands;
mod filled;
mod light;
mod ready;
mod scenes;
mod tracing;

use std::path::PathBuf;

use heliotile_archives::transfer::{Bounds, Selection};
use heliotile_core::archive::Access;
use heliotile_core::error::Result;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Observer;
use heliotile_files::spill::parse_memory;
use heliotile_requests::Request;
use heliotile_results::{Provenance, ReceiverChoice};

use crate::site::{Site, SiteOptions};

pub use archives::*;
pub use commands::{Aim, COMMANDS, Command, GROUPS};
pub use filled::{Given, Prepared, prepared, stated};
pub use light::*;
pub use ready::claim_folder;
pub use scenes::*;
pub use tracing::Planned;

/// Archive or atlas, and how it is read.
#[derive(Clone, Debug, Default, Request)]
pub struct SiteRequest {
    /// Archive to read, or the folder of an atlas: a path or an address.
    #[field(positional, required, input = Archive)]
    pub archive: PathBuf,
    /// Memory to work in, such as 512MiB or 2GiB.
    #[field(default = "4GiB", parse = parse_memory, neutral)]
    pub memory: MemoryBudget,
    /// Way to read the archive [default: map, or pread if the archive is large compared with
    /// --memory].
    #[field(neutral)]
    pub io: Option<Access>,
    /// Use y as north, and ignore the true north of the archive's place.
    pub grid_north: bool,
}

/// Receivers of an archive: one of these choices, or none for all.
#[derive(Clone, Debug, Default, Request)]
#[request(at_most_one("receivers", "bbox", "surface", "object"))]
pub struct SelectionRequest {
    /// Only the receivers listed in a CSV file: ids in a column `receiver`.
    #[field(short = 'r', metavar = "FILE", input = Any)]
    pub receivers: Option<PathBuf>,
    /// Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and
    /// optionally zmin,zmax; of an atlas, only parts that touch it are opened.
    #[field(metavar = "BOX", hyphen)]
    pub bbox: Option<Bounds>,
    /// Only the receivers of these surfaces.
    #[field(python = "surfaces", metavar = "NAME", several)]
    pub surface: Vec<String>,
    /// Only the receivers of these objects or buildings.
    #[field(python = "objects", metavar = "NAME", several)]
    pub object: Vec<String>,
}

impl SelectionRequest {
    /// Returns the selection, or `None` for all receivers.
    pub fn selection(&self) -> Option<Selection> {
        let names = |names: &Vec<String>| (!names.is_empty()).then(|| names.clone());
        let listed = self.receivers.clone().map(Selection::Receivers);
        let named = names(&self.surface).map(Selection::Surfaces).or(names(&self.object).map(Selection::Objects));
        listed.or(self.bbox.map(Selection::Bounds)).or(named)
    }
}

impl SiteRequest {
    /// Opens the archive; results state `about`, and the note on true north goes to the observer.
    pub fn open(&self, some: &SelectionRequest, about: Provenance, observer: &dyn Observer) -> Result<Site> {
        let receivers = ReceiverChoice { selection: some.selection(), grid_north: self.grid_north };
        let options = SiteOptions { access: self.io, memory: self.memory, receivers, about };
        let site = Site::open_with(&self.archive, options)?;
        site.note_of_north().iter().for_each(|note| observer.note(note));
        Ok(site)
    }
}
