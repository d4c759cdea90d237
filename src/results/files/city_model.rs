//! City model that receivers were put on, with sums. In: a stream, the model. Out: that model with
//! sums of its objects and faces.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::OutputRequest;
use crate::outputs::city_model::{CityModelWriter, ModelSums, RewriteError, is_city_model};
use crate::outputs::periods::Every;
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::layout::By;
use crate::stream::{Tile, TileSink, TileStream};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::observer::Observer;
use heliotile_core::replay::components::ComponentSet;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::{counted, message};
use heliotile_files::input;
use heliotile_remote::naming::shown;

const HINT: &str = "give the city model from which the receivers were made, unchanged";

/// Refuses requests that a city model cannot hold, before anything is read.
pub fn check(request: &OutputRequest, every: Option<Every>, model: &Path) -> Result<()> {
    let output = &request.output;
    if !is_city_model(output) || is_sequence(output) != is_sequence(model) {
        let ending = if is_sequence(model) { ".city.jsonl" } else { ".city.json" };
        let what = message!("`{}` does not have the format of {{model}}", output.display());
        return Err(
            Error::argument("output", what, format!("give a name that ends with {ending}")).because(Problem::Ending)
        );
    }
    let Some(every) = every else {
        let what = "a city model holds sums over weather, not the light of suns and skies by themselves";
        return Err(Error::argument("model", what, "give {weather}, or write a map").because(Problem::needs("weather")));
    };
    if matches!(every, Every::Hour | Every::Day) {
        let hint = "give {every} month, year or total";
        return Err(Error::argument(
            "every",
            "a city model holds sums of months, years or the total, not of hours or days",
            hint,
        )
        .because(Problem::excludes("model")));
    }
    if request.by != By::Receiver {
        let hint = "leave {by} out: objects and semantic surfaces both get sums";
        return Err(Error::argument("by", "a city model has rows of its own: objects and surfaces", hint)
            .because(Problem::excludes("model")));
    }
    Ok(())
}

fn is_sequence(path: &Path) -> bool {
    ["jsonl", "cityjsonl"].contains(&input::ending(path).as_str())
}

/// City model that waits for sums.
pub struct CityModelSink<'a> {
    model: PathBuf,
    text: String,
    output: PathBuf,
    /// Path of the archive or of the atlas, for messages.
    place: PathBuf,
    /// Number of receivers.
    count: u64,
    sums: ModelSums,
    receivers: Box<dyn Iterator<Item = Result<Receiver>> + 'a>,
}

impl<'a> CityModelSink<'a> {
    /// Reads the model; `finish` writes it to `output` with the sums of the stream.
    pub fn new(stream: &TileStream<'a>, model: &Path, output: &Path, place: &Path) -> Result<Self> {
        let text = String::from_utf8(input::read(model)?).map_err(|error| {
            Error::input(model, None, format!("is not text in UTF-8: {error}"), "give a CityJSON file, or convert it")
        })?;
        let labels = &stream.series.labels.text;
        let every = stream.series.every;
        let whole = every == Some(Every::Total) || every == Some(Every::Year) && labels.len() == 1;
        let sums = ModelSums::new(&stream.light.columns(), if whole { &[] } else { labels });
        Ok(CityModelSink {
            model: model.to_owned(),
            text,
            output: output.to_owned(),
            place: place.to_owned(),
            count: stream.receivers.count(),
            sums,
            receivers: Box::new(stream.receivers.receivers()),
        })
    }

    /// Writes the model with its sums and returns a line that says so.
    pub fn finish(self, about: &Provenance, observer: &dyn Observer) -> Result<String> {
        let (model, sums) = (self.model.as_path(), &self.sums);
        let Some(example) = sums.example() else {
            let what = format!("none of its {} names a city object", counted(self.count, "receiver"));
            let hint = "make receivers from the city model: receivers of a table need not name its objects";
            return Err(Error::input(&self.place, None, what, hint));
        };
        let about = about.json();
        let mut sink = Sink::file(&self.output)?;
        let mut writer = CityModelWriter::new(sums);
        let text = self.text.trim_start_matches('\u{feff}');
        let mut lines = (1..).zip(parts(text, is_sequence(model)));
        lines.try_for_each(|(line, text)| {
            let about = (line == 1).then_some(&about);
            let written = writer.write(text, about, &mut sink).and_then(|()| Ok(sink.write_all(b"\n")?));
            written.map_err(|error| match error {
                RewriteError::Model(what) => Error::input(
                    model,
                    is_sequence(model).then_some(line),
                    format!("is not a city model: {what}"),
                    HINT,
                )
                .because(Problem::other_kind("not CityJSON")),
                RewriteError::Write(source) => failed(&self.output, source),
            })
        })?;
        let (fitting, objects, faces) = (writer.fitting(), sums.object_count(), sums.face_count());
        let place = shown(&self.place);
        if fitting.objects == 0 {
            let objects = counted(objects as u64, "city object");
            let what = format!("holds none of the {objects} of {}, such as `{example}`", place.display());
            return Err(Error::input(model, None, what, HINT).because(Problem::OtherSite));
        }
        if fitting.objects < objects || fitting.faces < faces {
            observer.warn(format!(
                "{}: contains {} of {objects} objects and {} of {faces} faces that have receivers in {}; sums of the others are not written",
                model.display(),
                fitting.objects,
                fitting.faces,
                place.display()
            ));
        }
        if sums.homeless() > 0 {
            observer.warn(format!("{} without an object: left out", counted(sums.homeless(), "receiver")));
        }
        sink.finish()?;
        let output = self.output.display();
        Ok(format!("{output}: {} objects and {} faces with sums\n", fitting.objects, fitting.faces))
    }
}

impl TileSink for CityModelSink<'_> {
    fn components(&self) -> ComponentSet {
        ComponentSet::new(self.sums.components())
    }

    fn take(&mut self, tile: &Tile) -> Result<bool> {
        for (row, receiver) in self.receivers.by_ref().take(tile.ids.len()).enumerate() {
            self.sums.add(&receiver?, tile.values, row);
        }
        Ok(true)
    }
}

/// Returns the whole text, or the non-empty lines of a sequence.
fn parts(text: &str, sequence: bool) -> Vec<&str> {
    match sequence {
        true => text.lines().filter(|line| !line.trim().is_empty()).collect(),
        false => vec![text],
    }
}

fn failed(path: &Path, source: io::Error) -> Error {
    Error::io(path, "write to")(source)
}
