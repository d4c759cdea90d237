//! What results were made from. In: an archive, weather. Out: a small file beside the results, by which a later run knows them.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::commands::traced::KEEP_OR_REPLACE;
use crate::outputs::sink::write_texts;
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::weather::series::Weather;

/// Its name.
const FILE: &str = "made-from.json";

/// A longer one is none of ours.
const MOST_BYTES: u64 = 1 << 20;

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MadeFrom {
    /// The file, as it was named.
    weather: String,
    /// Hash of all that was read from it.
    weather_hash: String,
    archive_root: String,
    /// Names of results, all in one folder.
    files: Vec<String>,
}

impl MadeFrom {
    pub fn new(archive: &Archive, weather: &Weather, file: &Path, files: Vec<String>) -> Self {
        MadeFrom {
            weather: file.display().to_string(),
            weather_hash: hash(weather),
            archive_root: format::hex(&archive.root()),
            files,
        }
    }

    /// What a folder says of itself; `None` if it says nothing.
    pub fn read(folder: &Path) -> Result<Option<Self>> {
        let path = folder.join(FILE);
        match fs::metadata(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(Error::io(&path, "read")(e)),
            Ok(about) if about.len() > MOST_BYTES || !about.is_file() => {
                let what = "is not what heliotile wrote";
                return Err(Error::input(&path, None, what, "remove it, or give another folder with --output"));
            }
            Ok(_) => {}
        }
        let bytes = fs::read(&path).map_err(Error::io(&path, "read"))?;
        let read = serde_json::from_slice(&bytes).map_err(|error| {
            let what = format!("is not what heliotile wrote: {error}");
            Error::input(&path, error.line(), what, "remove it, or give another folder with --output")
        });
        read.map(Some)
    }

    /// Refuses a folder that holds results of other weather, or some of the files that will be `written` and nothing that says of what.
    pub fn check(folder: &Path, weather: &Weather, written: impl IntoIterator<Item = PathBuf>) -> Result<()> {
        match MadeFrom::read(folder)? {
            Some(earlier) if earlier.weather_hash == hash(weather) => Ok(()),
            Some(earlier) => {
                let read = &earlier.weather;
                let what =
                    format!("holds results of other weather, read from {read}, or of another release of heliotile");
                Err(Error::input(folder, None, what, KEEP_OR_REPLACE))
            }
            None => match written.into_iter().find(|file| file.exists()) {
                Some(file) => {
                    let what = format!("is there, and nothing ({FILE}) says what it was made from");
                    Err(Error::input(&file, None, what, KEEP_OR_REPLACE))
                }
                None => Ok(()),
            },
        }
    }

    /// Says so in a folder, whose files of other archives or weather are removed if they may be replaced, and refused if not.
    pub fn claim(&mut self, folder: &Path, replace: bool) -> Result<()> {
        if let Some(earlier) = MadeFrom::read(folder)? {
            if earlier.is_same(self) {
                self.keep_files_of(&earlier);
            } else if replace {
                earlier.remove_files(folder)?;
            } else {
                let what = "holds results of another archive than site.helio";
                return Err(Error::input(folder, None, what, KEEP_OR_REPLACE));
            }
        }
        self.write(folder)
    }

    pub fn is_of_archive(&self, other: &MadeFrom) -> bool {
        self.archive_root == other.archive_root
    }

    fn is_same(&self, other: &MadeFrom) -> bool {
        self.weather_hash == other.weather_hash && self.is_of_archive(other)
    }

    /// Files that an earlier run made from the same stay.
    fn keep_files_of(&mut self, earlier: &MadeFrom) {
        self.files.extend(earlier.files.iter().cloned());
        self.files.sort();
        self.files.dedup();
    }

    /// Removes the results of an earlier run; what else lies there stays.
    fn remove_files(&self, folder: &Path) -> Result<()> {
        // A name with a folder in it was not written by this program.
        for name in self.files.iter().filter(|name| Path::new(name).file_name() == Some(name.as_ref())) {
            let path = folder.join(name);
            match fs::remove_file(&path) {
                Err(e) if e.kind() != ErrorKind::NotFound => return Err(Error::io(&path, "remove")(e)),
                _ => {}
            }
        }
        Ok(())
    }

    fn write(&self, folder: &Path) -> Result<()> {
        let path = folder.join(FILE);
        let text = serde_json::to_string_pretty(self).map_err(|e| Error::io(&path, "write")(e.into()))?;
        write_texts(folder, &[(FILE, text + "\n")])
    }
}

/// BLAKE3 of the place and all rows; numbers are written so that they read back to the bit.
fn hash(weather: &Weather) -> String {
    let mut hasher = blake3::Hasher::new();
    // Writing to a hash cannot fail.
    let _ = writeln!(hasher, "{:?}", weather.site);
    weather.rows.iter().for_each(|row| drop(writeln!(hasher, "{row:?}")));
    format::hex(hasher.finalize().as_bytes())
}
