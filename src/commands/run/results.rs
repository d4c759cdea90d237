//! What a run writes of its archive under weather: annual sums as a table and maps, the chart of the months, tables of other periods, the city
//! model with sums. In: the archive, weather. Out: these files, in one pass over the receivers.

use std::collections::{BTreeMap, BTreeSet, HashMap};
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
    Archives, AreaChart, By, CityModelSink, CoarseSinks, Every, LightChoice, Provenance, ReceiverSet, ReplayRequest,
    Resources, ResultRows, ResultSink, Series, Sinks, Tile, TileSink, TileStream, name_of,
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
        // Annual sums are over the whole file; only rows of tables are put into a year, and only tables need a note on years.
        let totals = ReplayRequest { every: Every::Total, ..request.clone() };
        let all_rows = totals.dated(self.weather, &terminal)?;
        let asked = ReplayRequest { every: tables.unwrap_or(Every::Total), year: args.year, ..request.clone() };
        let rows_of_year = asked.dated(self.weather, &terminal)?;
        if args.year.is_none() {
            return self.pass(&request, &all_rows, Which::All);
        }
        self.pass(&request, &rows_of_year, Which::OfPeriods)?;
        self.pass(&totals, &all_rows, Which::Annual)
    }

    fn pass(&self, request: &ReplayRequest, rows: &DatedRows, which: Which) -> Result<String> {
        let RunResults { args, files, archive, .. } = *self;
        let (with_annual, with_periods) = (which != Which::OfPeriods, which != Which::Annual);
        let (storage, terminal) = (temporary_files(), Terminal::default());
        let memory = MemoryBudget::new(args.memory.0);
        let resources = Resources { memory, storage: &storage, files: &read_file, observer: &terminal };
        let (archives, place) = (Archives::one(archive), files.archive.as_path());
        let series = request.series(archives, (self.weather, rows), self.about.clone(), &resources)?;
        let (receivers, light) = (ReceiverSet::all_of(archive)?, LightChoice::default());
        let stream = TileStream { receivers: &receivers, light: &light, series: &series, resources };
        let table_periods: &[Every] = if with_periods { &args.every } else { &[] };
        let periods: BTreeSet<Every> = [Every::Total, Every::Month].iter().chain(table_periods).copied().collect();
        let by_period: BTreeMap<Every, Series> = periods.iter().map(|every| (*every, series.by(*every))).collect();
        let of = |every: Every| stream.with_series(&by_period[&every]);
        let (annual, month) = (of(Every::Total), of(Every::Month));
        let about = annual.about(archives, place);

        let (rows, _) = ResultRows::new(&annual, By::Receiver, place)?;
        let called = format!("{} under {}", name_of(place), name_of(&args.weather));
        let paths = if with_annual { self.maps() } else { Vec::new() };
        let mut sums = AnnualSums { receivers: Box::new(receivers.receivers()), rows: Vec::new() };
        let mut maps = ResultSink::new(&rows, None, &annual)?;
        for (path, format) in &paths {
            maps = maps.with_map((path, *format), &annual, (&called, &about), place)?;
        }
        let mut chart = AreaChart::new(&files.chart, &month)?;
        let model = self.city_model.filter(|_| with_periods);
        let model = model.map(|model| CityModelSink::new(&annual, model, &files.city_model, place));
        let mut model = model.transpose()?;
        let rows = table_periods.iter().map(|every| Ok((*every, ResultRows::new(&of(*every), args.by, place)?)));
        let rows = rows.collect::<Result<Vec<_>>>()?;
        let mut tables = Vec::new();
        for (every, (rows, groups)) in &rows {
            let stream = of(*every);
            let table = ResultSink::new(rows, groups.clone(), &stream)?;
            let about = stream.about(archives, place);
            tables.push((*every, table.with_table(&files.periods(*every, args), &stream, &about)));
        }

        let mut sinks: BTreeMap<Every, Vec<&mut dyn TileSink>> = BTreeMap::new();
        if with_annual {
            sinks.entry(Every::Total).or_default().extend([&mut sums as &mut dyn TileSink, &mut maps]);
        }
        if with_periods {
            sinks.entry(Every::Month).or_default().push(&mut chart);
            model.iter_mut().for_each(|model| sinks.entry(Every::Total).or_default().push(model));
        }
        tables.iter_mut().for_each(|(every, table)| sinks.entry(*every).or_default().push(table));
        let coarse = |(every, sinks): (Every, _)| CoarseSinks::new(sinks, &series, &by_period[&every]);
        let mut coarse: Vec<CoarseSinks> = sinks.into_iter().map(coarse).collect();
        stream.feed(&mut Sinks(coarse.iter_mut().map(|sinks| sinks as &mut dyn TileSink).collect()))?;
        drop(coarse);

        if with_periods {
            let called = format!("{} under {}", name_of(place), series.called);
            chart.finish(&called, &month.about(archives, place))?;
            tables.into_iter().try_for_each(|(_, table)| table.finish(&terminal))?;
            model.map_or(Ok(String::new()), |model| model.finish(&about, &terminal))?;
        }
        if !with_annual {
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
