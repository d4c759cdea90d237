//! Run from scene files to a year's sun. In: a scene, weather. Out: a folder with receivers, the
//! archive, sums and a map. An existing archive that still fits is not traced again.

mod folder;
pub mod made_from;
mod maps;
mod passes;

use std::path::{Path, PathBuf};

use crate::covering::{CoverRequest, cover_site};
use crate::site_build::{FolderOption, ReceiverSource, SiteBuild, SiteFolder};
use crate::sunlight::{SunlightRequest, SunlightSite};
use folder::RunFiles;
use heliotile_builder::planning::parse_negligible;
use heliotile_requests::{OutputKind, Request, Role};
use heliotile_results::archives::Archives;
use heliotile_results::files::OutputRequest;
use heliotile_results::outputs::periods::Every;
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::tables::format::table_endings;
use heliotile_results::outputs::tables::layout::By;
use heliotile_results::outputs::viewer_page::ViewerPage;
use heliotile_results::receivers::ReceiverSet;
use heliotile_results::resources::Resources;

pub use folder::folder_beside;
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::planning::{AccuracyRequest, EffectsUnder};
use heliotile_core::archive::Archive;
use heliotile_core::error::{Result, check_ranges};
use heliotile_core::weather::options::{StampedAt, WeatherOptions};
use heliotile_remote::places::hold;
use heliotile_scene::Scene;
use heliotile_scene::request::SceneRequest;
use heliotile_scene::site::SceneFiles;
use heliotile_weather::distance::far_apart;
use heliotile_weather::series::Weather;
use passes::RunResults;

pub use maps::RunMap;

/// Request for a run.
#[derive(Clone, Debug, Request)]
#[request(also = usual_folder)]
pub struct RunRequest {
    /// Scene to trace.
    #[field(flatten, without("grid_north"))]
    pub scene: SceneRequest,
    /// Weather file: EPW, TMY3, WEA, SURFRAD, CSV or JSON of a service (NSRDB, PVGIS, Open-Meteo,
    /// Solcast), or any CSV or JSON with `time` and some of ghi, dni, dhi; also packed (.gz, .zip).
    #[field(short = 'w', input = Weather, required)]
    pub weather: PathBuf,
    /// Facts about the weather file that it does not state itself.
    #[field(flatten, without("latitude", "longitude"), heading = "About the weather file")]
    pub about_weather: WeatherOptions,
    /// Folder to write: receivers.csv, site.helio, and a folder for each weather file with
    /// annual.csv and annual.png [default: the name of the first scene file, with .sun].
    #[field(name = "output", short = 'o', metavar = "FOLDER", output = Folder(&["receivers.csv"]))]
    pub folder: Option<PathBuf>,
    /// Surfaces that get receivers, if `receivers` is `None`.
    #[field(flatten)]
    pub cover: CoverRequest,
    /// Table of receivers in place of those that cover surfaces, CSV with columns
    /// receiver,x,y,z,nx,ny,nz and optionally area,surface.
    #[field(short = 'r', conflicts("on", "spacing", "per_surface", "offset", "min_area"), input = Receivers)]
    pub receivers: Option<PathBuf>,
    /// Accuracy of the archive.
    #[field(flatten)]
    pub accuracy: AccuracyRequest,
    /// Leave out light paths that add no more than this share of the sum over the weather file, in
    /// any group of receivers, such as 0.5%.
    #[field(metavar = "PERCENT", parse = parse_negligible)]
    pub negligible_percent: Option<f64>,
    /// Leave the scene's triangles out of the archive, if they may not be passed on.
    #[field(negated = "no_scene", python = "with_scene")]
    pub with_scene: bool,
    /// Archive of this scene before a change, a path or an address: only light that the change can
    /// alter is traced, with the same results as without this option.
    #[field(python = "before", metavar = "BEFORE.helio", input = Archive)]
    pub from: Option<PathBuf>,
    /// Also write a table by hour, day, month, year or total, as `replay` does: months.csv and so
    /// on; several with commas.
    #[field(metavar = "PERIOD", delimiter = ',')]
    pub every: Vec<Every>,
    /// Also check a rule of sunlight and write rules.csv: a name that `heliotile info --rule all`
    /// lists, or a file with rules of your own (.toml); may be repeated.
    #[field(name = "rule", python = "rules", metavar = "NAME|FILE")]
    pub rules: Vec<String>,
    /// Grouping of rows in the tables of --every and --rule: what each row stands for.
    #[field(default = "receiver", requires("every", "rule"))]
    pub by: By,
    /// Time that labels a row of hours: the start, middle or end of its interval.
    #[field(default = "start", requires("every"))]
    pub stamp: StampedAt,
    /// Year of all dates in the tables of --every, such as 2019, as for `replay`; annual sums stay
    /// as they are.
    #[field(range = 1..=2999, requires("every"))]
    pub year: Option<i32>,
    /// Ending of the tables of --every and --rule, which chooses their format.
    #[field(default = "csv", requires("every", "rule"), choices = table_endings)]
    pub format: String,
    /// Also write the annual sums as a map in this format, such as annual.glb beside annual.csv, or
    /// into the city model of the scene; may be repeated, or several with commas.
    #[field(name = "map", python = "maps", metavar = "FORMAT", delimiter = ',', neutral)]
    pub maps: Vec<RunMap>,
    /// Replace results in the folder that are of another scene, spacing, accuracy or weather;
    /// without this option they are an error.
    #[field(neutral)]
    pub replace: bool,
}

/// Hands on the folder that a run writes if none is given.
fn usual_folder(request: &RunRequest, each: &mut dyn FnMut(&'static str, Role, &Path)) {
    if request.folder.is_none() {
        each(
            "output",
            Role::Output(OutputKind::Folder(&["receivers.csv"])),
            &folder_beside(request.scene.first(), "sun"),
        );
    }
}

/// Result of a run.
#[derive(Clone, Debug)]
pub struct RunDone {
    /// Folder with all files.
    pub folder: PathBuf,
    /// Path of the archive.
    pub archive: PathBuf,
    /// Names of all files, relative to the folder.
    pub files: Vec<String>,
    /// Sums by kind of surface and side, as a text.
    pub table: String,
}

impl Default for RunRequest {
    fn default() -> Self {
        RunRequest::new(SceneRequest::default(), "")
    }
}

impl RunRequest {
    /// Returns a run with default receivers and accuracy: annual sums and a map.
    pub fn new(scene: SceneRequest, weather: impl Into<PathBuf>) -> Self {
        RunRequest {
            scene,
            weather: weather.into(),
            about_weather: WeatherOptions::default(),
            folder: None,
            cover: CoverRequest::default(),
            receivers: None,
            accuracy: AccuracyRequest::default(),
            negligible_percent: None,
            with_scene: true,
            from: None,
            every: Vec::new(),
            rules: Vec::new(),
            by: By::default(),
            stamp: StampedAt::default(),
            year: None,
            format: "csv".to_owned(),
            maps: Vec::new(),
            replace: false,
        }
    }

    /// Writes the folder; `about` is the provenance that results state.
    pub fn write(&self, about: Provenance, resources: &Resources) -> Result<RunDone> {
        check_ranges(self)?;
        let site = self.scene.site()?;
        let files = RunFiles::new(self, &site);
        files.guard(&site, self)?;
        let sunlight = self.sunlight();
        let rules = OutputRequest { by: self.by, ..OutputRequest::new(files.rules(self)) };
        sunlight.iter().try_for_each(|request| request.check(&rules, &[&self.weather]))?;
        let city_model = self.maps.contains(&RunMap::CityModel).then(|| maps::city_model_of(&site)).transpose()?;
        let (archive, weather) = self.archive(&site, &files, resources)?;
        resources.observer.stop_if_cancelled("after site.helio was complete")?;
        files.claim(&archive, &weather, self, resources.observer)?;
        let results =
            RunResults { request: self, files: &files, city_model, archive: &archive, weather: &weather, about };
        let table = results.write(resources)?;
        if let Some(request) = &sunlight {
            let receivers = ReceiverSet::all_of(&archive)?;
            let (archives, place, folder) = (Archives::one(&archive), &*files.archive, &*files.folder);
            let site = SunlightSite { archives, receivers: &receivers, place, folder };
            let done = request.write(&rules, &site, None, results.about.clone(), resources)?;
            resources.observer.report(done.text());
        }
        self.write_page(&files, resources)?;
        Ok(RunDone { files: files.names(self), folder: files.folder, archive: files.archive, table })
    }

    /// Returns the request for rules of sunlight, if there are rules.
    fn sunlight(&self) -> Option<SunlightRequest> {
        (!self.rules.is_empty()).then(|| SunlightRequest {
            rules: self.rules.clone(),
            weather: Some(self.weather.clone()),
            about_weather: self.about_weather,
            ..SunlightRequest::default()
        })
    }

    /// Builds or opens the archive of the scene, and reads the weather. The scene is dropped
    /// afterwards, which frees its memory.
    fn archive(&self, site: &SceneFiles, files: &RunFiles, resources: &Resources) -> Result<(Archive, Weather)> {
        let observer = resources.observer;
        let load = || match self.receivers {
            Some(_) => {
                let scene = Scene::load_site(site)?;
                scene.report.tell(observer);
                Ok((scene, None))
            }
            None => cover_site(site, &self.cover, observer).map(|(scene, covered)| (scene, Some(covered))),
        };
        // Weather is read before the scene, which takes longer: a wrong weather file fails at once.
        let mut loaded = None;
        let mut place = || Ok(loaded.insert(load()?).0.place);
        let weather = resources.weather(&self.weather, &self.about_weather, &mut place)?;
        files.check_weather(&weather, self)?;
        let (scene, covered) = loaded.map_or_else(load, Ok)?;
        scene.place.and_then(|place| far_apart(&place, &weather)).iter().for_each(|apart| observer.warn(apart));
        maps::check(&self.maps, scene.place.as_ref())?;
        if scene.place.is_none() {
            observer.note(
                "no file states the place of the scene: y is taken for north, and maps have no coordinate system \
                 ({crs}, or {latitude} and {longitude})",
            );
        }
        let under = match self.negligible_percent {
            Some(_) => Some(ErrorConditions::of_weather(&self.weather, weather.clone())?),
            None => None,
        };
        let negligible_percent = self.negligible_percent;
        let table = &files.receivers;
        let receivers = match &covered {
            Some(placed) => ReceiverSource::Placed { placed, offset_m: self.cover.offset_m, table },
            None => ReceiverSource::from(table),
        };
        let accuracy = self.accuracy.beside(Some(&self.weather), &self.about_weather);
        let build = SiteBuild {
            under: under.as_ref().map(|weather| EffectsUnder { weather, negligible_percent }),
            with_scene: self.with_scene,
            from: self.from.as_deref(),
            memory: resources.memory,
            files: resources.files,
            ..SiteBuild::new(&scene, receivers, &accuracy)
        };
        let folder = SiteFolder {
            folder: &files.folder,
            archive: &files.archive,
            replace: self.replace,
            named_by: FolderOption::Output,
        };
        let archive = build.ensure(&folder, observer)?;
        Ok((archive, weather))
    }

    /// Writes the page that shows the archive under this weather. The page reads a large archive
    /// from its file.
    fn write_page(&self, files: &RunFiles, resources: &Resources) -> Result<()> {
        let page = ViewerPage::default()
            .with_archive(&files.archive, hold(&files.archive)?.as_ref())?
            .with_weather(&self.weather, &(resources.files)(&self.weather)?)?
            .with_weather_options(&self.about_weather);
        let page = if page.holds_archive() { page } else { page.with_option("archive", "../site.helio") };
        page.write(&files.page)
    }
}
