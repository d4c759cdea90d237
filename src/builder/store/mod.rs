//! Store: the trace cache that projects share (`build --store`, `store ls|gc|verify`). In: finished
//! archives. Out: the archives of the same scene and settings, which a build can reuse.
//!
//! A build adds its whole archive under a name made of its hashes, and never changes an archive
//! that is in the store. Any number of builds may read and add at once.

mod folder;

use std::path::PathBuf;
use std::time::SystemTime;

pub use folder::Folder;
use heliotile_core::archive::{Access, Archive, format};
use heliotile_core::error::Result;
use heliotile_core::observer::Observer;

/// Hashes that decide which archives can serve a build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoreKey {
    /// Content hash of the scene.
    pub scene: [u8; 32],
    /// Hash of the build's settings.
    pub settings: [u8; 32],
}

impl StoreKey {
    /// Returns why an archive cannot serve a build, judged by its own manifest, because names of
    /// folders can be wrong.
    fn misfit(&self, archive: &Archive) -> Result<Option<&'static str>> {
        let manifest = archive.manifest();
        Ok(if manifest.scene.content_hash != format::hex(&self.scene) {
            Some("it is of another scene")
        } else if manifest.settings.hash()? != self.settings {
            Some("it has other settings")
        } else {
            None
        })
    }
}

/// Archive in a store.
#[derive(Clone, Debug)]
pub struct Stored {
    /// Path of the archive.
    pub path: PathBuf,
    /// Length of the archive, bytes.
    pub bytes: u64,
    /// Time of the last use by a build.
    pub used: SystemTime,
}

/// Storage of finished archives. It is a folder now; any service that lists, gets and puts whole
/// objects can implement it.
pub trait Store {
    /// Returns the archives that can serve a build, newest first.
    fn find(&self, key: &StoreKey) -> Result<Vec<Stored>>;
    /// Adds a finished archive. An archive with the same root may already be there.
    fn add(&self, key: &StoreKey, archive: &std::path::Path, root: &[u8; 32]) -> Result<()>;
    /// Returns all archives, least recently used first.
    fn list(&self) -> Result<Vec<Stored>>;
    /// Removes an archive. A build that has it open can go on reading it.
    fn remove(&self, stored: &Stored) -> Result<()>;
}

/// Opens the archives of a store that can serve a build. An archive that cannot be opened or does
/// not fit is skipped with a warning.
pub fn open_all(store: &dyn Store, key: &StoreKey, observer: &dyn Observer) -> Result<Vec<Archive>> {
    let mut archives = Vec::new();
    for stored in store.find(key)? {
        // Another process may remove or damage the file meanwhile: plain reads, and every block is
        // checked.
        let opened =
            Archive::open_with(&stored.path, Access::Read).and_then(|archive| Ok((key.misfit(&archive)?, archive)));
        let why = match opened {
            Ok((None, archive)) => {
                archives.push(archive);
                continue;
            }
            Ok((Some(misfit), _)) => misfit.to_string(),
            Err(error) => error.to_string(),
        };
        observer.warn(format!("the store's {} is not used: {why}", stored.path.display()));
    }
    Ok(archives)
}

/// Returns the name of a hash in a store.
fn short(hash: &[u8; 32]) -> String {
    format::hex(hash).chars().take(32).collect()
}
