//! Audit: measures whether an archive is as accurate as it states. In: an archive, its scene,
//! weather or conditions. Out: a report of the differences from an independent reference path
//! tracer.

mod report;
mod texts;

use std::path::PathBuf;
use std::time::Duration;

use super::original;
use heliotile_builder::accuracy::CONDITIONS;
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::reference::{AuditInputs, audit};
use heliotile_core::archive::Access;
use heliotile_core::error::{Error, Result, check_ranges};
use heliotile_core::site::place::Place;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::{Condition, parse_conditions};
use heliotile_core::weather::options::WeatherOptions;
use heliotile_remote::places::open_archive;
use heliotile_requests::{DefaultRequest, Request};
use heliotile_results::resources::Resources;
use heliotile_scene::request::SceneRequest;

pub use report::{AuditReport, ComponentErrors, HourKindErrors, SkyViewErrors, Verdict, WorstPair};

/// Number of receivers that are checked, if neither their number nor a time is given.
const SAMPLES: u32 = 256;

/// Number of hours in which each receiver is checked; a table of up to `FEW` conditions is checked
/// whole.
const HOURS: usize = 8;
const FEW: usize = 64;

/// Request for an audit.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct AuditRequest {
    /// Archive to audit.
    #[field(positional, required, input = Archive)]
    pub archive: PathBuf,
    /// Scene that the archive was built from; the archive states its place.
    #[field(flatten, without("grid_north"))]
    pub scene: SceneRequest,
    /// Weather file from which hours are sampled, 12 positions of the sun in each [default: suns
    /// from all sides].
    #[field(short = 'w', input = Weather)]
    pub weather: Option<PathBuf>,
    /// Facts about the weather file that it does not state itself.
    #[field(flatten, without("latitude", "longitude"), heading = "About the weather file", needs("weather"))]
    pub about_weather: WeatherOptions,
    /// Table of suns and skies in place of weather, as for `replay`:
    /// condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2. If it has up to 64 rows, each
    /// receiver is checked under all of them.
    #[field(short = 'c', metavar = "FILE", conflicts("weather"), input = Conditions)]
    pub conditions: Option<PathBuf>,
    /// Number of receivers to check [default: 256, or as many as --seconds allow].
    #[field(metavar = "N", range = 1..=u32::MAX)]
    pub samples: Option<u32>,
    /// Number of hours to check for each receiver [default: 8, or all rows of --conditions if they
    /// are 64 or fewer].
    #[field(metavar = "N", range = 1..=u32::MAX)]
    pub hours: Option<u32>,
    /// Time limit, seconds: no receiver is started after it.
    #[field(metavar = "S", parse = parse_seconds)]
    pub seconds: Option<f64>,
    /// Number of light paths that the reference path tracer follows from each receiver.
    #[field(metavar = "N", default = 4096, range = 16..=1 << 24)]
    pub paths: u32,
    /// Seed of the random choice of receivers, hours and paths.
    #[field(metavar = "N", default = 1)]
    pub seed: u64,
    /// Sky radiance distribution: perez, uniform, or cie:1 to cie:16.
    #[field(default = "perez")]
    pub sky: SkyModel,
}

/// Suns and skies under which the archive and the reference path tracer are compared.
struct AuditConditions {
    all: Vec<Condition>,
    /// Name of the file of the conditions, or their description in words.
    name: String,
    /// Number of conditions under which each receiver is checked.
    hours: usize,
}

impl AuditRequest {
    /// Refuses numbers that are out of range and choices that exclude each other, before any file
    /// is read.
    pub fn check(&self) -> Result<()> {
        check_ranges(self)?;
        if self.seconds.is_some_and(|seconds| !is_time(seconds)) {
            return Err(Error::argument("seconds", "is not a time", "give a number of seconds above 0"));
        }
        if self.weather.is_some() && self.conditions.is_some() {
            return Err(Error::argument("weather, conditions", "are both given", "give one of them"));
        }
        Ok(())
    }

    /// Compares the archive with the reference path tracer.
    pub fn run(&self, resources: &Resources) -> Result<AuditReport> {
        self.check()?;
        let observer = resources.observer;
        let archive = open_archive(&self.archive, Access::Read)?;
        let site = original::site_of(&self.archive, &self.scene)?;
        let scene = original::scene_of(&archive, &site, self.scene.first(), observer)?;
        let conditions = self.conditions(scene.place, resources)?;
        let left_out = &archive.manifest().settings.left_out;
        if !left_out.is_empty() {
            let left_out = left_out.join(", ");
            observer.report(format!(
                "{} leaves out {left_out}, and so does the reference path tracer\n",
                archive.path().display()
            ));
        }
        let samples = self.samples.unwrap_or(if self.seconds.is_some() { u32::MAX } else { SAMPLES });
        let audited = audit(&AuditInputs {
            archive: &archive,
            scene: &PreparedScene::new(&scene)?,
            conditions: &conditions.all,
            hours: self.hours.map_or(conditions.hours, |hours| hours as usize),
            sky: self.sky,
            samples: samples as usize,
            time: self.seconds.map(Duration::from_secs_f64),
            paths: self.paths as usize,
            seed: self.seed,
            memory: resources.memory,
            storage: resources.storage,
            observer,
        })?;
        Ok(AuditReport::new(&archive, audited, conditions.all, conditions.name, observer))
    }

    /// Reads weather or conditions, and warns of doubtful values.
    fn conditions(&self, place: Option<Place>, resources: &Resources) -> Result<AuditConditions> {
        let Some(path) = &self.conditions else {
            let suns = ErrorConditions::read(
                self.weather.as_deref(),
                &self.about_weather,
                place,
                resources.files,
                resources.observer,
            )?;
            return Ok(AuditConditions { all: suns.some(CONDITIONS), name: suns.name().to_owned(), hours: HOURS });
        };
        let read = parse_conditions(path, &(resources.files)(path)?)?;
        read.warnings.iter().for_each(|text| resources.observer.warn(text));
        let count = read.conditions.len();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(AuditConditions { all: read.conditions, name, hours: if count <= FEW { count } else { HOURS } })
    }
}

/// Returns true if `seconds` is a duration above 0 and below 1e9 s.
pub fn is_time(seconds: f64) -> bool {
    seconds.is_finite() && seconds > 0.0 && seconds < 1e9
}

fn parse_seconds(text: &str) -> std::result::Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| is_time(*seconds));
    seconds.ok_or_else(|| "give a number of seconds above 0".into())
}
