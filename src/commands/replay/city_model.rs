//! `heliotile replay --model`: an archive, weather and the city model that its receivers were put on -> the same city model with sums.

use std::io::{self, Write};
use std::path::Path;

use super::chosen::choose;
use super::{Archives, each_tile, made_from};
use crate::cli::ReplayArgs;
use crate::commands::{Outcome, remark, warn};
use crate::files::shown;
use crate::outputs::city_model::{CityModelWriter, ModelSums, RewriteError, is_city_model};
use crate::outputs::periods::Every;
use crate::outputs::sink::Sink;
use crate::outputs::tables::layout::By;
use crate::recombine::{Series, Streamed};
use heliotile_core::error::{Error, Result};
use heliotile_core::replay::components::{ComponentList, ComponentSet};
use heliotile_core::text::counted;
use heliotile_scene::input;

const HINT: &str = "give the city model that the receivers were put on, as `heliotile run` or `receivers` read it";

/// Refuses what a city model cannot hold, before anything is read.
pub fn check(args: &ReplayArgs, model: &Path) -> Result<()> {
    let output = &args.common.table.output;
    if !is_city_model(output) || is_sequence(output) != is_sequence(model) {
        let ending = if is_sequence(model) { ".city.jsonl" } else { ".city.json" };
        let what = format!("`{}` is no name of such a city model", output.display());
        return Err(Error::argument("--output", what, format!("let it end with {ending}, as --model asks for")));
    }
    if matches!(args.every, Every::Hour | Every::Day) {
        let hint = "give --every month, year or total";
        return Err(Error::argument("--every", "a city model takes sums of few periods, not hours or days", hint));
    }
    if args.common.table.by != By::Receiver {
        let hint = "leave --by out: objects and their semantic surfaces both get sums";
        return Err(Error::argument("--by", "a city model has its own rows", hint));
    }
    Ok(())
}

fn is_sequence(path: &Path) -> bool {
    ["jsonl", "cityjsonl"].contains(&input::ending(path).as_str())
}

/// Writes the model with the sums of a series.
pub fn write(args: &ReplayArgs, archives: Archives, series: &Series, model: &Path) -> Result<Outcome> {
    let asked = &args.common.table;
    // Read before the replay, which takes longer.
    let bytes = input::read(model)?;
    let text = std::str::from_utf8(&bytes).map_err(|error| {
        Error::input(model, None, format!("is no text in UTF-8: {error}"), "give a CityJSON file, or convert it")
    })?;
    let text = text.trim_start_matches('\u{feff}');
    let chosen = choose(asked, archives)?;
    let components = args.common.columns.clone().unwrap_or_else(ComponentList::all);
    let labels = &series.labels.text;
    let whole = args.every == Every::Total || args.every == Every::Year && labels.len() == 1;
    let sums = ModelSums::new(components.as_slice(), if whole { &[] } else { labels });
    let streamed = Streamed { chosen: &chosen, components: ComponentSet::of(sums.components()) };
    let mut receivers = chosen.receivers();
    let sums = each_tile(
        &streamed,
        &args.common,
        series,
        || Ok(sums),
        |sums, _, values| {
            for (row, receiver) in receivers.by_ref().take(values.receivers()).enumerate() {
                sums.add(&receiver?, values, row);
            }
            Ok(true)
        },
    )?;
    let Some(example) = sums.example() else {
        let what = format!("none of its {} names a city object", counted(chosen.count(), "receiver"));
        return Err(Error::input(
            &asked.archive,
            None,
            what,
            "put receivers on the city model with `heliotile receivers`",
        ));
    };
    let about = made_from(series, &args.common, archives).json();
    let mut sink = Sink::file(&asked.output)?;
    let mut writer = CityModelWriter::new(&sums);
    let mut lines = (1..).zip(parts(text, is_sequence(model)));
    lines.try_for_each(|(line, text)| {
        let about = (line == 1).then_some(&about);
        let written = writer.write(text, about, &mut sink).and_then(|()| Ok(sink.write_all(b"\n")?));
        written.map_err(|error| match error {
            RewriteError::Model(what) => {
                Error::input(model, is_sequence(model).then_some(line), format!("is no city model: {what}"), HINT)
            }
            RewriteError::Write(source) => failed(&asked.output, source),
        })
    })?;
    let (fitting, objects, faces) = (writer.fitting(), sums.object_count(), sums.face_count());
    if fitting.objects == 0 {
        let what = format!(
            "holds none of the {} of {}, such as `{example}`",
            counted(objects as u64, "city object"),
            shown(&asked.archive).display()
        );
        return Err(Error::input(model, None, what, HINT));
    }
    if fitting.objects < objects || fitting.faces < faces {
        warn(&format!(
            "{}: holds {} of {objects} objects and {} of {faces} faces that receivers of {} stand for; what it does not hold is \
             not written",
            model.display(),
            fitting.objects,
            fitting.faces,
            shown(&asked.archive).display()
        ));
    }
    if sums.homeless() > 0 {
        warn(&format!("{} on no object: left out", counted(sums.homeless(), "receiver")));
    }
    sink.finish()?;
    remark(&format!(
        "{}: {} objects and {} faces with sums\n",
        asked.output.display(),
        fitting.objects,
        fitting.faces
    ))?;
    Ok(Outcome::Fine)
}

/// The whole text, or the lines of a sequence that are not empty.
fn parts(text: &str, sequence: bool) -> Vec<&str> {
    match sequence {
        true => text.lines().filter(|line| !line.trim().is_empty()).collect(),
        false => vec![text],
    }
}

fn failed(path: &Path, source: io::Error) -> Error {
    Error::io(path, "write to")(source)
}
