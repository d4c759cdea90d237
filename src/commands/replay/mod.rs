//! Story two: archive -> recombine -> outputs, for a conditions table (`query`) and a weather file (`replay`).

pub mod buildings;
mod chosen;
mod city_model;
pub mod factors;
mod grids;
pub(in crate::commands) mod mapped;
pub(in crate::commands) mod pictures;
pub mod places;
mod rows;
mod sources;
mod year;

use std::path::Path;

use super::terminal::Terminal;
use super::voice::note;
use super::{Outcome, invocation, temporary_files, warn};
use crate::cli::{QueryArgs, RecombineArgs, ReplayArgs};
use crate::files::{read_conditions, read_file, read_weather_as};
use crate::outputs::city_model::is_city_model;
use crate::outputs::provenance::Provenance;
use crate::outputs::results::ResultFormat;
use crate::recombine::{
    Recombination, Series, Streamed, WeatherReading, dated_rows, left_out, mean_ground, no_longwave,
};
use chosen::guard;
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::MemoryBudget;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::reflectances::Changes;
use heliotile_core::replay::values::TileValues;
use heliotile_core::weather::dated::DatedRows;
use heliotile_core::weather::distance::far_apart;
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::span::Span;
pub(super) use sources::Archives;
use sources::{Sources, say_north};

/// `heliotile query`.
pub fn query(args: &QueryArgs) -> Result<Outcome> {
    args.common.columns.as_ref().map_or(Ok(()), no_longwave)?;
    let inputs: Vec<&Path> = args.common.schedules().chain([args.conditions.as_path()]).collect();
    guard(&args.common.table, &inputs)?;
    pictures::guard(&args.common, &inputs, None)?;
    ResultFormat::of(&args.common.table.output, args.common.geo)?;
    let file = read_conditions(&args.conditions)?;
    let sources = sources::open(&args.common.table)?;
    let archives = sources.borrowed();
    file.warnings.iter().for_each(|w| warn(w));
    let changes = changes(&args.common);
    mean_ground(archives.first(), &changes)?.iter().for_each(|w| warn(w));
    let name = args.conditions.file_name().unwrap_or_default().to_string_lossy();
    let called = match file.conditions.as_slice() {
        [only] => format!("{name}: {}", only.label),
        _ => name.to_string(),
    };
    let about = invocation::provenance().with("conditions", name);
    let series = Series::of_conditions(file.conditions, changes, about).called(called);
    say_north(&args.common.table, archives.manifest());
    left_out(archives.first(), None).iter().for_each(|w| warn(w));
    rows::write(&args.common, archives, &series)
}

/// `heliotile replay`.
pub fn replay(args: &ReplayArgs) -> Result<Outcome> {
    let mut inputs = vec![args.weather.as_path()];
    inputs.extend(args.common.schedules());
    inputs.extend(args.temperature.iter().filter_map(|temperature| temperature.file()));
    inputs.extend(args.model.as_deref());
    guard(&args.common.table, &inputs)?;
    pictures::guard(&args.common, &inputs, Some(args.every))?;
    match (&args.model, &args.honeybee) {
        (Some(model), _) => city_model::check(args, model)?,
        (_, Some(folder)) => grids::check(args, folder)?,
        _ if is_city_model(&args.common.table.output) => {
            let hint = "give the city model that the receivers were put on: --model INPUT.city.json";
            return Err(Error::argument("--output", "a city model is written from another one", hint));
        }
        _ => drop(ResultFormat::of(&args.common.table.output, args.common.geo)?),
    }
    let (sources, weather, dated) = opened(args)?;
    replay_opened(args, sources.borrowed(), &weather, &dated)
}

/// Replays the chosen rows of a weather file that was read already, with its air if longwave is asked for.
pub(super) fn replay_opened(
    args: &ReplayArgs,
    archives: Archives,
    weather: &Weather,
    dated: &DatedRows,
) -> Result<Outcome> {
    with_series(args, archives, weather, dated, |series| match (&args.model, &args.honeybee) {
        (Some(model), _) => city_model::write(args, archives, series, model),
        (_, Some(folder)) => grids::write(args, archives, series, folder),
        _ => rows::write(&args.common, archives, series),
    })
}

/// The archives of a replay, its weather and the rows of it that are asked for; says what is odd about them.
pub(super) fn opened(args: &ReplayArgs) -> Result<(Sources, Weather, DatedRows)> {
    let longwave = asks_longwave(&args.common);
    if !longwave && !args.temperature.is_empty() {
        return Err(Error::Unsupported {
            what: "--temperature".into(),
            found: "no column that depends on it".into(),
            supported: "it for `longwave`, as in --columns total,longwave".into(),
        });
    }
    let span = Span::new(args.from, args.to)?;
    let options = args.about_weather.options(longwave);
    let mut sources = None;
    let weather = read_weather_as(&args.weather, &options, &mut || {
        Ok(sources.insert(sources::open(&args.common.table)?).borrowed().manifest().place)
    })?;
    weather.report.warnings.iter().for_each(|w| warn(w));
    let (dated, odd) = dated(args, &span, &weather)?;
    odd.iter().for_each(|text| note(text));
    let sources = sources.map_or_else(|| sources::open(&args.common.table), Ok)?;
    let archives = sources.borrowed();
    let apart = archives.manifest().place.and_then(|place| far_apart(&place, &weather));
    apart.iter().for_each(|apart| warn(apart));
    say_north(&args.common.table, archives.manifest());
    left_out(archives.first(), Some(&args.weather)).iter().for_each(|w| warn(w));
    Ok((sources, weather, dated))
}

/// Hands the chosen rows of a weather file on as conditions with labels and bins.
pub(super) fn with_series<T>(
    args: &ReplayArgs,
    archives: Archives,
    weather: &Weather,
    dated: &DatedRows,
    then: impl FnOnce(&Series) -> Result<T>,
) -> Result<T> {
    let reading = WeatherReading {
        file: &args.weather,
        every: args.every,
        stamp: args.stamp,
        steps: args.steps.map(usize::from),
        longwave: asks_longwave(&args.common).then_some(&args.temperature),
        files: &read_file,
    };
    let changes = Changes { snow: args.snow.map(|snow| (snow, args.snow_reflectance)), ..changes(&args.common) };
    let about = invocation::provenance();
    let series = Series::of_weather(archives.first(), (weather, dated), &reading, changes, about)?;
    then(&series.called(pictures::called(&args.weather, dated)))
}

/// The rows that are asked for, with the dates that results give them, and a sentence if these are not of one year; says what else is odd.
pub(super) fn dated(args: &ReplayArgs, span: &Span, weather: &Weather) -> Result<(DatedRows, Option<String>)> {
    let (dated, odd) = dated_rows((weather, &args.weather), span, args.year, args.every)?;
    dated.warnings.iter().for_each(|w| warn(w));
    Ok((dated, odd))
}

/// What both commands may change.
fn changes(args: &RecombineArgs) -> Changes {
    Changes {
        constant: args.reflectance.clone(),
        scheduled: args.schedule.clone(),
        transmittance: args.transmittance.clone(),
        snow: None,
    }
}

fn asks_longwave(args: &RecombineArgs) -> bool {
    args.columns.as_ref().is_some_and(|columns| columns.set().contains(Component::Longwave))
}

/// What results of a series were made from.
fn made_from(series: &Series, args: &RecombineArgs, archives: Archives) -> Provenance {
    let about = archives.told_in(series.provenance.clone(), &args.table.archive);
    about.with_option("patches", args.patches.unwrap_or_else(|| archives.manifest().settings.patches()))
}

/// Hands on the tiles of a series as a command line asks for them.
fn each_tile<T>(
    streamed: &Streamed,
    args: &RecombineArgs,
    series: &Series,
    start: impl FnOnce() -> Result<T>,
    each: impl FnMut(&mut T, &[String], &TileValues) -> Result<bool>,
) -> Result<T> {
    let storage = temporary_files();
    let asked = Recombination {
        sky: args.sky,
        patches: args.patches,
        paths: args.light()?,
        memory: MemoryBudget::new(args.table.memory.0),
        storage: &storage,
        files: &read_file,
    };
    streamed.each_tile(&asked, series, &Terminal::default(), start, each)
}
