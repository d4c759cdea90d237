//! Arguments of `run`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};

use crate::cli::values::{Bytes, choice, parse_memory, table_endings};
use crate::cli::{AccuracyArgs, ClockArgs, CoverArgs, Percent, SceneArgs, parse_negligible};
use heliotile::{By, Every, RunMap, RunRequest, StampedAt};

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("tables").args(["every", "rule"]).multiple(true)))]
pub struct RunArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Weather file: EPW, TMY3, WEA, SURFRAD, CSV or JSON of a service (NSRDB, PVGIS, Open-Meteo,
    /// Solcast), or any CSV or JSON with `time` and some of ghi, dni, dhi; also packed (.gz, .zip)
    #[arg(long, short)]
    pub weather: PathBuf,
    /// Folder to write: receivers.csv, site.helio, and a folder for each weather file with
    /// annual.csv and annual.ply [default: the name of the first scene file, with .sun]
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub cover: CoverArgs,
    /// Table of receivers in place of those that cover surfaces, CSV with columns
    /// receiver,x,y,z,nx,ny,nz and optionally area,surface
    #[arg(long, short, conflicts_with_all = ["on", "spacing", "per_surface", "offset", "min_area"])]
    pub receivers: Option<PathBuf>,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Leave out light paths that add no more than this share of the sum over the weather file, in
    /// any group of receivers, such as 0.5%
    #[arg(long, value_name = "PERCENT", value_parser = parse_negligible)]
    pub negligible: Option<Percent>,
    /// Leave the scene's triangles out of the archive, if they may not be passed on
    #[arg(long)]
    pub no_scene: bool,
    /// Archive of this scene before a change, a path or an address: only light that the change can
    /// alter is traced, with the same results as without this option
    #[arg(long, value_name = "BEFORE.helio")]
    pub from: Option<PathBuf>,
    /// Also write a table by hour, day, month, year or total, as `replay` does: months.csv and so
    /// on; several with commas
    #[arg(long, value_name = "PERIOD", value_parser = choice::<Every>(), value_delimiter = ',')]
    pub every: Vec<Every>,
    /// Also check a rule of sunlight and write rules.csv: a name that `heliotile rules` lists, or a
    /// file with rules of your own (.toml); may be repeated
    #[arg(long, value_name = "NAME|FILE")]
    pub rule: Vec<String>,
    /// Grouping of rows in the tables of --every and --rule: what each row stands for
    #[arg(long, value_parser = choice::<By>(), default_value = "receiver", requires = "tables")]
    pub by: By,
    /// Time that labels a row of hours: the start, middle or end of its interval
    #[arg(long, value_parser = choice::<StampedAt>(), default_value = "start", requires = "every")]
    pub stamp: StampedAt,
    /// Year of all dates in the tables of --every, such as 2019, as for `replay`; annual sums stay
    /// as they are
    #[arg(long, value_parser = clap::value_parser!(i32).range(1..=2999), requires = "every")]
    pub year: Option<i32>,
    /// Ending of the tables of --every and --rule, which chooses their format
    #[arg(long, value_parser = table_endings(), default_value = "csv", requires = "tables")]
    pub format: String,
    /// Also write the annual sums as a map in this format, such as annual.glb beside annual.ply, or
    /// into the city model of the scene; may be repeated, or several with commas
    #[arg(long, value_name = "FORMAT", value_parser = choice::<RunMap>(), value_delimiter = ',')]
    pub map: Vec<RunMap>,
    /// Replace results in the folder that are of another scene, spacing, accuracy or weather;
    /// without this option they are an error
    #[arg(long)]
    pub replace: bool,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    #[command(flatten)]
    pub about_weather: ClockArgs,
}

impl RunArgs {
    /// Returns the request of `run`.
    pub fn request(&self) -> RunRequest {
        RunRequest {
            scene: self.scene.request(),
            weather: self.weather.clone(),
            about_weather: self.about_weather.options(false),
            folder: self.output.clone(),
            cover: self.cover.request(),
            receivers: self.receivers.clone(),
            accuracy: self.accuracy.request_beside(Some(&self.weather), &self.about_weather),
            negligible_percent: self.negligible.map(|Percent(percent)| percent),
            with_scene: !self.no_scene,
            from: self.from.clone(),
            every: self.every.clone(),
            rules: self.rule.clone(),
            by: self.by,
            stamp: self.stamp,
            year: self.year,
            format: self.format.clone(),
            maps: self.map.clone(),
            replace: self.replace,
        }
    }
}
