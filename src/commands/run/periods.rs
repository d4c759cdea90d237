//! What `replay` writes beside a run's annual sums: tables of hours, days, months or years, the chart of the months, the city model with sums. In:
//! its archive and weather. Out: these files.

use std::ffi::OsString;
use std::path::Path;

use clap::Parser;

use super::folder::Files;
use crate::cli::{Cli, Command, RunArgs, name_of};
use crate::commands::replay::{Archives, dated, replay_opened};
use crate::commands::voice::note;
use crate::outputs::periods::Every;
use crate::outputs::tables::layout::By;
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::span::Span;

/// Writes the tables that are asked for, the chart, and the city model.
pub fn write(
    args: &RunArgs,
    files: &Files,
    city_model: Option<&Path>,
    archive: &Archive,
    weather: &Weather,
) -> Result<()> {
    let replays = Replays { args, files, archive, weather };
    let chart = || option("--plot=", &files.chart);
    for every in &args.every {
        let table = option("--output=", &files.periods(*every, args));
        let chart = (*every == Every::Month).then(chart);
        replays.run(*every, args.by, [table].into_iter().chain(chart), true)?;
    }
    if !args.every.contains(&Every::Month) {
        replays.run(Every::Month, By::Receiver, [chart()], false)?;
    }
    if let Some(model) = city_model {
        let words = [option("--model=", model), option("--output=", &files.city_model)];
        replays.run(Every::Total, By::Receiver, words, false)?;
    }
    Ok(())
}

struct Replays<'a> {
    args: &'a RunArgs,
    files: &'a Files,
    archive: &'a Archive,
    weather: &'a Weather,
}

impl Replays<'_> {
    /// Runs `replay`, by the command line that gives the same, so that what is not said is as there.
    fn run(&self, every: Every, by: By, more: impl IntoIterator<Item = OsString>, shows_years: bool) -> Result<()> {
        let (args, every) = (self.args, name_of(&every));
        let mut words = ["heliotile", "replay", "--every", every, "--by", name_of(&by)].map(OsString::from).to_vec();
        words.push(option("--weather=", &args.weather));
        words.extend(more);
        words.extend(["--".into(), self.files.archive.clone().into()]);
        let Ok(Command::Replay(mut replay)) = Cli::try_parse_from(&words).map(|cli| cli.command) else {
            let what = format!("`replay --every {every}` is not understood");
            return Err(Error::argument("--every", what, "this is a fault of the program: please report it"));
        };
        replay.common.table.memory = args.memory;
        (replay.stamp, replay.year) = (args.stamp, args.year);
        replay.about_weather.clock = args.about_weather.clone();
        let (dated, odd) = dated(&replay, &Span::new(None, None)?, self.weather)?;
        odd.iter().filter(|_| shows_years).for_each(|text| note(text));
        replay_opened(&replay, Archives::one(self.archive), self.weather, &dated).map(drop)
    }
}

/// An option and its path in one word, whatever the path begins with.
fn option(name: &str, path: &Path) -> OsString {
    let mut word = OsString::from(name);
    word.push(path);
    word
}
