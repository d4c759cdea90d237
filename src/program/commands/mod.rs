//! The commands of the program. In: parsed arguments. Out: requests that the library runs, and
//! their results printed. No physics here.

/// Appends one line of text.
macro_rules! line {
    ($out:ident, $($part:tt)*) => {
        // Writing to a string cannot fail.
        let _ = writeln!($out, $($part)*);
    };
}

pub mod atlas;
pub mod audit;
pub mod build;
pub mod comfort;
mod console;
pub mod copy;
pub mod energyplus;
pub mod export;
pub mod inspect;
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
pub mod sunlight;
pub mod tradeoff;
pub mod transfer;
pub mod update;
pub mod view;
mod weather;

use std::path::{Path, PathBuf};

use crate::cli::{Bytes, Cli, Command, EverywhereArgs};
use console::terminal::Terminal;
use console::voice::{self, Volume, remark, say, warn};
use heliotile::output::folder_of;
use heliotile::tracing::Workspace;
use heliotile::{Error, Provenance, Result, Scene, SceneRequest};

pub use console::interrupt::exit_code;
pub use console::voice::aside as complain;

/// Result of a command that ran.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Fine,
    /// Exit code 1: the command ran and found a problem.
    ProblemFound,
}

/// Runs a command after a check of the files that it names; `about` is the provenance that files
/// state.
pub fn run(Cli { command, everywhere }: &Cli, about: Provenance) -> Result<Outcome> {
    let _outputs = preflight::check(command)?;
    console::interrupt::clean_up();
    set_up(everywhere)?;
    let outcome = run_command(command, about);
    if let Some(traffic) = heliotile::remote::traffic().filter(|_| everywhere.verbose) {
        voice::aside(&format!("{traffic}\n"));
    }
    outcome
}

fn run_command(command: &Command, about: Provenance) -> Result<Outcome> {
    match command {
        Command::Build(args) => build::run(args),
        Command::Update(args) => update::run(args),
        Command::Partition(args) => atlas::partition(args),
        Command::Catalogue(args) => atlas::catalogue(args, about),
        Command::Find(args) => atlas::find(args),
        Command::Plan(args) => build::plan(args),
        Command::Receivers(args) => receivers::run(args),
        Command::Tradeoff(args) => tradeoff::run(args, about),
        Command::Query(args) => replay::query(args, about),
        Command::Run(args) => run::run(args, about),
        Command::Pv(args) => pv::run(args, about),
        Command::Energyplus(args) => energyplus::run(args),
        Command::Replay(args) => replay::replay(args, about),
        Command::Compare(args) => replay::compare(args, about),
        Command::Sunlight(args) => sunlight::run(args, about),
        Command::Glare(args) => sunlight::glare(args, about),
        Command::Comfort(args) => comfort::run(args, about),
        Command::Rules(args) => sunlight::rules(args),
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

/// Applies the options of all commands to the whole program.
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

/// Reads a scene and prints the warnings about its files.
fn load_scene(request: &SceneRequest) -> Result<Scene> {
    let scene = Scene::load_site(&request.site()?)?;
    scene.report.tell(&Terminal::default());
    Ok(scene)
}

/// Returns a workspace with its temporary files in `folder`.
fn workspace(folder: impl Into<PathBuf>, memory: Bytes) -> Workspace {
    Workspace { folder: folder.into(), memory: memory.into() }
}

/// Returns a workspace with its temporary files beside the output.
fn workspace_beside(output: &Path, memory: Bytes) -> Workspace {
    workspace(folder_of(output), memory)
}
