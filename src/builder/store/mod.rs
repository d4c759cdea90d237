//! The trace cache that projects share (`build --store`, `store ls|gc|verify`). In: finished archives. Out: those of the same scene and
//! settings, for a build to look things up in.
//!
//! A build adds its whole archive under a name that says what is in it, and never changes what is there: any number of builds
//! may read and add at once.

mod folder;

use std::path::PathBuf;
use std::time::SystemTime;

pub use folder::Folder;
use heliotile_core::archive::{Access, Archive, format};
use heliotile_core::error::Result;
use heliotile_core::observer::Observer;

/// What decides which archives can serve a build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoreKey {
    /// Content hash of the scene.
    pub scene: [u8; 32],
    /// Hash of the build's settings.
    pub settings: [u8; 32],
}

impl StoreKey {
    /// What keeps an archive from serving a build, by its own manifest: names of folders can be wrong.
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

/// An archive in a store.
#[derive(Clone, Debug)]
pub struct Stored {
    /// Where it is.
    pub path: PathBuf,
    /// Its length.
    pub bytes: u64,
    /// Last used by a build.
    pub used: SystemTime,
}

/// Where archives are kept. A folder now; whatever lists, gives and takes whole objects can be one.
pub trait Store {
    /// Archives that can serve a build, newest first.
    fn find(&self, key: &StoreKey) -> Result<Vec<Stored>>;
    /// Adds a finished archive; one of the same root is there already.
    fn add(&self, key: &StoreKey, archive: &std::path::Path, root: &[u8; 32]) -> Result<()>;
    /// All archives, least recently used first.
    fn list(&self) -> Result<Vec<Stored>>;
    /// Removes an archive. A build that reads it keeps what it has opened.
    fn remove(&self, stored: &Stored) -> Result<()>;
}

/// Opens what a store has for a build; an archive that cannot be opened, or is of something else, is passed over with a warning.
pub fn open_all(store: &dyn Store, key: &StoreKey, observer: &dyn Observer) -> Result<Vec<Archive>> {
    let mut archives = Vec::new();
    for stored in store.find(key)? {
        // Others may remove it meanwhile, or have damaged it: plain reads, and every block is checked.
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
        observer.warn(&format!("the store's {} is not used: {why}", stored.path.display()));
    }
    Ok(archives)
}

/// Name of a hash in a store.
fn short(hash: &[u8; 32]) -> String {
    format::hex(hash).chars().take(32).collect()
}
