//! Story two: archive -> recombine -> outputs, for a conditions table (`query`) and a weather file (`replay`).

use std::fs;
use std::path::Path;

use super::chosen::Chosen;
use super::progress::bar;
use super::{Outcome, guard_output, warn};
use crate::archive::{Access, Archive};
use crate::cli::{QueryArgs, RecombineArgs, ReplayArgs};
use crate::error::Result;
use crate::outputs::layout::{By, Labels, Layout};
use crate::outputs::periods::{Every, Periods};
use crate::outputs::surfaces::{SurfaceMeans, Surfaces};
use crate::outputs::table::{Format, Places, TableWriter, files_of};
use crate::recombine::bins::Bins;
use crate::recombine::components::ComponentList;
use crate::recombine::conditions::{Condition, read_conditions};
use crate::recombine::epw::read_epw;
use crate::recombine::replay::{Replay, ReplaySettings};
use crate::recombine::span::Span;
use crate::recombine::years::Years;

/// `heliotile query`.
pub fn query(args: &QueryArgs) -> Result<Outcome> {
    guard(&args.common, &args.conditions)?;
    let file = read_conditions(&args.conditions)?;
    file.warnings.iter().for_each(|w| warn(w));
    let labels: Vec<String> = file.conditions.iter().map(|c| c.label.clone()).collect();
    run(&args.common, &file.conditions, Labels::Conditions, &labels, &Bins::each(labels.len()))
}

/// `heliotile replay`.
pub fn replay(args: &ReplayArgs) -> Result<Outcome> {
    guard(&args.common, &args.weather)?;
    let span = Span::new(args.from, args.to)?;
    let weather = read_epw(&args.weather)?;
    weather.report.warnings.iter().for_each(|w| warn(w));
    let chosen = span.rows_of(&weather, &args.weather)?;
    // Labels are those of the whole file, whatever part of it is taken.
    let years = Years::of(weather.rows.iter().map(|row| row.interval.date));
    let conditions: Vec<Condition> = {
        let all = weather.conditions(usize::from(args.steps)).into_iter();
        all.zip(chosen).filter_map(|(condition, chosen)| chosen.then_some(condition)).collect()
    };
    let stamped: Vec<_> = conditions.iter().filter_map(|c| Some((c.label.clone(), c.stamp?))).collect();
    let periods = Periods::new(args.every, years, &stamped);
    match args.every {
        Every::Hour => run(&args.common, &conditions, Labels::Times, &periods.labels, &Bins::each(conditions.len())),
        _ => run(&args.common, &conditions, Labels::Sums, &periods.labels, &periods.bins()),
    }
}

fn guard(args: &RecombineArgs, forcing: &Path) -> Result<()> {
    let mut inputs = vec![args.archive.as_path(), forcing];
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

/// Streams all tiles into a table; `bins` says which row a condition adds to.
fn run(
    args: &RecombineArgs,
    conditions: &[Condition],
    kind: Labels,
    labels: &[String],
    bins: &Bins,
) -> Result<Outcome> {
    // Before anything is computed.
    Format::of(&args.output)?;
    let archive = Archive::open_with(&args.archive, access(args))?;
    let chosen = Chosen::of(args, &archive)?;
    let components = args.columns.clone().unwrap_or_else(ComponentList::all);
    let layout = Layout { labels: kind, by: args.by, components };
    let mut means = match args.by {
        By::Receiver => None,
        By::Surface => {
            let surfaces = Surfaces::new(chosen.receivers(&archive), &args.archive)?;
            Some(SurfaceMeans::new(surfaces, layout.components(), labels.len(), args.memory.0 / 2)?)
        }
    };
    let settings = ReplaySettings {
        sky: args.sky,
        patches: args.patches,
        depth: args.bounces,
        components: layout.components.set(),
        memory_bytes: args.memory.0,
    };
    let replay = Replay::summed(&archive, conditions, settings, bins)?;
    let names = || match &means {
        Some(means) => Ok(means.surfaces().names().to_vec()),
        None => chosen.receivers(&archive).map(|receiver| Ok(receiver?.id)).collect(),
    };
    let count = means.as_ref().map_or(chosen.count(), |means| means.surfaces().names().len() as u64);
    let mut table = TableWriter::create(&args.output, &layout, labels, &Places { count, names: &names })?;
    let progress = bar("receivers", Some(chosen.count()));
    // As many tiles in memory as there are cores.
    for tiles in chosen.tiles().chunks(rayon::current_num_threads()) {
        let results = replay.run(tiles.iter().map(|tile| tile.number))?;
        for (tile, result) in tiles.iter().zip(results) {
            let (receivers, values) = chosen.results(*tile, result);
            match &mut means {
                Some(means) => means.add(&values),
                None => table.write_tile(&receivers, &values)?,
            }
            progress.inc(receivers.len() as u64);
        }
        if table.is_closed() {
            break;
        }
    }
    for (surfaces, values) in means.iter().flat_map(SurfaceMeans::tiles) {
        table.write_tile(&surfaces, &values)?;
    }
    progress.finish_and_clear();
    table.finish()?;
    Ok(Outcome::Fine)
}
