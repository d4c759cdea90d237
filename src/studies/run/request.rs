//! Request for a run. In: options. Out: the scene, the weather, the receivers, the files to write.

use std::fs;
use std::path::{Path, PathBuf};

use crate::covering::CoverRequest;
use crate::run::maps::RunMap;
use crate::sunlight::own_rules;
use heliotile_builder::planning::{AccuracyRequest, parse_negligible};
use heliotile_core::weather::options::{StampedAt, WeatherOptions};
use heliotile_requests::{DefaultRequest, InputKind, OutputKind, Request, Role};
use heliotile_results::outputs::periods::Every;
use heliotile_results::outputs::tables::format::table_endings;
use heliotile_results::outputs::tables::layout::By;
use heliotile_scene::request::SceneRequest;

/// Request for a run.
#[derive(Clone, Debug, Request, DefaultRequest)]
#[request(also = other_files)]
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

/// Hands on the files of the user's own rules, and the folder that a run writes if none is given.
fn other_files(request: &RunRequest, each: &mut dyn FnMut(&'static str, Role, &Path)) {
    own_rules(&request.rules).for_each(|file| each("rule", Role::Input(InputKind::Any), file));
    if request.folder.is_none() {
        each(
            "output",
            Role::Output(OutputKind::Folder(&["receivers.csv"])),
            &folder_beside(request.scene.first(), "sun"),
        );
    }
}

impl RunRequest {
    /// Returns a run with default receivers and accuracy: annual sums and a map.
    pub fn new(scene: SceneRequest, weather: impl Into<PathBuf>) -> Self {
        RunRequest { scene, weather: weather.into(), ..RunRequest::default() }
    }
}

/// Returns the folder of a scene in the working directory: `town.city.json` gives `town.sun`.
pub fn folder_beside(scene: &Path, ending: &str) -> PathBuf {
    let whole = fs::canonicalize(scene).unwrap_or_else(|_| scene.to_owned());
    let name = whole.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.split('.').find(|part| !part.is_empty()).unwrap_or("site");
    PathBuf::from(format!("{stem}.{ending}"))
}
