//! Story two: archive -> recombine -> outputs, for a conditions table (`query`) and a weather file (`replay`).

use std::fs;
use std::path::Path;

use super::chosen::Chosen;
use super::terminal::Terminal;
use super::{Outcome, guard_output, temporary_files, warn};
use crate::cli::{QueryArgs, RecombineArgs, ReplayArgs};
use crate::files::{read_conditions, read_file, read_weather, read_weather_with_air};
use crate::outputs::periods::{Every, Periods};
use crate::outputs::surfaces::{SurfaceGroups, SurfaceMeans};
use crate::outputs::tables::layout::{By, Labels, Layout};
use crate::outputs::tables::table::Places;
use crate::outputs::tables::writer::{Format, TableWriter, files_of};
use heliotile_builder::observer::Stage;
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::{Error, Result};
use heliotile_core::light::states::Schedule;
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentList};
use heliotile_core::replay::reflectances::{Changeable, Changes, ConstantOrFile};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::distance::far_apart;
use heliotile_core::weather::row::WeatherRow;
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::span::Span;
use heliotile_core::weather::temperatures::emissions;
use heliotile_core::weather::time::bins::Bins;
use heliotile_core::weather::time::years::Years;

/// What results are made of.
struct Series<'a> {
    conditions: &'a [Condition],
    kind: Labels,
    labels: &'a [String],
    /// Which label a condition adds to.
    bins: &'a Bins,
    changes: Changes,
    /// Rows of the weather file, and which of them the conditions are; none in a query.
    rows: (&'a [WeatherRow], &'a [bool]),
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
    guard(&args.common, &[&args.conditions])?;
    let file = read_conditions(&args.conditions)?;
    let archive = open(&args.common)?;
    file.warnings.iter().for_each(|w| warn(w));
    let labels: Vec<String> = file.conditions.iter().map(|c| c.label.clone()).collect();
    let series = Series {
        conditions: &file.conditions,
        kind: Labels::Conditions,
        labels: &labels,
        bins: &Bins::each(labels.len()),
        changes: Changes {
            constant: args.common.reflectance.clone(),
            transmittance: args
                .transmittance
                .iter()
                .map(|(name, value)| (name.clone(), ConstantOrFile::Value(*value)))
                .collect(),
            ..Changes::default()
        },
        rows: (&[], &[]),
    };
    run(&args.common, &archive, &series)
}

/// `heliotile replay`.
pub fn replay(args: &ReplayArgs) -> Result<Outcome> {
    let mut inputs = vec![args.weather.as_path()];
    inputs.extend(args.schedule.iter().map(|(_, file)| file.as_path()));
    inputs.extend(args.temperature.iter().filter_map(|temperature| temperature.file()));
    inputs.extend(args.transmittance.iter().filter_map(|(_, follow)| match follow {
        ConstantOrFile::File(file) => Some(file.as_path()),
        ConstantOrFile::Value(_) => None,
    }));
    guard(&args.common, &inputs)?;
    let longwave = asks_longwave(&args.common);
    if !longwave && !args.temperature.is_empty() {
        return Err(Error::Unsupported {
            what: "--temperature".into(),
            found: "no column that depends on it".into(),
            supported: "it for `longwave`, as in --columns total,longwave".into(),
        });
    }
    let span = Span::new(args.from, args.to)?;
    let weather = if longwave { read_weather_with_air(&args.weather)? } else { read_weather(&args.weather)? };
    weather.report.warnings.iter().for_each(|w| warn(w));
    let chosen = span.rows_of(&weather, &args.weather)?;
    let archive = open(&args.common)?;
    let apart = archive.manifest().place.and_then(|place| far_apart(&place, &weather));
    apart.iter().for_each(|apart| warn(apart));
    replay_rows(args, &archive, &weather, &chosen)
}

/// Replays the chosen rows of a weather file that was read already, with its air if longwave is asked for.
pub(super) fn replay_rows(args: &ReplayArgs, archive: &Archive, weather: &Weather, chosen: &[bool]) -> Result<Outcome> {
    let steps = args.steps.unwrap_or_else(|| archive.manifest().settings.steps());
    // Labels are those of the whole file, whatever part of it is taken.
    let years = Years::of(weather.rows.iter().map(|row| row.interval.date));
    let mut conditions: Vec<Condition> = {
        let all = weather.conditions(usize::from(steps)).into_iter();
        all.zip(chosen).filter_map(|(condition, chosen)| chosen.then_some(condition)).collect()
    };
    if asks_longwave(&args.common) {
        let emissions = emissions(weather, &args.weather, chosen, &args.temperature, &read_file)?;
        conditions.iter_mut().zip(emissions).for_each(|(condition, emission)| condition.emission = Some(emission));
    }
    let stamped: Vec<_> = conditions.iter().filter_map(|c| Some((c.label.clone(), c.stamp?))).collect();
    let periods = Periods::new(args.every, years, &stamped);
    let (kind, bins) = match args.every {
        Every::Hour => (Labels::Times, Bins::each(conditions.len())),
        _ => (Labels::Sums, periods.bins()),
    };
    let changes = Changes {
        constant: args.common.reflectance.clone(),
        scheduled: args.schedule.clone(),
        snow: args.snow.map(|snow| (snow, args.snow_reflectance)),
        transmittance: args.transmittance.clone(),
    };
    let rows = (weather.rows.as_slice(), chosen);
    let series = Series { conditions: &conditions, kind, labels: &periods.labels, bins: &bins, changes, rows };
    run(&args.common, archive, &series)
}

fn asks_longwave(args: &RecombineArgs) -> bool {
    args.columns.as_ref().is_some_and(|columns| columns.set().contains(Component::Longwave))
}

fn guard(args: &RecombineArgs, forcing: &[&Path]) -> Result<()> {
    let mut inputs = vec![args.archive.as_path()];
    inputs.extend(forcing);
    inputs.extend(args.receivers.as_deref());
    match args.output == Path::new("-") {
        true => Ok(()),
        false => files_of(&args.output).iter().try_for_each(|file| guard_output(file, &inputs)),
    }
}

/// Pages of a mapping count as memory of the program for as long as the system likes: a large archive is read instead.
fn access(args: &RecombineArgs) -> Access {
    let large = || fs::metadata(&args.archive).is_ok_and(|about| about.len() > args.memory.0 / 4);
    args.io.unwrap_or_else(|| if large() { Access::Read } else { Access::Mapped })
}

/// Schedules of reflectances and transmittances over the conditions.
fn schedules(site: &OpenSite, series: &Series) -> Result<Vec<Schedule>> {
    if series.changes.is_empty() {
        return Ok(Vec::new());
    }
    let changeable = Changeable { site: site.path(), materials: site.materials() };
    let (rows, chosen) = series.rows;
    if rows.is_empty() {
        return series.changes.constant(&changeable, series.conditions.len());
    }
    let (mut schedules, warnings) = series.changes.over(&changeable, rows, &read_file)?;
    warnings.iter().for_each(|w| warn(w));
    for schedule in &mut schedules {
        let mut chosen = chosen.iter();
        schedule.values.retain(|_| chosen.next() == Some(&true));
    }
    Ok(schedules)
}

/// Opens the archive, if the output is one that can be written.
fn open(args: &RecombineArgs) -> Result<Archive> {
    Format::of(&args.output)?;
    Archive::open_with(&args.archive, access(args))
}

/// Streams all tiles into a table.
fn run(args: &RecombineArgs, archive: &Archive, series: &Series) -> Result<Outcome> {
    let labels = series.labels;
    let site = OpenSite::of(archive)?;
    let chosen = Chosen::of(args, archive, &site)?;
    let components = args.columns.clone().unwrap_or_else(ComponentList::all);
    let layout = Layout { labels: series.kind, by: args.by, components };
    let mut means = match args.by {
        By::Receiver => None,
        By::Surface => {
            let surfaces = SurfaceGroups::new(chosen.receivers(archive, &site), &args.archive)?;
            Some(SurfaceMeans::new(
                surfaces,
                layout.components(),
                labels.len(),
                MemoryBudget::new(args.memory.0).share(Use::SurfaceSums),
            )?)
        }
    };
    let storage = temporary_files();
    let settings = ReplaySettings {
        sky: args.sky,
        patches: args.patches.unwrap_or_else(|| archive.manifest().settings.patches()),
        depth: args.bounces,
        components: layout.components.set(),
        memory: MemoryBudget::new(args.memory.0),
        storage: &storage,
    };
    let schedules = schedules(&site, series)?;
    let replay = Replay::scheduled(&site, series.conditions, settings, series.bins, &schedules)?;
    let names = || match &means {
        Some(means) => Ok(means.surfaces().names().to_vec()),
        None => chosen.receivers(archive, &site).map(|receiver| Ok(receiver?.id)).collect(),
    };
    let count = means.as_ref().map_or(chosen.count(), |means| means.surfaces().names().len() as u64);
    let mut table = TableWriter::create(&args.output, &layout, labels, &Places { count, names: &names })?;
    let terminal = Terminal::default();
    let progress = Stage::begin(&terminal, "receivers", Some(chosen.count()));
    let results = replay.results(chosen.tiles().iter().map(|tile| tile.number));
    for (tile, result) in chosen.tiles().iter().zip(results) {
        let (receivers, values) = chosen.results(*tile, result?);
        match &mut means {
            Some(means) => means.add(&values),
            None => table.write_tile(&receivers, &values)?,
        }
        progress.advance(receivers.len() as u64);
        if table.is_closed() {
            break;
        }
    }
    for (surfaces, values) in means.iter().flat_map(SurfaceMeans::tiles) {
        table.write_tile(&surfaces, &values)?;
    }
    drop(progress);
    table.finish()?;
    Ok(Outcome::Fine)
}
