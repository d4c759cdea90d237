//! Commands: the stories of the program, told once each. No physics here.

pub mod atlas;
pub mod audit;
pub mod build;
mod console;
pub mod copy;
pub mod energyplus;
pub mod export;
mod horizon;
pub mod inspect;
mod original;
mod preflight;
pub mod pv;
pub mod receivers;
pub mod repair;
pub mod replay;
pub mod run;
mod scene;
mod shells;
pub mod store;
pub mod study;
mod traced;
pub mod tradeoff;
pub mod transfer;
pub mod view;

use std::path::{Path, PathBuf};

use crate::cli::{Bytes, Cli, ClockArgs, Command, EverywhereArgs, SceneArgs};
use crate::files::{self, read_weather_as};
use crate::guards::{guard_archive, guard_output, guard_site, is_archive, same_file};
use crate::outputs::provenance::Provenance;
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::build::Workspace;
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::spill::TempFiles;
use heliotile_builder::writing::copy::folder_of;
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::MemoryBudget;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_scene::Scene;

pub use console::interrupt::exit_code;
use console::voice::{Volume, remark, say, warn};
use console::{interrupt, terminal, voice};
pub use horizon::nothing_seen;

/// How a command that ran ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Fine,
    /// Exit code 1: it ran and found something wrong.
    ProblemFound,
}

/// Runs a command, once its files are known to be what it takes; `about` is what files say of how they were made.
pub fn run(Cli { command, everywhere }: &Cli, about: Provenance) -> Result<Outcome> {
    preflight::check(command)?;
    set_up(everywhere)?;
    let outcome = run_command(command, about);
    if let Some(traffic) = files::traffic().filter(|_| everywhere.verbose) {
        console::voice::aside(&format!("{traffic}\n"));
    }
    outcome
}

fn run_command(command: &Command, about: Provenance) -> Result<Outcome> {
    match command {
        Command::Build(args) => build::run(args),
        Command::Partition(args) => atlas::partition::run(args),
        Command::Catalogue(args) => atlas::catalogue::catalogue(args, about),
        Command::Find(args) => atlas::catalogue::find(args),
        Command::Plan(args) => build::plan(args),
        Command::Receivers(args) => receivers::run(args),
        Command::Tradeoff(args) => tradeoff::run(args, about),
        Command::Query(args) => replay::query(args, about),
        Command::Run(args) => run::run(args, about),
        Command::Pv(args) => pv::run(args, about),
        Command::Energyplus(args) => energyplus::run(args),
        Command::Replay(args) => replay::replay(args, about),
        Command::Factors(args) => replay::factors(args, about),
        Command::Buildings(args) => replay::buildings(args, about),
        Command::Places(args) => replay::places(args, about),
        Command::Info(args) => inspect::info(args),
        Command::Verify(args) => inspect::verify(args),
        Command::Repair(args) => repair::run(args),
        Command::Audit(args) => audit::run(args, about),
        Command::Store(args) => store::run(args),
        Command::Extract(args) => transfer::extract(args),
        Command::Merge(args) => transfer::merge(args),
        Command::Diff(args) => transfer::diff(args),
        Command::Copy(args) => copy::run(args),
        Command::View(args) => view::run(args),
        Command::Export(args) => export::run(args, about),
        Command::Study(args) => study::run(args),
        Command::Completions(args) => shells::completions(args),
        Command::Man(args) => shells::man(args),
    }
}

/// Makes the options of all commands hold for the whole program.
fn set_up(args: &EverywhereArgs) -> Result<()> {
    voice::set_volume(match (args.quiet, args.verbose) {
        (true, _) => Volume::Quiet,
        (_, true) => Volume::Verbose,
        _ => Volume::Usual,
    });
    let Some(threads) = args.threads else { return Ok(()) };
    rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global().map_err(|error| {
        Error::argument("--threads", format!("{threads} threads cannot be started: {error}"), "give a smaller number")
    })
}

/// Reads a scene and prints what its files are warned of.
fn load_scene(args: &SceneArgs) -> Result<Scene> {
    let scene = Scene::load_site(&args.site()?)?;
    say_report(&scene)?;
    Ok(scene)
}

/// Prints what loading a scene came across.
fn say_report(scene: &Scene) -> Result<()> {
    scene.report.warnings.iter().for_each(|w| warn(w));
    scene.report.notes.iter().try_for_each(|note| remark(&format!("{note}\n")))
}

/// Where a command works.
fn workspace(folder: impl Into<PathBuf>, memory: Bytes) -> Workspace {
    Workspace { folder: folder.into(), memory: MemoryBudget::new(memory.0) }
}

/// The same, with temporary files beside its output.
fn workspace_beside(output: &Path, memory: Bytes) -> Workspace {
    workspace(folder_of(output), memory)
}

/// Temporary files of commands that only read: in the system's folder for them.
fn temporary_files() -> TempFiles {
    TempFiles::new(std::env::temp_dir())
}

/// The receivers of a file in tiles; prints what is passed over.
fn read_receivers(path: &Path, scene: &Scene, workspace: &Workspace) -> Result<ReceiverTiles> {
    let (receivers, warnings) = files::read_receivers(path, scene, workspace)?;
    warnings.iter().for_each(|w| warn(w));
    Ok(receivers)
}

/// What errors are estimated under: a weather file, or suns from all sides.
fn read_suns(weather: Option<&Path>, about: Option<&ClockArgs>, scene: &Scene) -> Result<ErrorConditions> {
    let Some(path) = weather else { return Ok(ErrorConditions::Spread) };
    let options = about.map_or_else(WeatherOptions::default, |about| about.options(false));
    let weather = read_weather_as(path, &options, &mut || Ok(scene.place))?;
    weather.report.warnings.iter().for_each(|w| warn(w));
    ErrorConditions::of_weather(path, weather)
}
