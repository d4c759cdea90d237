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
pub mod build;
pub mod comfort;
mod console;
pub mod copy;
pub mod export;
pub mod inspect;
pub mod pv;
pub mod receivers;
pub mod replay;
pub mod run;
mod scene;
mod shells;
mod starts;
pub mod sunlight;
pub mod transfer;
pub mod view;
mod weather;

use crate::cli::{Cli, CliCommand, EverywhereArgs};
use console::terminal::Terminal;
use console::voice::{self, Volume, remark, say, warn};
use heliotile::cases::{Given, prepared};
use heliotile::requests::Request;
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

/// Runs a command; `about` is the provenance that files state.
pub fn run(Cli { command, everywhere }: &Cli, about: Provenance) -> Result<Outcome> {
    set_up(everywhere)?;
    let outcome = match command {
        CliCommand::Case(command, given) => starts::carry_out(command, given, about),
        CliCommand::Completions(shell) => shells::completions(*shell),
        CliCommand::Man(folder) => shells::man(folder),
    };
    if let Some(traffic) = heliotile::remote::traffic().filter(|_| everywhere.verbose) {
        voice::aside(&format!("{traffic}\n"));
    }
    // After a failure too: a warning may name its cause.
    voice::tell_waiting();
    outcome
}

/// Fills the request of a command, checks the files that it names, and runs the command.
pub fn start<R: Request + Default>(
    given: &Given,
    about: Provenance,
    run: fn(&R, Provenance) -> Result<Outcome>,
) -> Result<Outcome> {
    let prepared = prepared::<R>(given, &[], &|_| false)?;
    console::interrupt::clean_up();
    run(&prepared.request, prepared.told_in(about)?)
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
