//! Light on solar modules and on the ground among them. In: a scene, weather, places. Out: a folder
//! with sums, hours, shading losses, horizons and, if requested, the best orientations. The engine
//! computes light up to the module; electrical models are left to pvlib.

mod folder;
mod ground;
mod light;
mod modules;
mod open_plain;
mod search;
mod spots;
mod summary;
mod tables;

use std::fs;
use std::path::{Path, PathBuf};

use crate::site_build::{FolderOption, SiteBuild, SiteFolder};
use folder::PvFolder;
use ground::GroundSpot;
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::planning::AccuracyRequest;
use heliotile_builder::siting::Siting;
use heliotile_core::error::{Error, Result, check_ranges};
use heliotile_core::observer::Observer;
use heliotile_core::orientation::fan::OrientationLimits;
use heliotile_core::replay::reflectances::Snow;
use heliotile_core::site::north::North;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::options::{StampedAt, WeatherOptions};
use heliotile_requests::Request;
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::tables::format::table_endings;
use heliotile_results::resources::Resources;
use heliotile_scene::Scene;
use heliotile_scene::covering::surfaces::Surfaces;
use heliotile_scene::load::ObjectTriangles;
use heliotile_scene::points::places::{PlacePoint, PointDefaults, read_points};
use heliotile_scene::pv::rows::{RowsOfModules, read_rows};
use heliotile_scene::request::SceneRequest;
use heliotile_scene::site::SceneFiles;
use heliotile_weather::distance::far_apart;
use light::Light;
use modules::{GEOMETRY, LaidRows, MATERIALS};
use spots::Spots;
use tables::Results;

pub(crate) use spots::placed;

/// Request for a study of modules.
#[derive(Clone, Debug, Request)]
#[request(exactly_one("points", "rows"))]
pub struct PvRequest {
    /// Scene around the modules.
    #[field(flatten)]
    pub scene: SceneRequest,
    /// Weather file: EPW, TMY3, WEA, SURFRAD, CSV or JSON of a service (NSRDB, PVGIS, Open-Meteo,
    /// Solcast), or any CSV or JSON with `time` and some of ghi, dni, dhi; also packed (.gz, .zip).
    #[field(short = 'w', input = Weather, required)]
    pub weather: PathBuf,
    /// Facts about the weather file that it does not state itself.
    #[field(flatten, without("latitude", "longitude"), heading = "About the weather file")]
    pub about_weather: WeatherOptions,
    /// Positions of modules, CSV with columns point,x,y, z or height (metres above the roof or
    /// ground below), and tilt_deg,azimuth_deg (from true north; may be left out with --search).
    #[field(short = 'p', metavar = "FILE", input = Any)]
    pub points: Option<PathBuf>,
    /// Rows of modules, TOML: each table `rows` has a name, an area or surface, tilt, azimuth,
    /// pitch, width, height. Modules shade each other, reflect light to each other, and have a
    /// front and a rear. `ground = 0.5` adds receivers on the ground among the rows, 0.5 m apart,
    /// with the light that plants use.
    #[field(short = 'r', metavar = "FILE", input = Any)]
    pub rows: Option<PathBuf>,
    /// Bifaciality, the share of the light on the rear that is added to that on the front, for
    /// poa_global and the gain.
    #[field(default = 0.8, range = 0.0..=1.0, says = "give a share from 0 to 1, as in 0.8")]
    pub bifaciality: f64,
    /// Folder to write: points.csv, months.csv, ground.csv, ground_months.csv, hourly.csv,
    /// horizon/, best.csv and the archive site.helio.
    #[field(name = "output", short = 'o', metavar = "FOLDER", output = Folder(&[]), required)]
    pub folder: PathBuf,
    /// Find the best tilt and azimuth of every point: best.csv, search.csv and a picture of each;
    /// points without angles get the best ones.
    #[field(requires("points"))]
    pub search: bool,
    /// Range of tilts for --search, degrees, such as 10..60, or one tilt.
    #[field(metavar = "FROM..TO", default = "0..90", parse = parse_tilts)]
    pub tilts_deg: [f64; 2],
    /// Range of azimuths for --search, degrees clockwise from true north, such as 90..270, or
    /// 300..60 through north, or one azimuth.
    #[field(metavar = "FROM..TO", default = "0..360", parse = parse_azimuths)]
    pub azimuths_deg: [f64; 2],
    /// Model of the sky's radiance distribution.
    #[field(help = SkyModel::described, default = "perez")]
    pub sky: SkyModel,
    /// Ending of the table of hours, which chooses its format.
    #[field(default = "csv", choices = table_endings)]
    pub format: String,
    /// Write no hourly table, sums only.
    #[field(conflicts("format"), negated = "no_hourly")]
    pub hourly: bool,
    /// Time that labels a row of hours: the start, middle or end of its interval.
    #[field(default = "start")]
    pub stamp: StampedAt,
    /// Year of all dates in results, such as 2019; sun positions stay those of the weather file's
    /// dates.
    #[field(range = 1..=2999)]
    pub year: Option<i32>,
    /// Take the reflectance of all ground from the weather file: its snow depth (--snow-reflectance
    /// from 1 cm on) or its albedo.
    pub snow: Option<Snow>,
    /// Diffuse reflectance of snow.
    #[field(default = 0.6, requires("snow"), range = 0.0..=1.0, says = "give a share of the light, from 0 to 1")]
    pub snow_reflectance: f64,
    /// Accuracy of the archive.
    #[field(flatten)]
    pub accuracy: AccuracyRequest,
    /// Replace results in the folder that are of another scene, points, accuracy or weather;
    /// without this option they are an error.
    #[field(neutral)]
    pub replace: bool,
}

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
}

impl Default for PvRequest {
    fn default() -> Self {
        let mut request = PvRequest::new(SceneRequest::default(), "", "", "");
        request.points = None;
        request
    }
}

impl PvRequest {
    /// Writes the folder; `about` is the provenance that results state.
    pub fn write(&self, about: Provenance, resources: &Resources) -> Result<PvDone> {
        check_ranges(self)?;
        run(self, about, resources)
    }
}

fn run(request: &PvRequest, about: Provenance, resources: &Resources) -> Result<PvDone> {
    let observer = resources.observer;
    let mut site = request.scene.site()?;
    let wanted = request.wanted(observer)?;
    let files = PvFolder::new(request, wanted.has_ground());
    files.guard(&site, request)?;
    // Weather is read before the scene, which takes longer: a wrong weather file fails at once.
    let mut loaded = None;
    let mut place = || Ok(loaded.insert(load(&site, &wanted, observer)?).0.place);
    let weather = resources.weather(&request.weather, &request.about_weather, &mut place)?;
    files.check_weather(&weather, request)?;
    let (scene, soup) = loaded.map_or_else(|| load(&site, &wanted, observer), Ok)?;
    scene.place.and_then(|place| far_apart(&place, &weather)).iter().for_each(|apart| observer.warn(apart));
    let dated = light::rows_of(request, &weather, observer)?;
    let light = Light::new(request, &weather, &dated, *resources);
    let north = North::new(scene.place.as_ref());

    let prepared = PreparedScene::new(&scene)?;
    let siting = Siting::new(&prepared);
    let laid = match &wanted {
        ModuleSource::Points(_) => None,
        ModuleSource::Rows(rows) => {
            let surfaces = Surfaces::find(&soup, &scene.materials);
            Some(LaidRows::lay(request.rows_file(), rows.clone(), &surfaces, &siting, north, observer)?)
        }
    };
    let mut spots = match (&wanted, &laid) {
        (ModuleSource::Points(points), _) => Spots::of_points(request.points_file(), points, &siting, &scene)?,
        (_, laid) => Spots::of_modules(laid.iter().flat_map(LaidRows::modules), &siting),
    };
    let ground = match &laid {
        Some(laid) => GroundSpot::among(request.rows_file(), laid, &siting, observer)?,
        None => Vec::new(),
    };
    fs::create_dir_all(&files.folder).map_err(Error::io(&files.folder, "create"))?;
    let beside = tempfile::Builder::new().prefix(".pv").tempdir_in(&files.folder);
    let beside = beside.map_err(Error::io(&files.folder, "make a folder in"))?;
    let searched = match request.search {
        true => search::run(request, &light, &prepared, &spots)?,
        false => Vec::new(),
    };
    spots.turn_unturned(&searched);
    // Modules shade and reflect, so they are part of the traced scene.
    let with_modules = match &laid {
        Some(laid) => {
            laid.add_to(&mut site, beside.path())?;
            Some(Scene::load_site(&site)?)
        }
        None => None,
    };
    let traced = with_modules.as_ref().unwrap_or(&scene);
    let receivers = spots.write_receivers(&ground, beside.path(), north)?;
    let accuracy = request.accuracy.beside(Some(&request.weather), &request.about_weather);
    let build =
        SiteBuild { memory: resources.memory, files: resources.files, ..SiteBuild::new(traced, &receivers, &accuracy) };
    let folder = SiteFolder {
        folder: &files.folder,
        archive: &files.archive,
        replace: request.replace,
        named_by: FolderOption::Output,
    };
    let archive = build.ensure(&folder, observer)?;
    let parts: &[&str] = if laid.is_some() { &["receivers.csv", GEOMETRY, MATERIALS] } else { &["receivers.csv"] };
    for name in parts {
        let to = files.folder.join(name);
        fs::rename(beside.path().join(name), &to).map_err(Error::io(&to, "rename to"))?;
    }
    observer.stop_if_cancelled("after site.helio was complete")?;
    files.claim(&archive, &weather, request, &spots)?;

    let about = about
        .with_archive(&files.archive, &archive)
        .with_weather(&request.weather, &weather)
        .with_option("steps", light.steps(&archive))
        .with_option("patches", archive.manifest().settings.patches());
    let results = Results {
        request,
        files: &files,
        light: &light,
        archive: &archive,
        spots: &spots,
        ground: &ground,
        about: &about,
    };
    let (sides, on_ground) = results.write(&scene, &siting, north)?;
    if request.search {
        results.write_search(&searched)?;
    }
    light.notes(request).iter().for_each(|text| observer.note(text));
    let table = summary::table(&sides, &searched, &on_ground, &request.weather);
    Ok(PvDone { files: files.names(request), folder: files.folder, archive: files.archive, table })
}

impl PvRequest {
    /// Returns a study of the modules of a table of points.
    pub fn new(
        scene: SceneRequest,
        weather: impl Into<PathBuf>,
        points: impl Into<PathBuf>,
        folder: impl Into<PathBuf>,
    ) -> Self {
        PvRequest {
            scene,
            weather: weather.into(),
            about_weather: WeatherOptions::default(),
            points: Some(points.into()),
            rows: None,
            bifaciality: 0.8,
            folder: folder.into(),
            search: false,
            tilts_deg: [0.0, 90.0],
            azimuths_deg: [0.0, 360.0],
            sky: SkyModel::default(),
            format: "csv".to_owned(),
            hourly: true,
            stamp: StampedAt::default(),
            year: None,
            snow: None,
            snow_reflectance: 0.6,
            accuracy: AccuracyRequest::default(),
            replace: false,
        }
    }

    /// Returns the table of points, for messages.
    fn points_file(&self) -> &Path {
        self.points.as_deref().unwrap_or(Path::new(""))
    }

    /// Returns the file of rows.
    fn rows_file(&self) -> &Path {
        self.rows.as_deref().unwrap_or(Path::new(""))
    }

    /// Returns the orientations that a search may choose.
    fn limits(&self) -> OrientationLimits {
        OrientationLimits { tilts_deg: self.tilts_deg, azimuths_deg: self.azimuths_deg }
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

/// Loads the scene; its objects are loaded only for rows, which may name surfaces.
fn load(site: &SceneFiles, wanted: &ModuleSource, observer: &dyn Observer) -> Result<(Scene, ObjectTriangles)> {
    let loaded = match wanted {
        ModuleSource::Points(_) => (Scene::load_site(site)?, ObjectTriangles::default()),
        ModuleSource::Rows(_) => Scene::load_with_objects(site)?,
    };
    loaded.0.report.tell(observer);
    Ok(loaded)
}

/// Parses `10..60`, or one number for both ends.
fn parse_range(text: &str) -> std::result::Result<[f64; 2], String> {
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{part}` is not a number: give degrees, as in 10..60")),
    };
    match text.split_once("..") {
        Some((from, to)) => Ok([number(from)?, number(to)?]),
        None => Ok([number(text)?; 2]),
    }
}

fn parse_tilts(text: &str) -> std::result::Result<[f64; 2], String> {
    match parse_range(text)? {
        [from, to] if 0.0 <= from && from <= to && to <= 180.0 => Ok([from, to]),
        _ => Err("tilts are from 0 (up) to 180 (down), the smaller one first".into()),
    }
}

fn parse_azimuths(text: &str) -> std::result::Result<[f64; 2], String> {
    let [from, to] = parse_range(text)?;
    if [from, to].iter().any(|azimuth| azimuth.abs() > 360.0) {
        return Err("azimuths are from -360 to 360, clockwise from true north".into());
    }
    let to = if to < from { to + 360.0 } else { to };
    if to - from > 360.0 {
        Err("the range is more than a full circle: give azimuths as in 90..270".into())
    } else {
        Ok([from, to])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ranges, one number and a sector over north are read; 7 wrong texts are refused.
    #[test]
    fn ranges_of_azimuths_may_cross_north() {
        assert_eq!((parse_tilts("10..60"), parse_tilts("30")), (Ok([10.0, 60.0]), Ok([30.0, 30.0])));
        assert_eq!((parse_azimuths("300..60"), parse_azimuths("180")), (Ok([300.0, 420.0]), Ok([180.0, 180.0])));
        assert_eq!(parse_azimuths("-90..90"), Ok([-90.0, 90.0]));
        for text in ["", "200", "60..10", "a..b", "-1..30"] {
            assert!(parse_tilts(text).is_err(), "{text}");
        }
        assert!(parse_azimuths("-360..360").is_err() && parse_azimuths("0..400").is_err());
    }
}
