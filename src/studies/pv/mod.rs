//! Light on solar modules and on the ground among them. In: a scene, weather, places. Out: a folder
//! with sums, hours, shading losses, horizons and, if requested, the best orientations and the
//! energy of the array.

mod aside;
mod bypass;
mod energy;
mod folder;
mod ground;
mod light;
mod module_build;
mod modules;
mod open_plain;
mod pvwatts;
mod request;
mod search;
mod shade;
mod spots;
mod summary;
mod tables;
mod tracked;
mod worth;

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use energy::{Plant, WeatherRows};
use folder::PvFolder;
use ground::GroundSpot;
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::siting::Siting;
use heliotile_core::error::{Error, Problem, Result, check_ranges};
use heliotile_core::observer::Observer;
use heliotile_core::site::north::North;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::resources::Resources;
use heliotile_scene::Scene;
use heliotile_scene::covering::surfaces::Surfaces;
use heliotile_scene::load::ObjectTriangles;
use heliotile_scene::points::places::{PlacePoint, PointDefaults, read_points};
use heliotile_scene::pv::rows::{RowsOfModules, read_rows};
use heliotile_scene::pv::tracker::Tracker;
use heliotile_scene::site::{Part, SceneFiles};
use heliotile_weather::distance::far_apart;
use light::Light;
use module_build::ModuleBuild;
use modules::{GEOMETRY, LaidRows, MATERIALS, PLAIN, plain_below};
use spots::Spots;
use tables::Results;
use tempfile::NamedTempFile;
use tracked::{TrackedLight, Tracking};

pub use energy::{EnergyRequest, Mounting};
pub use request::PvRequest;
pub(crate) use spots::placed;
pub use worth::Price;

/// Result of a study.
#[derive(Clone, Debug)]
pub struct PvDone {
    /// Folder with all files.
    pub folder: PathBuf,
    /// Path of the archive.
    pub archive: PathBuf,
    /// Names of the tables, relative to the folder.
    pub files: Vec<String>,
    /// Sums of sides and the best orientations, as a text.
    pub table: String,
}

/// Points or rows of modules of a study.
enum ModuleSource {
    Points(Vec<PlacePoint>),
    Rows(Vec<RowsOfModules>),
}

impl ModuleSource {
    /// Returns true if receivers on the ground are requested.
    fn has_ground(&self) -> bool {
        matches!(self, ModuleSource::Rows(all) if all.iter().any(|rows| rows.ground_step_m.is_some()))
    }

    /// Returns a file of an open plain for rows without a scene; it lasts as long as it is held.
    fn plain(&self, request: &PvRequest) -> Result<Option<NamedTempFile>> {
        let has_scene = !request.scene.files.is_empty() || !request.scene.surface.is_none();
        let rows = match self {
            ModuleSource::Rows(rows) if !has_scene => rows,
            _ => return Ok(None),
        };
        let text = plain_below(request.modules_file(), rows)?;
        let file = tempfile::Builder::new().suffix(".obj").tempfile();
        let file = file.map_err(Error::io(&std::env::temp_dir(), "make a file in"))?;
        fs::write(file.path(), text).map_err(Error::io(file.path(), "write"))?;
        Ok(Some(file))
    }

    /// Returns the trackers of rows, which all turn alike; `None` of fixed modules.
    fn tracker(&self) -> Option<Tracker> {
        match self {
            ModuleSource::Rows(all) => all.first().and_then(|rows| rows.tracker),
            ModuleSource::Points(_) => None,
        }
    }

    /// Returns true if modules state a rated power.
    fn has_power(&self) -> bool {
        match self {
            ModuleSource::Points(points) => points.iter().any(|point| point.rating.kwp.is_some()),
            ModuleSource::Rows(all) => all.iter().any(|rows| rows.rating.kwp.is_some()),
        }
    }
}

impl PvRequest {
    /// Writes the folder; `about` is the provenance that results state.
    pub fn write(&self, about: Provenance, resources: &Resources) -> Result<PvDone> {
        check_ranges(self)?;
        run(self, about, resources)
    }

    fn wanted(&self, observer: &dyn Observer) -> Result<ModuleSource> {
        match (&self.points, &self.rows) {
            (Some(file), None) => {
                let mut warnings = Vec::new();
                let defaults = PointDefaults { needs_turns: !self.search, height_m: None };
                let points = read_points(file, defaults, &mut warnings)?;
                warnings.iter().for_each(|text| observer.warn(text));
                Ok(ModuleSource::Points(points))
            }
            (None, Some(file)) => read_rows(file).map(ModuleSource::Rows),
            _ => Err(Error::argument("points, rows", "neither is given", "give a table of points, or rows")),
        }
    }
}

fn run(request: &PvRequest, about: Provenance, resources: &Resources) -> Result<PvDone> {
    let observer = resources.observer;
    let mut site = request.scene.site()?;
    let wanted = request.wanted(observer)?;
    let has_power = request.energy.kwp.is_some() || wanted.has_power();
    let tracker = wanted.tracker();
    if tracker.is_some() && request.shade {
        let hint = "leave {shade} out: beam.csv and its kin hold one share for each direction of the sun";
        return Err(Error::argument("shade", "is for fixed modules, and the shade of trackers turns", hint)
            .because(Problem::excludes("tracker")));
    }
    let files = PvFolder::new(request, tracker, wanted.has_ground(), has_power);
    files.guard(&site, request)?;
    let plain = wanted.plain(request)?;
    if let Some(plain) = &plain {
        site.parts.push(Part::plain(plain.path(), request.scene.materials.as_deref()));
    }
    // Weather is read before the scene, which takes longer: a wrong weather file fails at once.
    let mut loaded = None;
    let mut place = || Ok(loaded.insert(load(&site, &wanted, observer)?).0.place);
    let about_weather = WeatherOptions { with_air: has_power, ..request.about_weather };
    let weather = resources.weather(&request.weather, &about_weather, &mut place)?;
    let dated = light::rows_of(request, &weather, observer)?;
    let files = files.knowing(dated.years);
    files.check_weather(&weather, request)?;
    let (scene, soup) = loaded.map_or_else(|| load(&site, &wanted, observer), Ok)?;
    scene.place.and_then(|place| far_apart(&place, &weather)).iter().for_each(|apart| observer.warn(apart));
    let light = Light::new(request, &weather, &dated, *resources);
    let north = North::new(scene.place.as_ref());

    let prepared = PreparedScene::new(&scene)?;
    let siting = Siting::new(&prepared);
    let laid = match &wanted {
        ModuleSource::Points(_) => None,
        ModuleSource::Rows(rows) => {
            let surfaces = Surfaces::find(&soup, &scene.materials);
            Some(LaidRows::lay(request.modules_file(), rows.clone(), &surfaces, &siting, north, observer)?)
        }
    };
    let mut spots = match (&wanted, &laid) {
        (ModuleSource::Points(points), _) => Spots::of_points(request.modules_file(), points, &siting, &scene)?,
        (_, laid) => Spots::of_modules(laid.iter().flat_map(LaidRows::modules), &siting),
    };
    if tracker.is_some() {
        tracked::check_size(spots.list.len(), weather.rows.len())?;
    }
    let ground = match &laid {
        Some(laid) => GroundSpot::among(request.modules_file(), laid, &siting, observer)?,
        None => Vec::new(),
    };
    let modules_file = request.modules_file();
    let weather_rows = WeatherRows { file: &request.weather, weather: &weather, dated: &dated };
    let plant = Plant::new(&request.energy, modules_file, &spots.list, weather_rows, resources)?;
    fs::create_dir_all(&files.folder).map_err(Error::io(&files.folder, "create"))?;
    let beside = tempfile::Builder::new().prefix(".pv").tempdir_in(&files.folder);
    let beside = beside.map_err(Error::io(&files.folder, "make a folder in"))?;
    let searched = match request.search {
        true => search::run(request, &light, &prepared, &spots)?,
        false => Vec::new(),
    };
    spots.turn_unturned(&searched);
    let build = ModuleBuild { request, site: &site, scene: &scene, files: &files, resources, north, observer };
    let archives = match (tracker, &laid) {
        (Some(tracker), Some(laid)) => build.trace_angles(tracker, laid, &siting, beside.path())?,
        _ => vec![build.trace(&spots, &ground, laid.as_ref(), files.archive(), beside.path())?],
    };
    let archive = &archives[archives.len() / 2];
    if let Some(plain) = &plain {
        // A copy would keep the mode of a temporary file, which only its owner can read.
        let text = fs::read(plain.path()).map_err(Error::io(plain.path(), "read"))?;
        let to = beside.path().join(PLAIN);
        fs::write(&to, text).map_err(Error::io(&to, "write"))?;
    }
    let modules: &[&str] = if laid.is_some() { &[GEOMETRY, MATERIALS] } else { &[] };
    for name in ["receivers.csv"].iter().chain(modules).chain(plain.as_ref().map(|_| &PLAIN)) {
        let to = files.folder.join(name);
        fs::rename(beside.path().join(name), &to).map_err(Error::io(&to, "rename to"))?;
    }
    observer.stop_if_cancelled("after the archive was complete")?;
    files.claim(archive, &weather, request, &spots, observer)?;
    let tracked = match (tracker, &laid) {
        (Some(tracker), Some(laid)) => {
            let tracking = Tracking::new(laid, tracker, Arc::clone(&light.hours(archive)?.conditions));
            Some(TrackedLight::new(tracking, &light, &archives, archive, &spots, &prepared, beside.path())?)
        }
        _ => None,
    };

    let about = about
        .with_archive(files.archive(), archive)
        .with_weather(&request.weather, &weather)
        .with_option("steps", light.steps(archive))
        .with_option("patches", archive.manifest().settings.patches());
    let results = Results {
        request,
        files: &files,
        light: &light,
        archive,
        spots: &spots,
        ground: &ground,
        tracked: tracked.as_ref(),
        about: &about,
    };
    let (sides, on_ground, energy) = results.write(&scene, &siting, north, plant)?;
    if request.search {
        results.write_search(&searched)?;
    }
    light.notes(request).iter().for_each(|text| observer.note(text));
    let hours = light.interval_hours() * light.hours(archive)?.conditions.len() as f64;
    let mut table = summary::table(&sides, &searched, &on_ground, &request.weather, hours);
    table.extend(energy.map(|energy| format!("\n{}", energy.sentence())));
    let archive = files.archive().to_owned();
    Ok(PvDone { files: files.names(request), archive, folder: files.folder, table })
}

/// Loads the scene; its objects are loaded only for rows, which may name surfaces.
fn load(site: &SceneFiles, wanted: &ModuleSource, observer: &dyn Observer) -> Result<(Scene, ObjectTriangles)> {
    let loaded = match wanted {
        ModuleSource::Points(_) => (Scene::load_site(site)?, ObjectTriangles::default()),
        ModuleSource::Rows(_) => Scene::load_with_objects(site)?,
    };
    loaded.0.report.tell(observer);
    Ok(loaded)
}
