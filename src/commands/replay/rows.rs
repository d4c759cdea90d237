//! Results of a series. In: archives, conditions. Out: a table or a map, and pictures, in one pass over the tiles.

use std::path::{Path, PathBuf};

use super::chosen::choose;
use super::pictures::{self, Plot};
use super::{Archives, each_tile, made_from, mapped};
use crate::cli::RecombineArgs;
use crate::commands::{Outcome, temporary_files};
use crate::outputs::area_means::AreaMeans;
use crate::outputs::groups::{GroupMeans, Groups};
use crate::outputs::results::{ResultFormat, ResultWriter};
use crate::outputs::shapes::writer::MapFormat;
use crate::outputs::tables::layout::{By, Layout};
use crate::outputs::tables::table::Places;
use crate::outputs::tables::writer::TableWriter;
use crate::recombine::{Series, Streamed};
use heliotile_core::error::Result;
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::replay::components::ComponentList;

/// Streams all tiles into what is asked for.
pub fn write(args: &RecombineArgs, archives: Archives, series: &Series) -> Result<Outcome> {
    let (labels, asked) = (&series.labels, &args.table);
    let plots = Plot::all(&args.plot, series)?;
    let chosen = choose(asked, archives)?;
    let components = args.columns.clone().unwrap_or_else(ComponentList::all);
    let mut layout = Layout { labels: series.kind, by: asked.by, components, facts: Vec::new() };
    let mut means = match asked.by {
        By::Receiver => None,
        by => {
            let groups = Groups::new(chosen.receivers(), by, &asked.archive)?.facing(chosen.north());
            layout.facts = groups.facts(by, &layout.components);
            let memory = MemoryBudget::new(asked.memory.0).share(Use::SurfaceSums);
            Some(GroupMeans::new(groups, layout.components(), labels.len(), memory)?)
        }
    };
    let names = means.as_ref().map(|means| means.groups().names().to_vec());
    let all_names = || match &names {
        Some(names) => Ok(names.clone()),
        None => chosen.names(),
    };
    let count = names.as_ref().map_or(chosen.count(), |names| names.len() as u64);
    let about = made_from(series, args, archives);
    let called = format!("{} under {}", pictures::name_of(&asked.archive), series.called);
    let storage = temporary_files();
    let format = ResultFormat::of(&asked.output, args.geo)?;
    let map = |path, format| {
        let groups = means.as_ref().map(GroupMeans::groups);
        let columns = (&layout, labels, series.every);
        mapped::start(asked, (path, format), (&chosen, groups), columns, (about.clone(), &called), &storage)
    };
    let of_output = match format {
        ResultFormat::Map(format) => Some((asked.output.as_path(), format)),
        ResultFormat::Table(_) => None,
    };
    let of_plots = plots.iter().filter(|(_, plot)| *plot == Plot::Map).map(|(path, _)| (*path, MapFormat::Png));
    let maps = of_output.into_iter().chain(of_plots);
    let maps = maps.map(|(path, format)| Ok((path, map(path, format)?))).collect::<Result<Vec<_>>>()?;
    // With pictures, the standard output is not asked for by saying nothing.
    let writes_table = of_output.is_none() && (args.plot.is_empty() || asked.output != Path::new("-"));
    let start = || -> Result<Vec<(PathBuf, ResultWriter)>> {
        let places = Places { count, names: &all_names };
        let table = writes_table.then(|| TableWriter::create(&asked.output, &layout, labels, &places, &about));
        let table = table.transpose()?.map(|table| (asked.output.clone(), ResultWriter::Table(table)));
        let maps = maps.into_iter().map(|(path, map)| (path.to_owned(), ResultWriter::Map(Box::new(map))));
        Ok(table.into_iter().chain(maps).collect())
    };
    let mut of_all =
        plots.iter().any(|(_, plot)| *plot != Plot::Map).then(|| AreaMeans::new(layout.components(), labels.len()));
    let mut receivers = chosen.receivers();
    let streamed = Streamed { chosen: &chosen, components: layout.components.set() };
    let mut results = each_tile(&streamed, args, series, start, |results, names, values| {
        if let Some(of_all) = &mut of_all {
            for (row, receiver) in receivers.by_ref().take(values.receivers()).enumerate() {
                of_all.add(&receiver?, values, row);
            }
        }
        match &mut means {
            Some(means) => means.add(values),
            None => results.iter_mut().try_for_each(|(_, to)| to.write_tile(names, values, &[]))?,
        }
        Ok(!results.iter().any(|(_, to)| to.is_closed()))
    })?;
    for (names, values, extents) in means.iter().flat_map(GroupMeans::tiles) {
        results.iter_mut().try_for_each(|(_, to)| to.write_tile(&names, &values, extents))?;
    }
    for (path, results) in results {
        if let Some(stats) = results.finish()? {
            mapped::say_large(&path, &stats);
        }
    }
    for (path, plot) in plots {
        if let Some(of_all) = &of_all {
            pictures::write_chart((path, plot), of_all, series, &layout, (&called, &about))?;
        }
    }
    Ok(Outcome::Fine)
}
