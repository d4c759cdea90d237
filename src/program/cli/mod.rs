//! The command line: clap types of every subcommand, nothing else.
//!
//! | room | arguments of |
//! | --- | --- |
//! | `sites` | commands that read scenes and trace, and commands on atlases |
//! | `results` | commands that compute light from archives |
//! | `archives`, `copy` | commands on archives as files |
//! | `line` | the line itself: options of all commands, wording of messages, completions |
//! | `values` | values of options: names, numbers with units |

mod archives;
mod copy;
mod line;
mod results;
mod sites;
mod values;

use clap::{Parser, Subcommand};

pub use self::archives::{DiffArgs, ExtractArgs, InfoArgs, MergeArgs, RepairArgs, StoreArgs, StoreCommand, VerifyArgs};
pub use self::copy::CopyArgs;
pub use self::line::{
    CompletionsArgs, EverywhereArgs, ManArgs, again, command_of, option_of, parse, quoted, worded, worded_text,
};
pub use self::results::{
    BuildingsArgs, ComfortArgs, CompareArgs, EnergyplusArgs, ExportArgs, FactorsArgs, GlareArgs, PlacesArgs, PvArgs,
    QueryArgs, RecombineArgs, ReplayArgs, RulesArgs, SiteArgs, SunlightArgs, TableArgs, ViewArgs, YearArgs,
};
pub use self::sites::{
    AccuracyArgs, AuditArgs, BuildArgs, CatalogueArgs, ClockArgs, CoverArgs, FindArgs, FootprintArgs, MaterialsArgs,
    Metres, PartitionArgs, Percent, PlaceArgs, PlanArgs, RasterArgs, RaySquare, ReceiversArgs, RunArgs, SceneArgs,
    StudyArgs, StudyCommand, TableNorthArgs, TradeoffArgs, UpdateArgs, WallArgs, WeatherArgs, parse_negligible,
};
pub use self::values::Bytes;

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
    /// Compute a year of solar irradiation from scene files with one command: receivers, archive,
    /// sums, map
    Run(RunArgs),
    /// Add the sunlight that its surroundings reflect to an EnergyPlus model; an unmodified
    /// EnergyPlus then runs it with any weather
    Energyplus(EnergyplusArgs),
    /// Compute hourly irradiance on both sides of solar modules, with shading losses, horizons and
    /// the best tilt and azimuth
    Pv(PvArgs),
    /// Cover the surfaces of a scene with receivers: the points at which light is computed
    Receivers(ReceiversArgs),
    /// Trace once what every receiver of a scene sees, and store it in an archive
    Build(BuildArgs),
    /// Edit the scene of an archive: add, remove, move, raise or repaint objects. Only light that
    /// the edits can alter is traced again
    Update(UpdateArgs),
    /// Cut a region into parts (an atlas) that are built one by one, on any machines, and then
    /// queried like one archive
    Partition(PartitionArgs),
    /// Write a static STAC catalogue of the parts of an atlas, with pictures and a page
    Catalogue(CatalogueArgs),
    /// List the parts of an atlas that touch a box
    Find(FindArgs),
    /// Forecast the rays and seconds of a build, and the light that is lost if a light path is left
    /// out
    Plan(PlanArgs),
    /// Measure the time and error of each accuracy level on some receivers of a site, as tables,
    /// pictures and a page
    Tradeoff(TradeoffArgs),
    /// Compute the irradiance of every receiver under the suns and skies of a table
    Query(QueryArgs),
    /// Compute the irradiance of every receiver through a weather file, by hour or as sums
    Replay(ReplayArgs),
    /// Compare the light of a site before and after a change: both values, their difference, and a
    /// summary of the losses
    Compare(CompareArgs),
    /// Compute hours of possible sun on given days, and check rules for windows, facades and
    /// gardens
    Sunlight(SunlightArgs),
    /// Find when mirrors and glass facades reflect the sun to receivers, and which pane does, and
    /// check rules on glare
    Glare(GlareArgs),
    /// Compute thermal comfort of people outdoors: mean radiant temperature, UTCI and PET at points
    /// of a site, by hour or over periods
    Comfort(Box<ComfortArgs>),
    /// List the rules that `sunlight` and `glare` can check
    Rules(RulesArgs),
    /// Compute EnergyPlus's reflection factors: the light that surroundings reflect to receivers or
    /// surfaces, by position of the sun
    Factors(FactorsArgs),
    /// Write a solar cadastre of buildings and roof faces: usable area, sums by orientation, best
    /// usable region
    Buildings(BuildingsArgs),
    /// Find the best places for modules on roofs and facades, as points that `pv` reads
    Places(PlacesArgs),
    /// Describe an archive, an atlas or scene files
    Info(InfoArgs),
    /// Check every block of an archive; exit code 1 if one is damaged
    Verify(VerifyArgs),
    /// Check an archive against an independent reference path tracer for random receivers and
    /// hours; exit code 1 if the error is larger than the archive states
    Audit(AuditArgs),
    /// Trace the damaged parts of an archive again
    Repair(RepairArgs),
    /// List, thin out or check the cache of traces that `build --store` fills
    Store(StoreArgs),
    /// Write some receivers of an archive into a new archive
    Extract(ExtractArgs),
    /// Write the union of two archives of one scene
    Merge(MergeArgs),
    /// List the differences of two archives; exit code 1 if they differ
    Diff(DiffArgs),
    /// Copy an archive or an atlas to or from an object store, or from a web server
    Copy(CopyArgs),
    /// Show an archive in the browser of this machine: any sun, sky, weather and reflectance, live
    View(ViewArgs),
    /// Export what a receiver sees as images, view factors of all receivers as a table, or a page
    /// that shows the archive
    Export(ExportArgs),
    /// Repeat studies of the paper behind the method (src/book/studies.md)
    Study(StudyArgs),
    /// Write completions of this command line for a shell
    Completions(CompletionsArgs),
    /// Write manual pages of all commands
    Man(ManArgs),
}
