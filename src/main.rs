//! Parse, dispatch, print the error, exit: 0 fine, 1 found a problem, 2 could not run.

use std::process::ExitCode;

use clap::Parser;
use heliotile::cli::Cli;
use heliotile::commands;
use heliotile::commands::Outcome;

fn main() -> ExitCode {
    match commands::run(&Cli::parse().command) {
        Ok(Outcome::Fine) => ExitCode::SUCCESS,
        Ok(Outcome::ProblemFound) => ExitCode::from(1),
        Err(error) => {
            eprintln!("heliotile: {error}");
            ExitCode::from(2)
        }
    }
}
