//! Record of the inputs of results. In: an archive, weather. Out: a small file beside the results,
//! which later runs read.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::site_build::KEEP_OR_REPLACE;
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::observer::Observer;
use heliotile_core::text::{Message, message};
use heliotile_core::weather::time::sun::Interval;
use heliotile_results::outputs::sink::write_texts;
use heliotile_weather::series::Weather;

/// Name of the file.
const FILE: &str = "made-from.json";

/// Subfolders that may hold results.
const INSIDE: [&str; 3] = ["horizon", "turns", "shade"];

/// Largest size of the file, bytes: heliotile writes no larger one.
const MAX_BYTES: u64 = 64 << 20;

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
/// Inputs that results were made from, and the names of the results.
pub struct MadeFrom {
    /// Weather file, as the request named it.
    weather: String,
    /// Hash of all data read from the weather file.
    weather_hash: String,
    archive_root: String,
    /// Options that results depend on besides archive and weather, in any form.
    #[serde(default)]
    options: String,
    /// Names of results, in the folder or in one of [`INSIDE`].
    files: Vec<String>,
}

impl MadeFrom {
    pub fn new(archive: &Archive, weather: &Weather, file: &Path, mut files: Vec<String>) -> Self {
        files.sort();
        MadeFrom {
            weather: file.display().to_string(),
            weather_hash: hash(weather),
            archive_root: format::hex(&archive.root()),
            options: String::new(),
            files,
        }
    }

    /// Returns the record with options that results depend on.
    pub fn with_options(self, options: String) -> Self {
        MadeFrom { options, ..self }
    }

    /// Reads the record of a folder; `None` if it has none.
    pub fn read(folder: &Path) -> Result<Option<Self>> {
        let path = folder.join(FILE);
        match fs::metadata(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(Error::io(&path, "read")(e)),
            Ok(about) if about.len() > MAX_BYTES || !about.is_file() => {
                let what = "was not written by heliotile";
                return Err(Error::input(&path, None, what, "remove it, or give another folder with {output}")
                    .because(Problem::other_kind("not of heliotile")));
            }
            Ok(_) => {}
        }
        let bytes = fs::read(&path).map_err(Error::io(&path, "read"))?;
        let read = serde_json::from_slice(&bytes).map_err(|error| {
            let what = format!("was not written by heliotile: {error}");
            Error::input(&path, error.line(), what, "remove it, or give another folder with {output}")
                .because(Problem::other_kind("not of heliotile"))
        });
        read.map(Some)
    }

    /// Refuses a folder with results of other weather, or with some of the files that will be
    /// `written` but without a record.
    pub fn check(folder: &Path, weather: &Weather, written: impl IntoIterator<Item = PathBuf>) -> Result<()> {
        match MadeFrom::read(folder)? {
            Some(earlier) if earlier.weather_hash == hash(weather) => Ok(()),
            Some(earlier) => {
                let read = &earlier.weather;
                let what =
                    format!("holds results of other weather, read from {read}, or of another release of heliotile");
                Err(Error::input(folder, None, what, KEEP_OR_REPLACE).because(Problem::OtherInputs))
            }
            None => match written.into_iter().find(|file| file.exists()) {
                Some(file) => {
                    let what = format!("exists, and no {FILE} states what it was made from");
                    Err(Error::input(&file, None, what, KEEP_OR_REPLACE).because(Problem::Exists))
                }
                None => Ok(()),
            },
        }
    }

    /// Writes the record into a folder. If the folder's results are of another archive or other
    /// weather, they are removed if `replace` is true, or else refused. Results of other options
    /// that this run does not write anew are removed, with a warning.
    pub fn claim(&mut self, folder: &Path, replace: bool, observer: &dyn Observer) -> Result<()> {
        if let Some(mut earlier) = MadeFrom::read(folder)? {
            if earlier.is_same(self) && earlier.options == self.options {
                self.keep_files_of(&earlier);
            } else if earlier.is_same(self) {
                earlier.files.retain(|name| !self.files.contains(name));
                let path = |name: &&String| path_of(folder, name).is_some_and(|path| path.is_file());
                let stale: Vec<&str> = earlier.files.iter().filter(path).map(String::as_str).collect();
                if !stale.is_empty() {
                    observer.warn(listed_removal(folder, &stale));
                }
                earlier.remove_files(folder)?;
            } else if replace {
                earlier.remove_files(folder)?;
            } else {
                let what = "holds results of another archive than site.helio";
                return Err(Error::input(folder, None, what, KEEP_OR_REPLACE).because(Problem::OtherInputs));
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

    /// Keeps the names of files that an earlier run made from the same inputs.
    fn keep_files_of(&mut self, earlier: &MadeFrom) {
        self.files.extend(earlier.files.iter().cloned());
        self.files.sort();
        self.files.dedup();
    }

    /// Removes the results of an earlier run; other files stay.
    fn remove_files(&self, folder: &Path) -> Result<()> {
        for path in self.files.iter().filter_map(|name| path_of(folder, name)) {
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

/// Returns the warning that results of other options are removed.
fn listed_removal(folder: &Path, stale: &[&str]) -> Message {
    /// Largest number of names in a warning.
    const MOST: usize = 4;
    let named = stale.iter().take(MOST).copied().collect::<Vec<_>>().join(", ");
    let rest = stale.len().saturating_sub(MOST);
    let rest = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    message!("{}: {named}{rest} of an earlier run with other options are removed", folder.display())
}

/// Returns the path of a result; `None` for a name that heliotile does not write: in another
/// subfolder, or through a link.
fn path_of(folder: &Path, name: &str) -> Option<PathBuf> {
    let (inside, file) = match name.split_once('/') {
        Some((inside, file)) if INSIDE.contains(&inside) => (folder.join(inside), file),
        Some(_) => return None,
        None => (folder.to_owned(), name),
    };
    let is_ours = inside == folder || fs::symlink_metadata(&inside).is_ok_and(|about| about.is_dir());
    (is_ours && Path::new(file).file_name() == Some(file.as_ref())).then(|| inside.join(file))
}

/// Returns a BLAKE3 hash of the place, and of the numbers of each row that results depend on: all
/// to the bit, NaN for a missing one.
fn hash(weather: &Weather) -> String {
    let mut hasher = blake3::Hasher::new();
    let mut add = |numbers: &[f64]| {
        for number in numbers {
            hasher.update(&number.to_le_bytes());
        }
    };
    let site = &weather.site;
    add(&[site.latitude_deg, site.longitude_deg, site.zone_hours, site.elevation_m]);
    for row in &weather.rows {
        let Interval { date, start_min, end_min } = row.interval;
        add(&[date.year.into(), date.month.into(), date.day.into(), start_min, end_min]);
        add(&[row.sun.x, row.sun.y, row.sun.z, row.dni_w_m2, row.dhi_w_m2]);
        add(&[row.ghi_w_m2, row.albedo, row.snow_depth_cm].map(|number| number.unwrap_or(f64::NAN)));
    }
    format::hex(hasher.finalize().as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The 3 of 9 names that heliotile writes are removed; the files reached by `..`, other
    /// folders, links and the empty name stay, 5 of 5 files.
    #[test]
    fn only_our_files_are_removed() {
        let outer = tempfile::tempdir().expect("a folder");
        let folder = outer.path().join("out");
        for inside in ["horizon", "other", "horizon/deeper"] {
            fs::create_dir_all(folder.join(inside)).expect("made");
        }
        fs::create_dir(outer.path().join("elsewhere")).expect("made");
        let ours = ["points.csv", "horizon/a.csv", "horizon/b.csv"];
        let theirs = ["../kept.txt", "../elsewhere/a.svg", "other/a.csv", "horizon/deeper/a.csv", "mine.txt"];
        ours.iter().chain(&theirs).for_each(|name| fs::write(folder.join(name), "x").expect("written"));
        #[cfg(unix)]
        std::os::unix::fs::symlink(outer.path().join("elsewhere"), folder.join("turns")).expect("linked");
        let bad = ["../kept.txt", "horizon/../../kept.txt", "turns/a.svg", "other/a.csv", "horizon/deeper/a.csv", ""];
        let files = ours.iter().chain(&bad).map(|name| (*name).to_string()).collect();
        let text = String::new;
        let made = MadeFrom { weather: text(), weather_hash: text(), archive_root: text(), options: text(), files };
        made.remove_files(&folder).expect("removed");
        let there = |names: &[&str]| names.iter().filter(|name| folder.join(name).exists()).count();
        assert_eq!((there(&ours), there(&theirs)), (0, 5));
    }
}
