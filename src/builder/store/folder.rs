//! Store in a folder: `FOLDER/SCENE/SETTINGS/ROOT.helio`, each name 32 digits of a hash.

use std::ffi::OsStr;
use std::fs::{self, File, FileTimes};
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::store::{Store, StoreKey, Stored, short};
use crate::writing::copy::copy_whole;
use heliotile_core::error::{Error, Result};

/// Store in a folder of the file system.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Opens a folder that is a store: an empty one, or one that holds the folder of a scene.
    pub fn open(path: &Path) -> Result<Self> {
        let refuse =
            |what: &'static str| Err(Error::input(path, None, what, "give a folder that a build with {store} made"));
        if !path.is_dir() {
            return refuse("is not a folder");
        }
        let entries = entries(path)?;
        if !entries.is_empty() && !entries.iter().any(|entry| is_name(&entry.file_name()) && entry.path().is_dir()) {
            return refuse("is not a store");
        }
        Ok(Folder { path: path.to_path_buf() })
    }

    /// Opens the store in a folder, and creates the folder if it is absent.
    pub fn create(path: &Path) -> Result<Self> {
        fs::create_dir_all(path).map_err(Error::io(path, "create the folder"))?;
        Ok(Folder { path: path.to_path_buf() })
    }

    fn of(&self, key: &StoreKey) -> PathBuf {
        self.path.join(short(&key.scene)).join(short(&key.settings))
    }
}

impl Store for Folder {
    fn find(&self, key: &StoreKey) -> Result<Vec<Stored>> {
        let mut found = archives(&self.of(key))?;
        found.sort_by_key(|stored| std::cmp::Reverse(stored.used));
        for stored in &found {
            // The time only records the last use. A store that is read-only can still be read, so
            // errors are ignored.
            let touched = File::options().append(true).open(&stored.path);
            let _ = touched.and_then(|file| file.set_times(FileTimes::new().set_modified(SystemTime::now())));
        }
        Ok(found)
    }

    fn add(&self, key: &StoreKey, archive: &Path, root: &[u8; 32]) -> Result<()> {
        let folder = self.of(key);
        fs::create_dir_all(&folder).map_err(Error::io(&folder, "create the folder"))?;
        let place = folder.join(short(root)).with_extension("helio");
        // An archive of this name is replaced, since it may be damaged. A hard link costs no space,
        // and it stays valid: the owner replaces the archive and never changes it in place.
        let link = folder.join(format!("{}.{}.new", short(root), std::process::id()));
        if fs::hard_link(archive, &link).is_ok() {
            return fs::rename(&link, &place).map_err(Error::io(&place, "rename a link to"));
        }
        copy_whole(archive, &place)
    }

    fn list(&self) -> Result<Vec<Stored>> {
        let mut all = Vec::new();
        for scene in folders(&self.path)? {
            for settings in folders(&scene)? {
                all.extend(archives(&settings)?);
            }
        }
        all.sort_by_key(|stored| (stored.used, stored.path.clone()));
        Ok(all)
    }

    fn remove(&self, stored: &Stored) -> Result<()> {
        fs::remove_file(&stored.path).map_err(Error::io(&stored.path, "remove"))
    }
}

/// Returns true if `name` can be the name of a hash, as [`short`] makes it.
fn is_name(name: &OsStr) -> bool {
    name.to_str().is_some_and(|name| name.len() == 32 && name.bytes().all(|b| b.is_ascii_hexdigit()))
}

/// Returns the entries of a folder, or none if it does not exist.
fn entries(folder: &Path) -> Result<Vec<fs::DirEntry>> {
    match fs::read_dir(folder) {
        Ok(entries) => entries.collect::<io::Result<_>>().map_err(Error::io(folder, "list")),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(Error::io(folder, "list")(error)),
    }
}

fn folders(folder: &Path) -> Result<Vec<PathBuf>> {
    Ok(entries(folder)?.into_iter().map(|entry| entry.path()).filter(|path| path.is_dir()).collect())
}

fn archives(folder: &Path) -> Result<Vec<Stored>> {
    let mut found = Vec::new();
    for entry in entries(folder)?.into_iter().filter(|entry| entry.path().extension().is_some_and(|e| e == "helio")) {
        // Skip an archive that another process removed meanwhile.
        if let Ok(about) = entry.metadata() {
            let used = about.modified().unwrap_or(SystemTime::UNIX_EPOCH);
            found.push(Stored { path: entry.path(), bytes: about.len(), used });
        }
    }
    Ok(found)
}
