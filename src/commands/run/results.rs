//! What a run writes of its archive under weather: annual sums as a table and maps, the chart of the months, tables of other periods, the city
//! model with sums. In: the archive, weather. Out: these files, in one pass over the receivers.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::folder::Files;
use super::maps;
use crate::cli::{RunArgs, RunMap};
use crate::commands::temporary_files;
use crate::commands::terminal::Terminal;
use crate::covering::Covered;
use crate::files::read_file;
use crate::outputs::annual::{AnnualRow, Patch, write_ply, write_table};
use crate::outputs::kinds_and_sides::by_kind_and_side;
use crate::outputs::shapes::writer::MapFormat;
use crate::outputs::sink::Sink;
use crate::results::{
    Archives, AreaChart, By, CityModelSink, CoarseSink, Every, LightChoice, Provenance, ReceiverSet, ReplayRequest,
    Resources, ResultRows, ResultSink, Series, Tile, TileSink, TileStream, name_of,
};
use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::weather::dated::DatedRows;
use heliotile_core::weather::series::Weather;
use heliotile_scene::covering::cover::Piece;

/// What results are made of.
pub struct RunResults<'a> {
    pub args: &'a RunArgs,
    pub files: &'a Files,
    /// The city model of the scene, if sums are to be written into it.
    pub city_model: Option<&'a Path>,
    pub covered: Option<&'a Covered>,
    pub archive: &'a Archive,
    pub weather: &'a Weather,
    /// The command that they are made by.
    pub about: Provenance,
}

/// Which files a pass over the receivers writes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Which {
    All,
    /// Annual sums and their maps.
    Annual,
    /// Those whose rows are put into a year.
    OfPeriods,
}

/// Sums of each receiver, kept for the table and the map.
struct AnnualSums<'a> {
    receivers: Box<dyn Iterator<Item = Result<Receiver>> + 'a>,
    rows: Vec<AnnualRow>,
}

impl TileSink for AnnualSums<'_> {
    fn components(&self) -> ComponentSet {
        ComponentSet::ALL
    }

    fn take(&mut self, tile: &Tile) -> Result<bool> {
        for (i, receiver) in self.receivers.by_ref().take(tile.ids.len()).enumerate() {
            let sum = |component: Component| tile.values.row(component, i).first().copied().unwrap_or_default();
            self.rows.push(AnnualRow { receiver: receiver?, kwh_m2: Component::ALL.map(sum) });
        }
        Ok(true)
    }
}

impl RunResults<'_> {
    /// Writes all files; the sums by kind of surface and side, as a text.
    pub fn write(&self) -> Result<String> {
        let (args, terminal) = (self.args, Terminal::default());
        let tables = args.every.iter().min().copied();
        let finest = tables.unwrap_or(Every::Month).min(Every::Month);
        let request = ReplayRequest { stamp: args.stamp, every: finest, ..ReplayRequest::of(&args.weather) };
        // Sums are over the whole file, whatever year rows are put into; nobody asked for the chart's years.
        let annual = ReplayRequest { every: Every::Total, ..request.clone() }.dated(self.weather, &terminal)?;
        let asked = ReplayRequest { every: tables.unwrap_or(Every::Total), year: args.year, ..request.clone() };
        let periods = asked.dated(self.weather, &terminal)?;
        if args.year.is_none() {
            return self.pass(&request, &annual, Which::All);
        }
        self.pass(&request, &periods, Which::OfPeriods)?;
        self.pass(&request, &annual, Which::Annual)
    }

    fn pass(&self, request: &ReplayRequest, rows: &DatedRows, which: Which) -> Result<String> {
        let RunResults { args, files, archive, .. } = *self;
        let (storage, terminal) = (temporary_files(), Terminal::default());
        let memory = MemoryBudget::new(args.memory.0);
        let resources = Resources { memory, storage: &storage, files: &read_file, observer: &terminal };
        let (archives, place) = (Archives::one(archive), files.archive.as_path());
        let series = request.series(archives, (self.weather, rows), self.about.clone(), &resources)?;
        let (receivers, light) = (ReceiverSet::all_of(archive)?, LightChoice::default());
        let stream = TileStream { receivers: &receivers, light: &light, series: &series, resources };
        let by_period: HashMap<Every, Series> = Every::ALL.into_iter().map(|every| (every, series.by(every))).collect();
        let of = |every: Every| stream.with_series(&by_period[&every]);
        let (annual, month) = (of(Every::Total), of(Every::Month));
        let (about, about_months) = (annual.about(archives, place), month.about(archives, place));

        let (rows, _) = ResultRows::new(&annual, By::Receiver, place)?;
        let (months, _) = ResultRows::new(&month, By::Receiver, place)?;
        let with = |some: Which| which == Which::All || which == some;
        let mut sums = AnnualSums { receivers: Box::new(receivers.receivers()), rows: Vec::new() };
        let paths = self.maps();
        let mut maps = ResultSink::new(&rows, None, &annual)?;
        let called = format!("{} under {}", name_of(place), name_of(&args.weather));
        for (path, format) in paths.iter().filter(|_| with(Which::Annual)) {
            maps = maps.with_map((path, *format), &annual, (&called, &about), place)?;
        }
        let mut chart = AreaChart::new(&files.chart, &month, months.layout().clone())?;
        let tables = args.every.iter().map(|every| Ok((*every, ResultRows::new(&of(*every), args.by, place)?)));
        let tables = tables.collect::<Result<Vec<_>>>()?;
        let mut tables_written = Vec::new();
        for (every, (rows, groups)) in &tables {
            let stream = of(*every);
            let table = ResultSink::new(rows, groups.clone(), &stream)?;
            let about = stream.about(archives, place);
            tables_written.push((*every, table.with_table(&files.periods(*every, args), &stream, &about)));
        }
        let model = self.city_model.map(|model| CityModelSink::new(&annual, model, &files.city_model, place));
        let mut model = model.transpose()?;

        let mut sinks: Vec<(Every, &mut dyn TileSink)> = Vec::new();
        if with(Which::Annual) {
            sinks.push((Every::Total, &mut sums));
            sinks.push((Every::Total, &mut maps));
        }
        if with(Which::OfPeriods) {
            sinks.push((Every::Month, &mut chart));
            sinks.extend(tables_written.iter_mut().map(|(every, sink)| (*every, sink as &mut dyn TileSink)));
            sinks.extend(model.iter_mut().map(|model| (Every::Total, model as &mut dyn TileSink)));
        }
        let coarse = |(every, sink): (Every, _)| CoarseSink::of(sink, &series, &by_period[&every]);
        let mut sinks: Vec<CoarseSink> = sinks.into_iter().map(coarse).collect();
        stream.feed(&mut sinks.iter_mut().map(|sink| sink as &mut dyn TileSink).collect::<Vec<_>>())?;
        drop(sinks);

        if with(Which::OfPeriods) {
            let called = format!("{} under {}", name_of(place), series.called);
            chart.finish(&called, &about_months)?;
            tables_written.into_iter().try_for_each(|(_, table)| table.finish(&terminal))?;
            model.map_or(Ok(String::new()), |model| model.finish(&about, &terminal))?;
        }
        if !with(Which::Annual) {
            return Ok(String::new());
        }
        maps.finish(&terminal)?;
        write_table(&files.table, &sums.rows, receivers.north(), &about)?;
        self.write_ply(&sums.rows, &about)?;
        Ok(by_kind_and_side(&sums.rows, receivers.north()))
    }

    /// The picture and the further maps.
    fn maps(&self) -> Vec<(PathBuf, MapFormat)> {
        let further = maps::formats(self.args).map(|format| (self.files.further_map(RunMap::Map(format)), format));
        further.chain([(self.files.picture.clone(), MapFormat::Png)]).collect()
    }

    fn write_ply(&self, rows: &[AnnualRow], about: &Provenance) -> Result<()> {
        let pieces: HashMap<String, &Piece> =
            self.covered.into_iter().flat_map(Covered::free).map(|(name, piece, ..)| (name, piece)).collect();
        let patch = |row: &AnnualRow| Patch {
            triangles: pieces.get(&row.receiver.id).map_or(&[][..], |piece| &piece.triangles),
            middle: row.receiver.position,
            total_kwh_m2: row.total(),
        };
        let patches: Vec<Patch> = rows.iter().map(patch).collect();
        write_ply(Sink::file(&self.files.map)?, &patches, about)
    }
}
