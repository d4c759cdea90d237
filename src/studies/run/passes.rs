//! Result files of a run: annual sums as a table and maps, the chart of the months, tables of other
//! periods, the city model with sums. In: the archive, weather. Out: these files, in one pass over
//! the receivers.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::folder::RunFiles;
use super::request::RunRequest;
use super::{RunMap, maps};
use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::site::receiver::Receiver;
use heliotile_results::outputs::annual::{AnnualRow, AnnualTable};
use heliotile_results::outputs::kinds_and_sides::KindsAndSides;
use heliotile_results::outputs::shapes::writer::MapFormat;
use heliotile_results::{
    Archives, AreaChart, By, CityModelSink, CoarseSinks, Every, LightRequest, MapFile, Provenance, Question,
    ReceiverSet, ReplayRequest, Resources, ResultSink, RowsAbout, Series, Sinks, Tile, TileSink, TileStream, name_of,
    rows_of,
};
use heliotile_weather::dated::DatedRows;
use heliotile_weather::series::Weather;

/// Inputs of the results.
pub struct RunResults<'a> {
    pub request: &'a RunRequest,
    pub files: &'a RunFiles,
    /// City model of the scene, if sums are to be written into it.
    pub city_model: Option<&'a Path>,
    pub archive: &'a Archive,
    pub weather: &'a Weather,
    /// Provenance, with the command of the run.
    pub about: Provenance,
}

/// Files that a pass over the receivers writes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Which {
    All,
    /// Annual sums and their maps.
    Annual,
    /// Files whose rows are put into a year.
    OfPeriods,
}

/// Sink that writes annual sums into the table and adds them up by kind and side.
struct AnnualSums<'a> {
    receivers: Box<dyn Iterator<Item = Result<Receiver>> + 'a>,
    table: AnnualTable,
    kinds: KindsAndSides,
}

impl TileSink for AnnualSums<'_> {
    fn components(&self) -> ComponentSet {
        ComponentSet::ALL
    }

    fn take(&mut self, tile: &Tile) -> Result<bool> {
        for (i, receiver) in self.receivers.by_ref().take(tile.ids.len()).enumerate() {
            let sum = |component: Component| tile.values.row(component, i).first().copied().unwrap_or_default();
            let row = AnnualRow { receiver: receiver?, kwh_m2: Component::ALL.map(sum) };
            self.table.write(&row)?;
            self.kinds.add(&row);
        }
        Ok(true)
    }
}

impl RunResults<'_> {
    /// Writes all files and returns the sums by kind of surface and side, as a text.
    pub fn write(&self, resources: &Resources) -> Result<String> {
        let asked = self.request;
        let tables = asked.every.iter().min().copied();
        let finest = tables.unwrap_or(Every::Month).min(Every::Month);
        let request = ReplayRequest { stamp: asked.stamp, every: finest, ..ReplayRequest::new(&asked.weather) };
        // Annual sums cover the whole file. Only rows of tables are put into a year, and only
        // tables need a note on years.
        let totals = ReplayRequest { every: Every::Total, ..request.clone() };
        let all_rows = totals.dated(self.weather, resources.observer)?;
        let of_tables = ReplayRequest { every: tables.unwrap_or(Every::Total), year: asked.year, ..request.clone() };
        let rows_of_year = of_tables.dated(self.weather, resources.observer)?;
        if asked.year.is_none() {
            return self.pass(&request, &all_rows, Which::All, resources);
        }
        self.pass(&request, &rows_of_year, Which::OfPeriods, resources)?;
        self.pass(&totals, &all_rows, Which::Annual, resources)
    }

    fn pass(&self, request: &ReplayRequest, rows: &DatedRows, which: Which, resources: &Resources) -> Result<String> {
        let RunResults { request: asked, files, archive, .. } = *self;
        let (with_annual, with_periods) = (which != Which::OfPeriods, which != Which::Annual);
        let (archives, place) = (Archives::one(archive), files.archive.as_path());
        let series = request.series(archives, self.weather, rows, self.about.clone(), resources)?;
        let (receivers, light) = (ReceiverSet::all_of(archive)?, LightRequest::default());
        let stream = TileStream { receivers: &receivers, light: &light, series: &series, resources: *resources };
        // All periods are summed from one replay of the finest one, so receivers are replayed once.
        let table_periods: &[Every] = if with_periods { &asked.every } else { &[] };
        let periods: BTreeSet<Every> = [Every::Total, Every::Month].iter().chain(table_periods).copied().collect();
        let by_period: BTreeMap<Every, Series> = periods.iter().map(|every| (*every, series.by(*every))).collect();
        let of = |every: Every| stream.with_series(&by_period[&every]);
        let (annual, month) = (of(Every::Total), of(Every::Month));
        let about = annual.about(archives, place);

        let (rows, _) = rows_of(&annual, Question::Irradiance, By::Receiver, place)?;
        let called = format!("{} under {}", name_of(place), name_of(&asked.weather));
        let told = RowsAbout { called, about: about.clone(), place, scene: None };
        let paths = if with_annual { self.maps() } else { Vec::new() };
        let sums = with_annual.then(|| {
            Ok(AnnualSums {
                receivers: Box::new(receivers.receivers()),
                table: AnnualTable::create(&files.table, receivers.count(), receivers.north(), &about)?,
                kinds: KindsAndSides::new(receivers.north()),
            })
        });
        let mut sums = sums.transpose()?;
        let mut maps =
            ResultSink::new(&rows, None, Question::Irradiance, &annual)?.with_maps(&paths, &annual, &told)?;
        let mut chart = AreaChart::new(&files.chart, &month, Question::Irradiance)?;
        let model = self.city_model.filter(|_| with_periods);
        let model = model.map(|model| CityModelSink::new(&annual, model, &files.city_model, place));
        let mut model = model.transpose()?;
        let of_period = |every: Every| rows_of(&of(every), Question::Irradiance, asked.by, place);
        let rows = table_periods.iter().map(|every| Ok((*every, of_period(*every)?)));
        let rows = rows.collect::<Result<Vec<_>>>()?;
        let mut tables = Vec::new();
        for (every, (rows, groups)) in &rows {
            let stream = of(*every);
            let table = ResultSink::new(rows, groups.clone(), Question::Irradiance, &stream)?;
            let about = stream.about(archives, place);
            tables.push((*every, table.with_table(&files.periods(*every, asked), &stream, &about)));
        }

        let mut sinks: BTreeMap<Every, Vec<&mut dyn TileSink>> = BTreeMap::new();
        if let Some(sums) = &mut sums {
            sinks.entry(Every::Total).or_default().extend([sums as &mut dyn TileSink, &mut maps]);
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
            tables.into_iter().try_for_each(|(_, table)| table.finish(resources.observer))?;
            model.map_or(Ok(String::new()), |model| model.finish(&about, resources.observer))?;
        }
        let Some(sums) = sums else { return Ok(String::new()) };
        maps.finish(resources.observer)?;
        sums.table.finish()?;
        Ok(sums.kinds.table())
    }

    /// Returns the map, the picture and the further maps.
    fn maps(&self) -> Vec<MapFile> {
        let file = |path: &Path, format| MapFile { path: path.to_owned(), format };
        let picture = file(&self.files.picture, MapFormat::Png);
        let maps = maps::formats(&self.request.maps);
        let maps = maps.map(|format| file(&self.files.map(RunMap::Map(format)), format));
        std::iter::once(picture).chain(maps).collect()
    }
}
