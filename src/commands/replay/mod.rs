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
use crate::outputs::periods::{ClockReading, Every, Periods};
use crate::outputs::provenance::Provenance;
use crate::outputs::results::ResultFormat;
use crate::outputs::tables::layout::Labels;
use crate::outputs::tables::row_labels::RowLabels;
use chosen::{Chosen, ChosenPart, guard};
use heliotile_builder::observer::Stage;
use heliotile_core::archive::{Archive, Manifest};
use heliotile_core::error::{Error, Result};
use heliotile_core::light::states::Schedule;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::reflectances::{Changeable, Changes};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::replay::values::TileValues;
use heliotile_core::site::ground::MonthlyGround;
use heliotile_core::site::material::rounded;
use heliotile_core::weather::conditions::{Condition, Stamp};
use heliotile_core::weather::dated::DatedRows;
use heliotile_core::weather::distance::far_apart;
use heliotile_core::weather::options::StampedAt;
use heliotile_core::weather::row::WeatherRow;
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::span::Span;
use heliotile_core::weather::temperatures::emissions;
use heliotile_core::weather::time::bins::Bins;
use heliotile_core::weather::time::utc_offset::UtcOffset;
use heliotile_core::weather::time::years::Years;
pub(super) use sources::Archives;
use sources::{Sources, say_north};

/// What results are made of.
pub(super) struct Series<'a> {
    pub conditions: &'a [Condition],
    kind: Labels,
    /// None in a query.
    every: Option<Every>,
    pub labels: RowLabels,
    /// Which label a condition adds to.
    bins: &'a Bins,
    changes: Changes,
    /// Rows of the weather file, and which of them the conditions are; none in a query.
    rows: (&'a [WeatherRow], &'a [bool]),
    pub provenance: Provenance,
    /// What these are, in words, for pictures.
    called: String,
}

/// `heliotile query`.
pub fn query(args: &QueryArgs) -> Result<Outcome> {
    if asks_longwave(&args.common) {
        return Err(Error::Unsupported {
            what: "column `longwave`".into(),
            found: "`query`, whose conditions have no infrared radiation and no temperatures".into(),
            supported: "it in `replay`, from a weather file".into(),
        });
    }
    let inputs: Vec<&Path> = args.common.schedules().chain([args.conditions.as_path()]).collect();
    guard(&args.common.table, &inputs)?;
    pictures::guard(&args.common, &inputs, None)?;
    ResultFormat::of(&args.common.table.output, args.common.geo)?;
    let file = read_conditions(&args.conditions)?;
    let sources = Sources::open(&args.common.table)?;
    let archives = sources.borrowed();
    file.warnings.iter().for_each(|w| warn(w));
    let constant = args.common.reflectance.iter().map(|(name, _)| name.as_str());
    let set: Vec<&str> = constant.chain(args.common.schedule.iter().map(|(name, _)| name.as_str())).collect();
    if let Some(ground) = constant_ground(archives.first(), &set)? {
        warn(&format!(
            "`{}` reflects another share each month, and conditions have no date: the mean of the year counts, {} (or \
             --reflectance ground=...)",
            ground.material,
            rounded(ground.mean())
        ));
    }
    let labels = RowLabels::words(file.conditions.iter().map(|c| c.label.clone()).collect());
    let name = args.conditions.file_name().unwrap_or_default().to_string_lossy();
    let series = Series {
        conditions: &file.conditions,
        kind: Labels::Conditions,
        every: None,
        bins: &Bins::each(labels.len()),
        labels,
        changes: changes(&args.common),
        rows: (&[], &[]),
        called: match file.conditions.as_slice() {
            [only] => format!("{name}: {}", only.label),
            _ => name.to_string(),
        },
        provenance: invocation::provenance().with("conditions", name),
    };
    say_north(&args.common.table, archives.manifest());
    say_left_out(archives, None);
    rows::write(&args.common, archives, &series)
}

/// Warns where effects were left out that bring little under other weather than this.
fn say_left_out(archives: Archives, weather: Option<&Path>) {
    let Some(known) = &archives.manifest().negligible else { return };
    if weather.and_then(Path::file_name).is_none_or(|name| *name != *known.weather) {
        warn(&format!("{} leaves out {known}; here they may bring more", archives.first().path().display()));
    }
}

/// The ground that the archive states by month and that a query takes the mean of, if no option sets it.
fn constant_ground<'a>(archive: &'a Archive, changed: &[&str]) -> Result<Option<&'a MonthlyGround>> {
    // Few archives state one; others are not opened twice.
    let Some(ground) = &archive.manifest().ground else { return Ok(None) };
    let site = OpenSite::of(archive)?;
    if Changeable::of(&site, archive.manifest()).ground.is_none() {
        return Ok(None);
    }
    let material = site.materials().iter().find(|material| material.name == ground.material);
    let group = material.and_then(|material| material.group.as_deref());
    let is_set = changed.iter().any(|name| *name == ground.material || Some(*name) == group || *name == "ground");
    Ok(Some(ground).filter(|_| !is_set))
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
        Ok(sources.insert(Sources::open(&args.common.table)?).borrowed().manifest().place)
    })?;
    weather.report.warnings.iter().for_each(|w| warn(w));
    let dated = dated(args, &span, &weather)?;
    note_years(args, &dated);
    let sources = sources.map_or_else(|| Sources::open(&args.common.table), Ok)?;
    let archives = sources.borrowed();
    let apart = archives.manifest().place.and_then(|place| far_apart(&place, &weather));
    apart.iter().for_each(|apart| warn(apart));
    say_north(&args.common.table, archives.manifest());
    say_left_out(archives, Some(&args.weather));
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
    let chosen = &dated.chosen;
    let steps = args.steps.map_or_else(|| weather.steps_of(archives.manifest().settings.steps()), usize::from);
    let mut conditions: Vec<Condition> = {
        let all = weather.conditions(steps).into_iter();
        all.zip(chosen).filter_map(|(condition, chosen)| chosen.then_some(condition)).collect()
    };
    if asks_longwave(&args.common) {
        let emissions = emissions(weather, &args.weather, chosen, &args.temperature, &read_file)?;
        conditions.iter_mut().zip(emissions).for_each(|(condition, emission)| condition.emission = Some(emission));
    }
    let dates = dated.dates.iter().zip(chosen).filter_map(|(date, chosen)| chosen.then_some(*date));
    let stamps = conditions.iter().zip(dates).filter_map(|(condition, date)| Some(Stamp { date, ..condition.stamp? }));
    let clock = ClockReading { offset: UtcOffset::of_hours(weather.site.zone_hours), at: args.stamp };
    let periods = Periods::new(args.every, dated.years, &stamps.collect::<Vec<_>>(), clock);
    let (kind, bins) = match args.every {
        Every::Hour => (Labels::Times, Bins::each(conditions.len())),
        _ => (Labels::Sums, periods.bins()),
    };
    let changes = Changes { snow: args.snow.map(|snow| (snow, args.snow_reflectance)), ..changes(&args.common) };
    let rows = (weather.rows.as_slice(), chosen.as_slice());
    let provenance = invocation::provenance().with_weather(&args.weather, weather).with_option("steps", steps);
    let provenance = match args.every {
        Every::Hour => {
            provenance.with("stamp", args.stamp.name()).with("interval_minutes", 60.0 * weather.interval_hours)
        }
        _ => provenance.with("stamp", StampedAt::Start.name()),
    };
    let (every, labels) = (Some(args.every), periods.labels);
    let called = pictures::called(&args.weather, dated);
    let series =
        Series { conditions: &conditions, kind, every, labels, bins: &bins, changes, rows, provenance, called };
    then(&series)
}

/// The rows that are asked for, with the dates that results give them; says what is odd about these.
pub(super) fn dated(args: &ReplayArgs, span: &Span, weather: &Weather) -> Result<DatedRows> {
    let (intervals, file) = (weather.rows.iter().map(|row| row.interval).collect::<Vec<_>>(), &args.weather);
    let dated = match args.year {
        Some(year) => DatedRows::in_year(&intervals, file, span, year)?,
        None => DatedRows::of_file(&intervals, file, span)?,
    };
    dated.warnings.iter().for_each(|w| warn(w));
    Ok(dated)
}

/// Says which years labels have, where these are not one.
pub(super) fn note_years(args: &ReplayArgs, dated: &DatedRows) {
    let labels = match args.every {
        Every::Hour => "times have these years",
        Every::Day | Every::Month => "days and months have no year",
        Every::Year | Every::Total => return,
    };
    if dated.years == Years::Typical {
        let years = || dated.dates.iter().map(|date| date.year);
        let (first, last) = (years().min().unwrap_or_default(), years().max().unwrap_or_default());
        note(&format!(
            "{}: its months come from different years, {first} to {last}, and {labels}; --year, as in --year 2019, puts them into one",
            args.weather.display()
        ));
    }
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

/// Schedules of reflectances and transmittances over the conditions, of those of the changes that a part of the choice knows.
fn schedules(part: &ChosenPart, chosen: &Chosen, series: &Series) -> Result<Vec<Schedule>> {
    let changeable = part.changeable();
    if series.changes.is_empty() && changeable.ground.is_none() {
        return Ok(Vec::new());
    }
    let known_elsewhere = |name: &str| chosen.parts().iter().any(|other| other.changeable().knows(name));
    // A name that no part knows is left in, and refused.
    let changes = series.changes.only(|name| changeable.knows(name) || !known_elsewhere(name));
    let (rows, chosen) = series.rows;
    if rows.is_empty() {
        return changes.undated(&changeable, series.conditions.len(), &read_file);
    }
    let (mut schedules, warnings) = changes.over(&changeable, rows, &read_file)?;
    warnings.iter().for_each(|w| warn(w));
    for schedule in &mut schedules {
        let mut chosen = chosen.iter();
        schedule.values.retain(|_| chosen.next() == Some(&true));
    }
    Ok(schedules)
}

impl Series<'_> {
    /// What results were made from.
    pub fn about(&self, args: &RecombineArgs, archives: Archives) -> Provenance {
        let about = match archives.only() {
            Some(archive) => self.provenance.clone().with_archive(&args.table.archive, archive),
            None => self.provenance.clone().with_parts(&args.table.archive, &archives.roots()),
        };
        about.with_option("patches", patches(args, archives.manifest()))
    }
}

fn patches(args: &RecombineArgs, manifest: &Manifest) -> usize {
    args.patches.unwrap_or_else(|| manifest.settings.patches())
}

/// Which receivers and components are recombined.
pub(super) struct Streamed<'a> {
    pub chosen: &'a Chosen<'a>,
    pub components: ComponentSet,
}

impl Streamed<'_> {
    /// Hands on the results tile by tile until `each` gives false. What takes them starts once the replay is known to work.
    pub fn each_tile<T>(
        &self,
        args: &RecombineArgs,
        series: &Series,
        start: impl FnOnce() -> Result<T>,
        mut each: impl FnMut(&mut T, &[String], &TileValues) -> Result<bool>,
    ) -> Result<T> {
        let storage = temporary_files();
        let (terminal, count) = (Terminal::default(), self.chosen.count());
        let (mut start, mut taker, mut progress) = (Some(start), None, None);
        'parts: for part in self.chosen.parts() {
            let settings = ReplaySettings {
                sky: args.sky,
                patches: patches(args, part.archive.manifest()),
                paths: args.light()?,
                components: self.components,
                memory: MemoryBudget::new(args.table.memory.0),
                storage: &storage,
            };
            let schedules = schedules(part, self.chosen, series)?;
            let replay = Replay::scheduled(&part.site, series.conditions, settings, series.bins, &schedules)?;
            if let Some(start) = start.take() {
                taker = Some(start()?);
            }
            let progress = progress.get_or_insert_with(|| Stage::begin(&terminal, "receivers", Some(count)));
            let results = replay.results(part.tiles().iter().map(|tile| tile.number));
            for (tile, result) in part.tiles().iter().zip(results) {
                let (receivers, values) = part.results(*tile, result?);
                progress.advance(receivers.len() as u64);
                let goes_on = taker.as_mut().map_or(Ok(false), |taker| each(taker, &receivers, &values))?;
                if !goes_on {
                    break 'parts;
                }
            }
        }
        match (taker, start) {
            (Some(taker), _) => Ok(taker),
            (None, Some(start)) => start(),
            (None, None) => Err(Error::argument("--receivers", "there is nothing to replay", "choose some receivers")),
        }
    }
}
