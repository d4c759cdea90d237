//! The folder of a run: which files it holds, and what may be put there. In: a command line, what was found. Out: names, and a refusal
//! where results of another scene, spacing, accuracy or weather would be lost.

use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::made_from::{FILE, MadeFrom};
use crate::cli::{Percent, RunArgs, name_of};
use crate::commands::console::shell_words::quoted;
use crate::commands::receivers::{self, Covered};
use crate::commands::repair::other_receivers;
use crate::commands::{guard_archive, guard_site, warn};
use crate::outputs::periods::Every;
use crate::outputs::sink::Sink;
use crate::outputs::tables::layout::By;
use crate::outputs::tables::writer::files_of;
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::settings::{BuildSettings, Effects};
use heliotile_core::archive::{Access, Archive, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::weather::series::Weather;
use heliotile_scene::Scene;
use heliotile_scene::site::Site;

/// What can be done where a build of other inputs was interrupted.
pub const OTHER_INPUTS: &str =
    "give the command that it was started with to go on with it, --replace to discard it, or --output FOLDER";

/// What can be done where other results are.
const KEEP_OR_REPLACE: &str = "--output FOLDER to keep both, or --replace to put the new ones in their place";

/// Files of the folder.
pub struct Files {
    pub folder: PathBuf,
    pub receivers: PathBuf,
    pub archive: PathBuf,
    /// The weather's own folder, with what follows.
    pub results: PathBuf,
    pub table: PathBuf,
    pub map: PathBuf,
}

/// The archive that lies in the folder.
pub enum Found {
    Nothing,
    /// What a build would give.
    Same(Box<Archive>),
    /// How it differs from that.
    Other(Vec<String>),
}

impl Files {
    /// Names, by those of the scene and the weather.
    pub fn of(args: &RunArgs) -> Files {
        let folder = args.output.clone().unwrap_or_else(|| default_folder(args.scene.first()));
        let results = folder.join(weather_name(&args.weather));
        Files {
            receivers: args.receivers.clone().unwrap_or_else(|| folder.join("receivers.csv")),
            archive: folder.join("site.helio"),
            table: results.join("annual.csv"),
            map: results.join("annual.ply"),
            results,
            folder,
        }
    }

    /// The table of a period.
    pub fn periods(&self, every: Every, args: &RunArgs) -> PathBuf {
        let stem = match every {
            Every::Hour => "hours",
            Every::Day => "days",
            Every::Month => "months",
            Every::Year => "years",
            Every::Total => "total",
        };
        let by = if args.by == By::default() { String::new() } else { format!(".{}", name_of(&args.by)) };
        self.results.join(format!("{stem}{by}.{}", args.format))
    }

    /// All that is written into the weather's folder.
    fn written(&self, args: &RunArgs) -> Vec<PathBuf> {
        let periods = args.every.iter().map(|every| self.periods(*every, args));
        [self.table.clone(), self.map.clone()].into_iter().chain(periods).collect()
    }

    /// The same with what is said of them beside them.
    fn written_and_beside(&self, args: &RunArgs) -> Vec<PathBuf> {
        self.written(args).iter().flat_map(|file| files_of(file)).collect()
    }

    /// Refuses to replace an input, a folder or a device.
    pub fn guard(&self, site: &Site, args: &RunArgs) -> Result<()> {
        let mut outputs = self.written_and_beside(args);
        outputs.push(self.archive.clone());
        let weather = [Some(args.weather.as_path()), args.accuracy.error_weather.as_deref()];
        for output in &outputs {
            guard_site(output, site, &[&weather[..], &[args.receivers.as_deref()]].concat())?;
        }
        guard_archive(&self.archive)?;
        if args.receivers.is_none() {
            guard_site(&self.receivers, site, &weather)?;
        }
        for folder in [&self.folder, &self.results] {
            if folder.exists() && !folder.is_dir() {
                let what = "is a file, and the output is a folder";
                return Err(Error::input(folder, None, what, "give it a name of its own with --output"));
            }
        }
        Ok(())
    }

    /// The archive in the folder, beside what a build would give.
    pub fn archive_of(
        &self,
        scene: &Scene,
        receivers: &mut ReceiverTiles,
        settings: &BuildSettings,
        args: &RunArgs,
    ) -> Result<Found> {
        if !self.archive.exists() {
            return Ok(Found::Nothing);
        }
        let archive = match Archive::open_with(&self.archive, Access::Read) {
            Ok(archive) => archive,
            Err(error) => return Ok(Found::Other(vec![format!("site.helio cannot be read ({error})")])),
        };
        let mut others = Vec::new();
        if archive.manifest().scene.content_hash != format::hex(&scene.content_hash()) {
            others.push("the scene or its materials have changed since site.helio was built".to_owned());
        }
        if archive.manifest().ground != scene.ground {
            others.push("the ground of the scene has changed since site.helio was built".to_owned());
        }
        // The suns go by the place.
        let same_place = match (&archive.manifest().place, &scene.place) {
            (Some(stated), Some(place)) => stated.is_same(place),
            (stated, place) => stated.is_none() && place.is_none(),
        };
        if !same_place {
            others.push("the place of the scene has changed since site.helio was built".to_owned());
        }
        if let Some(difference) = other_receivers(&archive, receivers)? {
            others.push(format!("the table of receivers now {difference}"));
        }
        others.extend(other_accuracy(&archive, settings, args));
        Ok(if others.is_empty() { Found::Same(Box::new(archive)) } else { Found::Other(others) })
    }

    /// The refusal to replace what is in the folder.
    pub fn refuse(&self, differences: &[String]) -> Error {
        let what = format!("holds results of other inputs: {}", differences.join("; "));
        Error::input(&self.folder, None, what, KEEP_OR_REPLACE)
    }

    /// Refuses to replace results through other weather, before any work.
    pub fn check_weather(&self, weather: &Weather, args: &RunArgs) -> Result<()> {
        if args.replace {
            return Ok(());
        }
        match MadeFrom::read(&self.results)? {
            Some(earlier) if earlier.is_through(weather) => Ok(()),
            Some(earlier) => {
                let what = format!(
                    "holds results of other weather, read from {}, or of another release of heliotile",
                    earlier.weather()
                );
                Err(Error::input(&self.results, None, what, KEEP_OR_REPLACE))
            }
            None => match self.written(args).into_iter().find(|file| file.exists()) {
                Some(file) => {
                    let what = format!("is there, and nothing ({FILE}) says what it was made from");
                    Err(Error::input(&file, None, what, KEEP_OR_REPLACE))
                }
                None => Ok(()),
            },
        }
    }

    /// Makes the weather's folder one of this archive and weather, so that results can be written there.
    pub fn claim(&self, archive: &Archive, weather: &Weather, args: &RunArgs) -> Result<()> {
        fs::create_dir_all(&self.results).map_err(Error::io(&self.results, "create"))?;
        let names =
            self.written_and_beside(args).into_iter().filter_map(|file| file.file_name()?.to_str().map(str::to_owned));
        let mut now = MadeFrom::new(archive, weather, &args.weather, names.collect());
        if let Some(earlier) = MadeFrom::read(&self.results)? {
            if earlier.is_same(&now) {
                now.keep_files_of(&earlier);
            } else if args.replace {
                earlier.remove_files(&self.results)?;
            } else {
                let what = "holds results of another archive than site.helio";
                return Err(Error::input(&self.results, None, what, KEEP_OR_REPLACE));
            }
        }
        now.write(&self.results)?;
        let stale = self.stale(&now);
        if !stale.is_empty() {
            warn(&format!(
                "results of an earlier archive are in {}: run them again with their weather and --replace",
                stale.join(", ")
            ));
        }
        Ok(())
    }

    /// Folders of other weather whose results come from an archive that is no longer there.
    fn stale(&self, now: &MadeFrom) -> Vec<String> {
        let folders = fs::read_dir(&self.folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
        let old = |folder: &PathBuf| MadeFrom::read(folder).ok().flatten().is_some_and(|made| !made.is_of_archive(now));
        let mut stale: Vec<String> = folders
            .filter(|folder| folder.is_dir() && old(folder))
            .map(|folder| folder.display().to_string())
            .collect();
        stale.sort();
        stale
    }

    /// What was written where, and what to do next.
    pub fn summary(&self, args: &RunArgs, covered: bool) -> String {
        let name = |file: &PathBuf| file.strip_prefix(&self.folder).unwrap_or(file).display().to_string();
        let mut files: Vec<String> = if covered { vec!["receivers.csv".into()] } else { Vec::new() };
        files.push("site.helio".into());
        files.extend(self.written(args).iter().map(name));
        let next = match args.every.as_slice() {
            [] => "months or hours: the same command with --every month, or ",
            _ => "other periods: ",
        };
        let word = |path: &Path| quoted(&path.to_string_lossy());
        let year = args.year.map_or(String::new(), |year| format!(" --year {year}"));
        format!(
            "{}: {}; annual.ply is the map\n{next}heliotile replay {} --weather {}{}{year} --every hour -o hours.parquet\n",
            self.folder.display(),
            files.join(", "),
            word(&self.archive),
            word(&args.weather),
            args.about_weather
        )
    }
}

/// How an archive's accuracy differs from what is asked for.
fn other_accuracy(archive: &Archive, settings: &BuildSettings, args: &RunArgs) -> Option<String> {
    let manifest = archive.manifest();
    let accuracy = manifest.accuracy.as_ref();
    let there = match accuracy {
        Some(accuracy) => format!("--error {}%", accuracy.target_percent),
        None if manifest.settings.quality.is_empty() => "settings of its own".to_owned(),
        None => format!("--quality {}", manifest.settings.quality),
    };
    let asked = match args.accuracy.error {
        Some(Percent(target)) if accuracy.is_some_and(|accuracy| accuracy.target_percent == target) => return None,
        Some(Percent(target)) => format!("--error {target}%"),
        None => {
            let stated = BuildSettings { left_out: Effects::default(), ..BuildSettings::of(&manifest.settings) };
            if stated == *settings && accuracy.is_none() {
                return None;
            }
            let now = settings.stated();
            let pairs = manifest.settings.numbers().zip(now.numbers());
            let others = pairs.filter(|((_, there), (_, now))| there != now);
            let list: Vec<String> = others.map(|((setting, _), (_, now))| format!("{}={now}", setting.name)).collect();
            match now.quality.as_str() {
                "" => format!("--quality {} and {}", name_of(&args.accuracy.quality), list.join(" ")),
                quality => format!("--quality {quality}"),
            }
        }
    };
    Some(format!("site.helio was built with {there}, not {asked}"))
}

/// A table of receivers that is not yet in its place.
pub struct PlannedReceivers {
    /// It is removed with the value.
    _beside: TempDir,
    file: PathBuf,
}

impl PlannedReceivers {
    /// Writes the receivers that get light.
    pub fn write(covered: &Covered, args: &RunArgs, files: &Files) -> Result<Self> {
        let beside = tempfile::Builder::new().prefix(".receivers").tempdir_in(&files.folder);
        let beside = beside.map_err(Error::io(&files.folder, "make a folder in"))?;
        let file = beside.path().join("receivers.csv");
        receivers::write(Sink::file(&file)?, covered, covered.free(), args.cover.offset.0, false)?;
        Ok(PlannedReceivers { _beside: beside, file })
    }

    pub fn path(&self) -> &Path {
        &self.file
    }

    /// How the table that lies in the folder differs, if there is one: no difference, or one.
    pub fn differences(&self, files: &Files) -> Result<Vec<String>> {
        let there = &files.receivers;
        if !there.exists() {
            return Ok(Vec::new());
        }
        let lines = |path: &Path| File::open(path).map(|file| BufReader::new(file).split(b'\n'));
        let (mut old, mut new) = (
            lines(there).map_err(Error::io(there, "read"))?,
            lines(&self.file).map_err(Error::io(&self.file, "read"))?,
        );
        for line in 1_u64.. {
            let of =
                |next: Option<std::io::Result<Vec<u8>>>, path: &Path| next.transpose().map_err(Error::io(path, "read"));
            match (of(old.next(), there)?, of(new.next(), &self.file)?) {
                (None, None) => break,
                (a, b) if a == b => {}
                _ => {
                    return Ok(vec![format!(
                        "receivers.csv is another one from line {line} on (other surfaces or spacing, or it was edited: \
                         --receivers takes it as it is)"
                    )]);
                }
            }
        }
        Ok(Vec::new())
    }

    /// Puts the table into its place.
    pub fn place(self, files: &Files) -> Result<()> {
        fs::rename(&self.file, &files.receivers).map_err(Error::io(&files.receivers, "rename to"))
    }
}

/// `town.city.json` gives `town.sun`, beside nothing: in the folder that one works in.
fn default_folder(scene: &Path) -> PathBuf {
    let whole = fs::canonicalize(scene).unwrap_or_else(|_| scene.to_owned());
    let name = whole.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.split('.').find(|part| !part.is_empty()).unwrap_or("site");
    PathBuf::from(format!("{stem}.sun"))
}

/// `golden_tmy3.epw` gives `golden_tmy3`; points inside a name stay.
fn weather_name(weather: &Path) -> PathBuf {
    let packed = weather.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gz"));
    let plain = if packed { weather.with_extension("") } else { weather.to_owned() };
    plain.file_stem().map_or_else(|| "weather".into(), PathBuf::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 4 names of weather files lose their ending and nothing else.
    #[test]
    fn folders_are_named_after_weather() {
        for (file, name) in [
            ("a/golden_tmy3.epw", "golden_tmy3"),
            ("NLD_Den.Haag.062100_IWEC.epw", "NLD_Den.Haag.062100_IWEC"),
            ("w.csv.gz", "w"),
            ("plain", "plain"),
        ] {
            assert_eq!(weather_name(Path::new(file)), PathBuf::from(name));
        }
    }
}
