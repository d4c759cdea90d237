//! Result files of a query or a replay. In: names of files, a stream of tiles. Out: tables, maps,
//! charts, a city model, a Honeybee folder; all in one pass over the tiles.

mod charts;
mod city_model;
mod honeybee;
mod map;
mod rows;

use std::path::{Path, PathBuf};

use super::archives::Archives;
use super::stream::TileStream;
use crate::outputs::city_model::is_city_model;
use crate::outputs::periods::Every;
use crate::outputs::result_file::ResultFormat;
use crate::outputs::shapes::writer::MapFormat;
use crate::outputs::tables::format::{files_of, table_help};
use crate::outputs::tables::layout::By;
pub use crate::outputs::tables::layout::Question;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::replay::components::ComponentList;
use heliotile_core::text::{Message, message};
use heliotile_files::writing::guards::guard_output;
use heliotile_requests::{DefaultRequest, Request};

pub use charts::AreaChart;
pub use city_model::CityModelSink;
pub use map::{MapStart, say_large};
pub use map::{crs_of, surroundings};
pub use rows::{MapFile, ResultSink, RowFiles, RowsAbout, groups_of, rows_of, write_rows};

/// Files that results are written to.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct OutputRequest {
    /// Table or map, in a format by the ending of its name; `-`: CSV on standard output, or nothing
    /// if there are plots.
    #[field(short = 'o', default = "-", help = output_help, output = Results)]
    pub output: PathBuf,
    /// Grouping of rows: what each row stands for.
    #[field(default = "receiver")]
    pub by: By,
    /// Write P90, P50 and P10 in place of the years of --every year: what is exceeded in 90, 50 and
    /// 10 % of the years of a weather file of several years.
    #[field(neutral, conflicts("model", "honeybee", "plot"))]
    pub percentiles: bool,
    /// Add the columns x, y, z, tilt_deg, azimuth_deg and area_m2 of each receiver to the table,
    /// which `build` can then read as its --receivers.
    #[field(neutral)]
    pub positions: bool,
    /// Write .parquet as a map (GeoParquet), one row with a polygon for each receiver, surface and
    /// so on.
    #[field(neutral)]
    pub geo: bool,
    /// Draw a picture of the results. A name that ends with .png is a map of the sums (or of one
    /// condition), from above and from the south-west; one that ends with .svg is a chart of the
    /// mean of all receivers, weighted by area: bars by component of --every day, month or year (or
    /// of conditions), hours of the day by month of --every hour. May be repeated; a table is then
    /// written only if --output names one.
    #[field(name = "plot", python = "plots", metavar = "FILE", output = File)]
    pub plots: Vec<PathBuf>,
    /// City model (CityJSON or CityJSONSeq) on whose surfaces the receivers were placed: an
    /// --output that ends with .city.json or .city.jsonl is this model with the sums added, and
    /// with a material theme `irradiation`.
    #[field(metavar = "INPUT.city.json", conflicts("honeybee", "plot"), input = Any)]
    pub model: Option<PathBuf>,
    /// Write a folder of hourly results that Honeybee and Pollination read, in place of a table,
    /// with a grid for each object (a room, a city object); --by building, surface or kind makes
    /// other grids.
    #[field(metavar = "FOLDER", conflicts("output", "plot"), output = Folder(&[]))]
    pub honeybee: Option<PathBuf>,
}

impl OutputRequest {
    /// Returns a request for a table or a map of receivers.
    pub fn new(output: impl Into<PathBuf>) -> Self {
        OutputRequest { output: output.into(), ..OutputRequest::default() }
    }

    /// Refuses files that cannot hold such results, and files that would replace an input, before
    /// anything is read.
    pub fn check(&self, columns: Option<&ComponentList>, every: Option<Every>, inputs: &[&Path]) -> Result<()> {
        if self.positions && self.by != By::Receiver {
            let what = message!("rows are about groups of receivers, {{by}} {}", self.by.name());
            return Err(
                Error::argument("positions", what, "leave {by} out, or {positions}").because(Problem::excludes("by"))
            );
        }
        if self.percentiles && every != Some(Every::Year) {
            let hint = "give a {weather} of several years and {every} year";
            return Err(Error::argument("percentiles", "are those of years", hint).because(Problem::needs("every")));
        }
        let inputs: Vec<&Path> = inputs.iter().copied().chain(self.model.as_deref()).collect();
        if self.output != Path::new("-") {
            files_of(&self.output).iter().try_for_each(|file| guard_output(file, &inputs))?;
        }
        charts::check(&self.plots, &inputs, every)?;
        match (&self.model, &self.honeybee) {
            (Some(model), _) => city_model::check(self, every, model),
            (_, Some(folder)) => honeybee::check(columns, every, folder),
            _ if is_city_model(&self.output) => {
                let hint = "give the city model from which the receivers were made: {model} INPUT.city.json";
                Err(Error::argument(
                    "output",
                    "a city model is written as a copy of another one, and none is given",
                    hint,
                )
                .because(Problem::needs("model")))
            }
            _ => ResultFormat::by_ending(&self.output, self.geo).map(drop),
        }
    }

    /// Returns true if a table is requested. If there are pictures, the default `-` does not count
    /// as a request for standard output.
    pub fn wants_table(&self) -> Result<bool> {
        let is_table = matches!(ResultFormat::by_ending(&self.output, self.geo)?, ResultFormat::Table(_));
        Ok(is_table && (self.plots.is_empty() || self.output != Path::new("-")))
    }

    /// Returns the requested maps: the output if it is one, and the pictures in `drawn`.
    pub fn maps<'p>(&self, drawn: impl Iterator<Item = &'p Path>) -> Result<Vec<MapFile>> {
        let output = match ResultFormat::by_ending(&self.output, self.geo)? {
            ResultFormat::Map(format) => Some(MapFile { path: self.output.clone(), format }),
            ResultFormat::Table(_) => None,
        };
        let picture = |path: &Path| MapFile { path: path.to_path_buf(), format: MapFormat::Png };
        Ok(output.into_iter().chain(drawn.map(picture)).collect())
    }

    /// Writes the results of a stream and returns a line about some kinds of files. `place` is the
    /// path of the archive or of the atlas.
    pub fn write(&self, stream: &TileStream, archives: Archives, place: &Path) -> Result<Option<String>> {
        let about = stream.about(archives, place);
        match (&self.model, &self.honeybee) {
            (Some(model), _) => {
                let mut sink = CityModelSink::new(stream, model, &self.output, place)?;
                stream.feed(&mut sink)?;
                sink.finish(&about, stream.resources.observer).map(Some)
            }
            (_, Some(folder)) => honeybee::write(stream, self.by, folder, about).map(Some),
            _ => {
                let called = format!("{} under {}", name_of(place), stream.series.called);
                let told = RowsAbout { called, about, place, scene: None };
                write_rows(self, Question::Irradiance, stream, &told, |sink| stream.feed(sink)).map(|()| None)
            }
        }
    }
}

/// Returns the name of a file for texts.
pub fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Returns the help of the output.
fn output_help() -> Message {
    let maps = MapFormat::ENDINGS.map(|(ending, _)| format!(".{ending}")).join(", ");
    table_help("Table to write").and(message!("; also maps: {maps}, .parquet with {{geo}}"))
}
