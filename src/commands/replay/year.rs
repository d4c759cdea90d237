//! The replay behind tables of a year. In: an archive and weather. Out: the arguments of a replay of their sums.

use std::ffi::OsString;

use clap::Parser;

use crate::cli::{Cli, Command, ReplayArgs, YearArgs};
use heliotile_core::error::{Error, Result};

/// The replay that gives the sums.
pub fn year_of(args: &YearArgs) -> Result<ReplayArgs> {
    let mut weather = OsString::from("--weather=");
    weather.push(&args.weather);
    let mut words = ["heliotile", "replay", "--every", "total", "--columns", "total"].map(OsString::from).to_vec();
    words.extend([weather, "--".into(), args.archive.clone().into()]);
    let Ok(Command::Replay(mut replay)) = Cli::try_parse_from(&words).map(|cli| cli.command) else {
        let hint = "this is a fault of the program: please report it";
        return Err(Error::argument("--weather", "`replay --every total` is not understood", hint));
    };
    let table = &mut replay.common.table;
    (table.memory, table.io, table.grid_north) = (args.memory, args.io, args.grid_north);
    replay.about_weather = args.about_weather.clone();
    Ok(replay)
}
