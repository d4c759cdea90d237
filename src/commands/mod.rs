//! Commands: the stories of the program, told once each. No physics here.

pub mod build;
pub mod progress;
pub mod replay;
pub mod store;

use crate::cli::Command;
use crate::error::Result;

/// How a command that ran ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Fine,
    /// Exit code 1: it ran and found something wrong.
    ProblemFound,
}

/// Runs one command.
pub fn run(command: &Command) -> Result<Outcome> {
    match command {
        Command::Build(args) => build::run(args),
        Command::Query(args) => replay::query(args),
        Command::Replay(args) => replay::replay(args),
        Command::Info(args) => store::info(args),
        Command::Verify(args) => store::verify(args),
    }
}

/// Prints a warning of a command that goes on.
fn warn(text: &str) {
    eprintln!("warning: {text}");
}
