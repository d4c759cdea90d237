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
    StudyArgs, StudyCommand, TradeoffArgs, UpdateArgs, WallArgs, WeatherArgs, parse_negligible,
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
    /// Compute a year's sun from scene files in one go: receivers, archive, sums, map
    Run(RunArgs),
    /// Give an EnergyPlus model the sun that its surroundings reflect, for any weather, as tables
    /// that EnergyPlus itself runs
    Energyplus(EnergyplusArgs),
    /// Solar modules: hourly light on both sides, shading, horizons, the best tilt and azimuth
    Pv(PvArgs),
    /// Cover the surfaces of a scene with receivers
    Receivers(ReceiversArgs),
    /// Trace every receiver of a scene once and store its layers in an archive
    Build(BuildArgs),
    /// Edit the scene of an archive: add, remove, move, raise or repaint objects; only what an edit
    /// can alter is traced again
    Update(UpdateArgs),
    /// Cut a region into parts that are built one by one, on any machines, and are queried like one
    /// archive
    Partition(PartitionArgs),
    /// Write a static STAC catalogue of the parts of an atlas, with pictures and a page
    Catalogue(CatalogueArgs),
    /// List the parts of an atlas that lie in a box
    Find(FindArgs),
    /// Forecast what a build would trace and cost, and what leaving an effect out could cost
    Plan(PlanArgs),
    /// Measure what accuracy costs on a site: the ladder of settings on some of its receivers, as
    /// tables, pictures and a page
    Tradeoff(TradeoffArgs),
    /// Irradiance of every receiver under the suns and skies of a conditions table
    Query(QueryArgs),
    /// Irradiance of every receiver through a weather file
    Replay(ReplayArgs),
    /// Compare the light of a site before and after a change: before, after and change, with a
    /// summary of who loses how much
    Compare(CompareArgs),
    /// Hours of possible sun on given days, and what rules say of them: windows, facades, gardens
    Sunlight(SunlightArgs),
    /// When mirrors and glass facades throw the sun at receivers, which pane does, and what rules
    /// say of it
    Glare(GlareArgs),
    /// Thermal comfort of people outdoors: mean radiant temperature, UTCI and PET of points of a
    /// site, by hour or over periods
    Comfort(Box<ComfortArgs>),
    /// List the rules that `sunlight` and `glare` know
    Rules(RulesArgs),
    /// Light that surroundings reflect on receivers or surfaces over the sun's position:
    /// EnergyPlus's factors
    Factors(FactorsArgs),
    /// Solar cadastre of buildings and roof faces: usable area, sums by orientation, regions in one
    /// piece
    Buildings(BuildingsArgs),
    /// The best places of modules on roofs and facades, as points that `pv` takes
    Places(PlacesArgs),
    /// Describe an archive, or a scene
    Info(InfoArgs),
    /// Check every block of an archive; exit code 1 if one is damaged
    Verify(VerifyArgs),
    /// Check an archive against an independent reference path tracer for random receivers and
    /// hours; exit code 1 if its stated error is refuted
    Audit(AuditArgs),
    /// Trace the damaged parts of an archive again
    Repair(RepairArgs),
    /// Manage the trace cache that `build --store` fills
    Store(StoreArgs),
    /// Write an archive of some receivers of another one
    Extract(ExtractArgs),
    /// Write the union of two archives of one scene
    Merge(MergeArgs),
    /// List the differences of two archives; exit code 1 if they differ
    Diff(DiffArgs),
    /// Copy an archive or an atlas to an object store, or from there or a web server
    Copy(CopyArgs),
    /// Show an archive in the browser of this machine: any sun, sky, weather and reflectance, live
    View(ViewArgs),
    /// Layers of a receiver as images, view factors of all receivers as a table
    Export(ExportArgs),
    /// Repeat the studies of the paper
    Study(StudyArgs),
    /// Write completions of this command line for a shell
    Completions(CompletionsArgs),
    /// Write manual pages of all commands
    Man(ManArgs),
}
