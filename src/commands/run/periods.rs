//! Tables of hours, days, months or years beside a run's annual sums. In: its archive and weather. Out: what `replay` writes.

use std::ffi::OsString;
use std::path::Path;

use clap::Parser;

use super::folder::Files;
use crate::cli::{Cli, Command, RunArgs, name_of};
use crate::commands::replay::{Archives, dated, replay_rows};
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::span::Span;

/// Writes the tables that are asked for.
pub fn write(args: &RunArgs, files: &Files, archive: &Archive, weather: &Weather) -> Result<()> {
    let whole = Span::new(None, None)?;
    args.every.iter().try_for_each(|every| {
        let (every, output) = (name_of(every), files.periods(*every, args));
        // The command line that gives the same table, so that what is not said is as in `replay`.
        let mut words =
            ["heliotile", "replay", "--every", every, "--by", name_of(&args.by)].map(OsString::from).to_vec();
        words.extend([option("--weather=", &args.weather), option("--output=", &output), "--".into()]);
        words.push(files.archive.clone().into());
        let Ok(Command::Replay(mut replay)) = Cli::try_parse_from(&words).map(|cli| cli.command) else {
            let what = format!("`replay --every {every}` is not understood");
            return Err(Error::argument("--every", what, "this is a fault of the program: please report it"));
        };
        replay.common.table.memory = args.memory;
        (replay.stamp, replay.year) = (args.stamp, args.year);
        replay.about_weather.clock = args.about_weather.clone();
        let dated = dated(&replay, &whole, weather)?;
        replay_rows(&replay, Archives::one(archive), weather, &dated).map(drop)
    })
}

/// An option and its path in one word, whatever the path begins with.
fn option(name: &str, path: &Path) -> OsString {
    let mut word = OsString::from(name);
    word.push(path);
    word
}
