//! The trace cache that projects share (`build --store`, `store ls|gc|verify`). In: finished archives. Out: those of the same scene and
//! settings, for a build to look things up in.
//!
//! A build adds its whole archive under a name that says what is in it, and never changes what is there: any number of builds
//! may read and add at once.

mod folder;

use std::path::PathBuf;
use std::time::SystemTime;

use super::{Outcome, counted, say, warn};
use crate::cli::{StoreArgs, StoreCommand};
pub use folder::Folder;
use heliotile_core::archive;
use heliotile_core::archive::{Access, Archive, format};
use heliotile_core::error::Result;

/// What decides which archives can serve a build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoreKey {
    /// Content hash of the scene, and hash of the settings.
    pub scene: [u8; 32],
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
    pub path: PathBuf,
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
pub fn open_all(store: &dyn Store, key: &StoreKey) -> Result<Vec<Archive>> {
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
        warn(&format!("the store's {} is not used: {why}", stored.path.display()));
    }
    Ok(archives)
}

/// `heliotile store`.
pub fn run(args: &StoreArgs) -> Result<Outcome> {
    match &args.command {
        StoreCommand::Ls { folder } => list(&Folder::open(folder)?),
        StoreCommand::Gc { folder, keep } => collect(&Folder::open(folder)?, keep.0),
        StoreCommand::Verify { folder } => verify(&Folder::open(folder)?),
    }
}

fn list(store: &dyn Store) -> Result<Outcome> {
    let mut text = String::from("scene             receivers        bytes  days unused  archive\n");
    for stored in store.list()? {
        let days = stored.used.elapsed().unwrap_or_default().as_secs_f64() / 86_400.0;
        let about = match Archive::open_with(&stored.path, Access::Read) {
            Ok(archive) => {
                let manifest = archive.manifest();
                let scene: String = manifest.scene.content_hash.chars().take(16).collect();
                format!("{scene:<16} {:>10}", manifest.receivers.count)
            }
            Err(_) => format!("{:<16} {:>10}", "damaged", "-"),
        };
        text += &format!("{about} {:>12} {days:>12.1}  {}\n", stored.bytes, stored.path.display());
    }
    say(&text)?;
    Ok(Outcome::Fine)
}

/// Removes the least recently used archives until the rest takes at most `keep` bytes.
fn collect(store: &dyn Store, keep: u64) -> Result<Outcome> {
    let all = store.list()?;
    let mut total: u64 = all.iter().map(|stored| stored.bytes).sum();
    let (before, mut removed) = (total, 0);
    for stored in &all {
        if total <= keep {
            break;
        }
        store.remove(stored)?;
        total -= stored.bytes;
        removed += 1;
    }
    let all = counted(all.len() as u64, "archive");
    say(&format!("{removed} of {all} removed, {} of {before} bytes\n", before - total))?;
    Ok(Outcome::Fine)
}

/// Checks every archive; one that is damaged only costs time, as builds check what they use.
fn verify(store: &dyn Store) -> Result<Outcome> {
    let (mut text, mut bad) = (String::new(), 0);
    let all = store.list()?;
    for stored in &all {
        let found = match archive::verify(&stored.path, Access::Read, true) {
            Ok(report) if report.problems.is_empty() => continue,
            Ok(report) => {
                report.problems.iter().map(|p| format!("{}: {}", p.part, p.reason)).collect::<Vec<_>>().join("; ")
            }
            Err(error) => error.to_string(),
        };
        bad += 1;
        text += &format!("{}: {found}\n", stored.path.display());
    }
    say(&format!("{text}{} checked, {bad} bad\n", counted(all.len() as u64, "archive")))?;
    Ok(if bad == 0 { Outcome::Fine } else { Outcome::ProblemFound })
}

/// Name of a hash in a store.
fn short(hash: &[u8; 32]) -> String {
    format::hex(hash).chars().take(32).collect()
}
