//! The program `heliotile`: a command line that fills requests, and a terminal that shows the
//! results.

mod cli;
mod commands;
#[cfg(test)]
mod faces;

pub use cli::option_of;

use std::ffi::OsString;

use heliotile::Error;

/// Parses a command line whose first word is the program's name, runs the command and prints the
/// error, if there is one. Returns the exit code: 0 done, 1 found a problem, 2 could not run, 130
/// stopped by Ctrl-C, 143 by SIGTERM.
pub fn program(words: &[OsString]) -> u8 {
    let (cli, about) = cli::parse(words);
    match commands::run(&cli, about) {
        Ok(commands::Outcome::Fine) => 0,
        Ok(commands::Outcome::ProblemFound) => 1,
        Err(error @ Error::Stopped { .. }) => {
            commands::complain(&format!("heliotile: {error}; to go on: {}\n", cli::again(words)));
            commands::exit_code()
        }
        Err(error) => {
            commands::complain(&cli::report(error));
            2
        }
    }
}
