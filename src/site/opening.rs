//! How a site is opened. In: a place, options. Out: its open archives.

use std::fs;
use std::path::{Path, PathBuf};

use heliotile_atlas::Atlas;
use heliotile_atlas::sources::sources_of;
use heliotile_core::archive::Access;
use heliotile_core::error::Result;
use heliotile_core::memory::MemoryBudget;
use heliotile_files::writing::copy::folder_of;
use heliotile_remote::places::open_archive;
use heliotile_results::{Provenance, ReceiverChoice, Sources};

/// Options of how a site is opened.
#[derive(Clone, Debug)]
pub struct SiteOptions {
    /// How files are read; `None`: through a mapping, unless the archive is large compared with
    /// `memory`.
    pub access: Option<Access>,
    /// Memory budget that decides on `access`.
    pub memory: MemoryBudget,
    /// Receivers that results are computed for. Of an atlas, a box opens only the parts that it
    /// touches.
    pub receivers: ReceiverChoice,
    /// Program and options that files of results state.
    pub about: Provenance,
}

impl Default for SiteOptions {
    fn default() -> Self {
        let (receivers, about) = (ReceiverChoice::default(), Provenance::default());
        SiteOptions { access: None, memory: MemoryBudget::DEFAULT, receivers, about }
    }
}

/// Divisor of the memory budget: an archive of up to this share is mapped. Pages of a mapping count
/// as memory for as long as the system likes.
const MAPPED_SHARE: u64 = 4;

/// Opens the archive at a place, or the parts of an atlas there that a box touches.
pub fn sources_at(place: &Path, options: &SiteOptions) -> Result<Sources> {
    match Atlas::find(place)? {
        Some(atlas) => sources_of(&atlas, options.receivers.within(), options.access.unwrap_or_default()),
        None => Ok(Sources::from(open_archive(place, access_of(place, options))?)),
    }
}

/// Returns how the archive at a place is read.
fn access_of(place: &Path, options: &SiteOptions) -> Access {
    let is_large = || fs::metadata(place).is_ok_and(|about| about.len() > options.memory.total() / MAPPED_SHARE);
    options.access.unwrap_or_else(|| if is_large() { Access::Read } else { Access::Mapped })
}

/// Returns the folder for data that does not fit into memory: beside the output, or the system's
/// temporary folder.
pub fn working_folder(output: &Path) -> PathBuf {
    if output == Path::new("-") { std::env::temp_dir() } else { folder_of(output).into() }
}
