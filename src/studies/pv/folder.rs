//! Folder of `pv`: the files it holds, and checks before they are written. In: a request, the
//! results. Out: names, and a refusal if results of other inputs would be lost.

use std::fs;
use std::path::{Path, PathBuf};

use super::modules::{GEOMETRY, MATERIALS, PLAIN};
use super::request::PvRequest;
use super::spots::Spots;
use crate::run::made_from::MadeFrom;
use crate::site_build::KEEP_OR_REPLACE;
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::observer::Observer;
use heliotile_core::weather::time::years::Years;
use heliotile_files::writing::guards::guard_archive;
use heliotile_results::outputs::pv::{horizon, shade};
use heliotile_results::outputs::tables::format::files_of;
use heliotile_scene::pv::tracker::Tracker;
use heliotile_scene::site::SceneFiles;
use heliotile_scene::site::guard_site;
use heliotile_weather::series::Weather;

/// Name of the archive of fixed modules, and of the folder with those of trackers.
const SITE: &str = "site.helio";
const ANGLES: &str = "angles";

/// Returns the name of the archive of trackers at an angle, degrees, relative to the folder.
fn archive_at(angle_deg: f64) -> String {
    // Adding 0 leaves no -0.
    format!("{ANGLES}/{}.helio", (angle_deg * 100.0).round() / 100.0 + 0.0)
}

/// Files of the folder.
pub struct PvFolder {
    pub folder: PathBuf,
    /// Archive of the modules, or those of trackers at each traced angle.
    pub archives: Vec<PathBuf>,
    pub points: PathBuf,
    pub months: PathBuf,
    /// Tables of receivers on the ground, if there are any: a row each, and their months.
    pub ground: Option<[PathBuf; 2]>,
    /// Tables of the energy of the array, if its power is known: a row for each string, and months.
    pub energy: Option<[PathBuf; 2]>,
    /// Table of the years of a weather file of several.
    pub energy_years: Option<PathBuf>,
    pub hours: PathBuf,
    pub horizon_table: PathBuf,
    /// Folder with a list for each point.
    pub horizons: PathBuf,
    /// Folder with the shade of the array.
    pub shade: PathBuf,
    pub search: PathBuf,
    pub best: PathBuf,
    /// Folder with a picture for each point.
    pub turns: PathBuf,
}

impl PvFolder {
    /// Returns the files of a request; `has_ground` is true if there are receivers on the ground,
    /// `has_power` if modules have a rated power.
    pub fn new(request: &PvRequest, tracker: Option<Tracker>, has_ground: bool, has_power: bool) -> Self {
        let folder = request.folder.clone();
        let file = |name: &str| folder.join(name);
        PvFolder {
            archives: match tracker {
                Some(tracker) => tracker.angles_deg().iter().map(|angle| file(&archive_at(*angle))).collect(),
                None => vec![file(SITE)],
            },
            points: file("points.csv"),
            months: file("months.csv"),
            ground: has_ground.then(|| ["ground.csv", "ground_months.csv"].map(file)),
            energy: has_power.then(|| ["energy.csv", "energy_months.csv"].map(file)),
            energy_years: has_power.then(|| file("energy_years.csv")),
            hours: file(&format!("hourly.{}", request.format)),
            horizon_table: file("horizons.csv"),
            horizons: file("horizon"),
            shade: file("shade"),
            search: file("search.csv"),
            best: file("best.csv"),
            turns: file("turns"),
            folder,
        }
    }

    /// Leaves out the table of years if there is one year only.
    pub fn knowing(self, years: Years) -> Self {
        PvFolder { energy_years: self.energy_years.filter(|_| years == Years::Several), ..self }
    }

    /// Returns the archive of the modules, of trackers that of the level ones.
    pub fn archive(&self) -> &Path {
        self.archives.get(self.archives.len() / 2).map_or(Path::new(""), PathBuf::as_path)
    }

    /// Returns the path of a point's horizon, relative to the folder.
    pub fn list_of(point: &str) -> String {
        format!("horizon/{}", horizon::file_of(point))
    }

    /// Returns the path of the picture of a point's orientations, relative to the folder.
    pub fn picture_of(point: &str) -> String {
        format!("turns/{point}.svg")
    }

    /// Returns the tables that are written.
    fn tables(&self, request: &PvRequest) -> Vec<&Path> {
        let mut tables: Vec<&Path> = vec![&self.points, &self.months];
        tables.extend(self.ground.iter().chain(&self.energy).flatten().map(PathBuf::as_path));
        tables.extend(self.energy_years.as_deref());
        if request.points.is_some() {
            tables.push(&self.horizon_table);
        }
        if request.hourly {
            tables.push(&self.hours);
        }
        if request.search {
            tables.extend([self.search.as_path(), &self.best]);
        }
        tables
    }

    /// Refuses to replace an input, a folder or a device.
    pub fn guard(&self, site: &SceneFiles, request: &PvRequest) -> Result<()> {
        let inputs = [
            Some(request.weather.as_path()),
            request.points.as_deref(),
            request.rows.as_deref(),
            request.accuracy.error_weather.as_deref(),
            request.energy.value.as_deref(),
        ];
        let tables = self.tables(request);
        let outputs = tables.iter().flat_map(|table| files_of(table)).chain(self.archives.iter().cloned());
        let outputs = outputs.chain(["receivers.csv", GEOMETRY, MATERIALS, PLAIN].map(|name| self.folder.join(name)));
        for output in outputs {
            guard_site(&output, site, &inputs)?;
        }
        self.archives.iter().try_for_each(|archive| guard_archive(archive))
    }

    /// Refuses to replace results of other weather or of other modules, before any work.
    pub fn check_weather(&self, weather: &Weather, request: &PvRequest) -> Result<()> {
        if request.replace {
            return Ok(());
        }
        if let Some(other) = self.other_archives()?.first() {
            let what = format!("holds {}, an archive of other modules or angles", other.display());
            return Err(Error::input(&self.folder, None, what, KEEP_OR_REPLACE).because(Problem::OtherInputs));
        }
        MadeFrom::check(&self.folder, weather, self.tables(request).into_iter().map(Path::to_owned))
    }

    /// Returns archives of modules in the folder that a run with other rows left.
    fn other_archives(&self) -> Result<Vec<PathBuf>> {
        let angles = self.folder.join(ANGLES);
        let mut all = vec![self.folder.join(SITE)];
        if angles.is_dir() {
            for entry in fs::read_dir(&angles).map_err(Error::io(&angles, "list"))? {
                let path = entry.map_err(Error::io(&angles, "list"))?.path();
                // Other names are of files that `pv` did not write.
                let is_angle = path.file_stem().is_some_and(|stem| stem.to_string_lossy().parse::<f64>().is_ok());
                all.extend(is_angle.then_some(path));
            }
        }
        let is_other = |path: &PathBuf| path.extension().is_some_and(|end| end == "helio") && path.is_file();
        all.retain(|path| is_other(path) && !self.archives.contains(path));
        all.sort();
        Ok(all)
    }

    /// Records that the folder belongs to this archive and weather, so that results can be written
    /// there.
    pub fn claim(
        &self,
        archive: &Archive,
        weather: &Weather,
        request: &PvRequest,
        spots: &Spots,
        observer: &dyn Observer,
    ) -> Result<()> {
        let in_folder = |path: &Path| path.strip_prefix(&self.folder).ok().map(|name| name.display().to_string());
        let mut names: Vec<String> =
            self.tables(request).iter().flat_map(|table| files_of(table)).filter_map(|file| in_folder(&file)).collect();
        // Names are built by hand, so that they have the same form on all systems.
        for point in spots.list.iter().map(|spot| &spot.name) {
            names.extend(request.points.is_some().then(|| PvFolder::list_of(point)));
            names.extend(request.search.then(|| PvFolder::picture_of(point)));
        }
        if request.shade {
            names.extend(files_of(Path::new(shade::TABLE)).iter().map(|name| format!("shade/{}", name.display())));
            names.extend(shade::LAYOUTS.map(|name| format!("shade/{name}")));
        }
        let options = request.value_options();
        let mut now = MadeFrom::new(archive, weather, &request.weather, names).with_options(options);
        now.claim(&self.folder, request.replace, observer)?;
        self.other_archives()?.iter().try_for_each(|other| fs::remove_file(other).map_err(Error::io(other, "remove")))
    }

    /// Returns the names of the tables, relative to the folder.
    pub fn names(&self, request: &PvRequest) -> Vec<String> {
        let name = |file: &Path| file.strip_prefix(&self.folder).unwrap_or(file).display().to_string();
        self.tables(request).into_iter().map(name).collect()
    }
}
