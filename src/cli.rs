//! The command line: clap types of every subcommand, nothing else.

mod audit;
mod build;
mod buildings;
mod choice;
mod copy;
mod cover;
mod energyplus;
mod everywhere;
mod export;
mod misplaced;
mod partition;
mod pv;
mod quality;
mod recombine;
mod run;
mod scene;
mod shells;
mod study;
mod tradeoff;
mod view;
mod weather;
mod words;

use std::path::PathBuf;
use std::str::FromStr;

use clap::{ArgGroup, Args, Parser, Subcommand};
use glam::DVec3;

use heliotile_builder::transfer::Bounds;
use heliotile_core::archive::Access;

use self::choice::choice;

pub use self::audit::AuditArgs;
pub use self::build::{BuildArgs, PlanArgs};
pub use self::buildings::{BuildingsArgs, ModuleSize, PlaceOn, PlacesArgs, YearArgs};
pub use self::choice::{NamedValues, by_name, name_of};
pub use self::copy::CopyArgs;
pub use self::cover::{CoverArgs, Metres, ReceiversArgs};
pub use self::energyplus::{EnergyplusArgs, Physics};
pub use self::everywhere::EverywhereArgs;
pub use self::export::ExportArgs;
pub use self::misplaced::parse;
pub use self::partition::{CatalogueArgs, FindArgs, PartitionArgs};
pub use self::pv::PvArgs;
pub use self::quality::{AccuracyArgs, Percent, parse_negligible};
pub use self::recombine::{FactorsArgs, QueryArgs, RecombineArgs, ReplayArgs, TableArgs};
pub use self::run::{RunArgs, RunMap};
pub use self::scene::{MaterialsArgs, PlaceArgs, SceneArgs};
pub use self::shells::{CompletionsArgs, ManArgs};
pub use self::study::{RaySquare, StudyArgs, StudyCommand, WallArgs};
pub use self::tradeoff::TradeoffArgs;
pub use self::view::ViewArgs;
pub use self::weather::{ClockArgs, WeatherArgs};
pub use self::words::{give, words};

/// Trace the sun and sky of a site once, replay any weather.
#[derive(Debug, Parser)]
#[command(name = "heliotile", version, about, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub everywhere: EverywhereArgs,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// From scene files to a year's sun in one go: receivers, archive, sums, map
    Run(RunArgs),
    /// Give a model of EnergyPlus the sun that its surroundings reflect, for any weather, as tables that EnergyPlus itself runs
    Energyplus(EnergyplusArgs),
    /// Solar modules: hourly light on both sides, shading, horizons, the best tilt and azimuth
    Pv(PvArgs),
    /// Cover the surfaces of a scene with receivers
    Receivers(ReceiversArgs),
    /// Trace every receiver of a scene once and store its layers in an archive
    Build(BuildArgs),
    /// Cut a region into parts that are built one by one, on any machines, and are asked like one archive
    Partition(PartitionArgs),
    /// A static STAC catalogue of the parts of an atlas, with pictures and a page
    Catalogue(CatalogueArgs),
    /// Which parts of an atlas lie in a box
    Find(FindArgs),
    /// What a build would trace, what it would cost, and what leaving an effect out could cost
    Plan(PlanArgs),
    /// What accuracy costs on a site: the ladder of settings on some of its receivers, as tables, pictures and a page
    Tradeoff(TradeoffArgs),
    /// Irradiance of every receiver under the suns and skies of a conditions table
    Query(QueryArgs),
    /// Irradiance of every receiver through a weather file
    Replay(ReplayArgs),
    /// What surroundings reflect on receivers or surfaces over the sun's position: EnergyPlus's factors, as .csv or .parquet
    Factors(FactorsArgs),
    /// What a solar cadastre says of buildings and roof faces: usable area, sums by orientation, regions in one piece
    Buildings(BuildingsArgs),
    /// The best places of modules on roofs and facades, as points that `pv` takes
    Places(PlacesArgs),
    /// What is inside an archive, or a scene
    Info(InfoArgs),
    /// Check every block of an archive; exit code 1 if one is damaged
    Verify(VerifyArgs),
    /// Compare an archive with what an independent judge finds for random receivers and hours; exit code 1 if its stated error is refuted
    Audit(AuditArgs),
    /// Trace the damaged parts of an archive again
    Repair(RepairArgs),
    /// The trace cache that `build --store` fills
    Store(StoreArgs),
    /// Write an archive of some receivers of another one
    Extract(ExtractArgs),
    /// Write the union of two archives of one scene
    Merge(MergeArgs),
    /// What two archives do not share; exit code 1 if they differ
    Diff(DiffArgs),
    /// Copy an archive to an object store, or from there or a web server
    Copy(CopyArgs),
    /// Show an archive in the browser of this machine: any sun, sky, weather and reflectance, live
    View(ViewArgs),
    /// Layers of a receiver as images, view factors of all receivers as a table
    Export(ExportArgs),
    /// The studies of the paper, drawn again
    Study(StudyArgs),
    /// Completions of this command line for a shell
    Completions(CompletionsArgs),
    /// Manual pages of all commands
    Man(ManArgs),
}

/// A number of bytes: `2GiB`, `512MiB`, `800MB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bytes(pub u64);

/// Less than this leaves no room for a tile.
const LEAST_MEMORY: u64 = 64 << 20;

impl FromStr for Bytes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        let hint = "give a number and MiB, GiB, MB or GB, as in 512MiB";
        let unit = match &text[digits.len()..] {
            "GiB" | "G" => 1 << 30,
            "MiB" | "M" => 1 << 20,
            "GB" => 1_000_000_000,
            "MB" => 1_000_000,
            "" => return Err(format!("there is no unit: {hint}")),
            other => return Err(format!("`{other}` is not a unit: {hint}")),
        };
        let number = digits.trim().parse::<f64>().ok().filter(|number| *number >= 0.0);
        let number = number.ok_or_else(|| format!("`{digits}` is not a number of bytes: {hint}"))?;
        // `as` saturates.
        Ok(Bytes((number * unit as f64) as u64))
    }
}

fn parse_memory(text: &str) -> Result<Bytes, String> {
    match text.parse()? {
        Bytes(bytes) if bytes < LEAST_MEMORY => Err("the least is 64MiB".into()),
        bytes => Ok(bytes),
    }
}

/// The options of [`ClockArgs`], where weather is not needed: they say nothing without it.
fn clock_of(weather: &'static str) -> ArgGroup {
    ArgGroup::new("clock").args(["time_zone", "shift", "weather_stamp"]).multiple(true).requires(weather)
}

/// Weather files that what is said of the clock can be about.
fn weather_files() -> ArgGroup {
    ArgGroup::new("weather_files").args(["error_weather", "weather"]).multiple(true)
}

#[derive(Args, Debug)]
pub struct VerifyArgs {
    /// Archive to check, or the folder of an atlas: a path or an address
    pub archive: PathBuf,
    /// Also decode every layer and follow every reference between blocks
    #[arg(long)]
    pub deep: bool,
    /// How the archive is read
    #[arg(long, value_parser = choice::<Access>(), default_value = "pread")]
    pub io: Access,
}

#[derive(Args, Debug)]
pub struct RepairArgs {
    /// Archive to repair
    pub archive: PathBuf,
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Receivers that it was built from; needed where the archive's own are damaged
    #[arg(long, short)]
    pub receivers: Option<PathBuf>,
    /// Where the repaired archive goes; without it the damaged one is replaced
    #[arg(long, short, value_name = "SITE.helio")]
    pub output: Option<PathBuf>,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
}

#[derive(Args, Debug)]
pub struct StoreArgs {
    #[command(subcommand)]
    pub command: StoreCommand,
}

#[derive(Debug, Subcommand)]
pub enum StoreCommand {
    /// List the archives of a store, least recently used first
    Ls {
        /// Folder of the store
        folder: PathBuf,
    },
    /// Remove the least recently used archives of a store
    Gc {
        /// Folder of the store
        folder: PathBuf,
        /// What may stay, such as 10GiB
        #[arg(long)]
        keep: Bytes,
    },
    /// Check every archive of a store; exit code 1 if one is damaged
    Verify {
        /// Folder of the store
        folder: PathBuf,
    },
}

#[derive(Args, Debug)]
pub struct InfoArgs {
    /// Archive, or scene files as a build takes them
    #[arg(required = true, value_name = "SITE.helio|SCENE")]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub surfaces: MaterialsArgs,
    #[command(flatten)]
    pub place: PlaceArgs,
    /// How the archive is read
    #[arg(long, value_parser = choice::<Access>(), default_value = "map")]
    pub io: Access,
}

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("selection").required(true).args(["receivers", "bbox", "surface", "object"])))]
pub struct ExtractArgs {
    /// Archive to read
    pub archive: PathBuf,
    /// Archive to write
    #[arg(long, short, value_name = "PART.helio")]
    pub output: PathBuf,
    /// Keep the receivers of a CSV file: ids in a column `receiver`
    #[arg(long, short, value_name = "FILE")]
    pub receivers: Option<PathBuf>,
    /// Keep the receivers in a box, scene coordinates in metres: xmin,ymin,xmax,ymax and optionally zmin,zmax
    #[arg(long, value_name = "BOX", allow_hyphen_values = true, value_parser = parse_bounds)]
    pub bbox: Option<Bounds>,
    /// Keep the receivers of these surfaces
    #[arg(long, value_name = "NAME", num_args = 1..)]
    pub surface: Vec<String>,
    /// Keep the receivers of these objects or buildings
    #[arg(long, value_name = "NAME", num_args = 1..)]
    pub object: Vec<String>,
    /// Leave out the scene's triangles
    #[arg(long)]
    pub no_scene: bool,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    /// How the archive is read
    #[arg(long, value_parser = choice::<Access>(), default_value = "pread")]
    pub io: Access,
}

#[derive(Args, Debug)]
pub struct MergeArgs {
    /// Archives to read
    pub first: PathBuf,
    pub second: PathBuf,
    /// Archive to write
    #[arg(long, short, value_name = "SITE.helio")]
    pub output: PathBuf,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    /// How the archives are read
    #[arg(long, value_parser = choice::<Access>(), default_value = "pread")]
    pub io: Access,
}

#[derive(Args, Debug)]
pub struct DiffArgs {
    /// Archives to compare, A and B
    pub first: PathBuf,
    pub second: PathBuf,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    /// How the archives are read
    #[arg(long, value_parser = choice::<Access>(), default_value = "pread")]
    pub io: Access,
}

/// A box of positions: `xmin,ymin,xmax,ymax` of any height, or with `zmin,zmax` behind.
fn parse_bounds(text: &str) -> Result<Bounds, String> {
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{part}` is not a number")),
    };
    let numbers: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
    let (low, high) = match numbers[..] {
        [x0, y0, x1, y1] => (DVec3::new(x0, y0, f64::NEG_INFINITY), DVec3::new(x1, y1, f64::INFINITY)),
        [x0, y0, x1, y1, z0, z1] => (DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1)),
        _ => return Err(format!("{} numbers, not 4 or 6: give xmin,ymin,xmax,ymax[,zmin,zmax]", numbers.len())),
    };
    if low.cmpgt(high).any() {
        return Err("a lowest value is above its highest: give xmin,ymin,xmax,ymax[,zmin,zmax]".into());
    }
    Ok(Bounds { low, high })
}

fn parse_depth(text: &str) -> Result<heliotile_core::light::radiosity::MaxBounces, String> {
    use heliotile_core::light::radiosity::MaxBounces;
    match (text, text.parse::<u32>()) {
        ("all", _) => Ok(MaxBounces::All),
        (_, Ok(count @ 1..=64)) => Ok(MaxBounces::Count(count)),
        _ => Err("give `all` or a number of reflections from 1 to 64".into()),
    }
}
