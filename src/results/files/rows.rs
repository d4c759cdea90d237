//! Tables and maps of receivers or of groups of them. In: a stream, the subject of rows. Out:
//! files, in one pass over the tiles.

use std::path::{Path, PathBuf};

use super::OutputRequest;
use super::charts::{AreaChart, Plot};
use super::map::{MapStart, say_large};
use crate::outputs::groups::{GroupGeometry, GroupMeans, Groups};
use crate::outputs::provenance::Provenance;
use crate::outputs::quantities::PlaceValues;
use crate::outputs::result_file::ResultFile;
use crate::outputs::row_maker::RowMaker;
use crate::outputs::shapes::writer::MapFormat;
use crate::outputs::tables::layout::{By, Fact, Layout, Question};
use crate::outputs::tables::writer::Places;
use crate::percentiles::Percentiles;
use crate::receivers::ReceiverSet;
use crate::resources::Resources;
use crate::stream::{Sinks, Tile, TileSink, TileStream};
use heliotile_core::error::Result;
use heliotile_core::memory::Use;
use heliotile_core::observer::Observer;
use heliotile_core::replay::components::{ComponentList, ComponentSet};
use heliotile_core::replay::values::TileValues;
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;

/// Metadata of files of rows.
pub struct RowsAbout<'a> {
    /// Description of the values in words, for pictures.
    pub called: String,
    /// Provenance of the values.
    pub about: Provenance,
    /// Path of the archive or of the atlas.
    pub place: &'a Path,
    /// Receivers whose scene maps show; `None`: the receivers of the rows.
    pub scene: Option<&'a ReceiverSet<'a>>,
}

/// Files of the same rows, being written.
pub struct RowFiles<'a> {
    rows: &'a RowMaker,
    /// Groups that rows are about; `None`: receivers.
    groups: Option<Groups>,
    /// Table that is created when the first row can be computed.
    table: Option<TableStart<'a>>,
    writers: Vec<(PathBuf, ResultFile<'a>)>,
}

/// Result files of one replay, or of two that are compared, being written.
pub struct ResultSink<'a> {
    components: ComponentList,
    /// Percentiles that rows hold in place of the series' years.
    percentiles: Option<Percentiles>,
    /// Means of groups in each archive, in the order of [`Tile::sides`]; empty if rows are about
    /// receivers.
    means: Vec<GroupMeans>,
    /// Receivers that are still to come, if the table has their positions.
    positions: Option<Positions<'a>>,
    north: North,
    files: RowFiles<'a>,
}

/// Receivers in the order of results.
type Positions<'a> = Box<dyn Iterator<Item = Result<Receiver>> + 'a>;

/// Map to write.
#[derive(Clone, Debug)]
pub struct MapFile {
    /// Path of the file.
    pub path: PathBuf,
    /// Format of the map.
    pub format: MapFormat,
}

/// Table to write.
struct TableStart<'a> {
    path: PathBuf,
    names: Box<dyn Fn() -> Result<Vec<String>> + 'a>,
    count: u64,
    about: Provenance,
}

/// Returns the rows of a stream about receivers or groups, and these groups; `place` is the path of
/// the archive or of the atlas.
pub fn rows_of(stream: &TileStream, question: Question, by: By, place: &Path) -> Result<(RowMaker, Option<Groups>)> {
    let (series, components) = (stream.series, stream.light.columns());
    let mut layout = match question {
        Question::Irradiance => Layout::of_components(series.kind, by, &components),
        Question::Change => Layout::of_changes(series.kind, by, &components),
    };
    let groups = groups_of(stream.receivers, by, place)?;
    if let Some(groups) = &groups {
        layout.facts = groups.facts(by, layout.has_energy);
    }
    Ok((RowMaker::new(layout, series.labels.clone(), series.every), groups))
}

/// Returns the groups of receivers that rows are about, with facings by true north; `None` if rows
/// are about receivers. `place` is the path of the archive or of the atlas.
pub fn groups_of(receivers: &ReceiverSet, by: By, place: &Path) -> Result<Option<Groups>> {
    match by {
        By::Receiver => Ok(None),
        by => Ok(Some(Groups::new(receivers.receivers(), by, place)?.facing(receivers.north()))),
    }
}

impl<'a> RowFiles<'a> {
    /// Returns a set of files that is still empty; rows are about `groups`, or about receivers if
    /// `None`.
    pub fn new(rows: &'a RowMaker, groups: Option<Groups>) -> Self {
        RowFiles { rows, groups, table: None, writers: Vec::new() }
    }

    /// Adds a table, which is created by `start`.
    pub fn with_table(mut self, path: &Path, receivers: &'a ReceiverSet<'a>, about: &Provenance) -> Self {
        let groups = self.groups.as_ref().map(|groups| groups.names().to_vec());
        let count = groups.as_ref().map_or(receivers.count(), |groups| groups.len() as u64);
        let names = move || groups.as_ref().map_or_else(|| receivers.names(), |groups| Ok(groups.clone()));
        let (path, about) = (path.to_owned(), about.clone());
        self.table = Some(TableStart { path, names: Box::new(names), count, about });
        self
    }

    /// Adds maps, which share the memory for maps.
    pub fn with_maps(
        mut self,
        maps: &'a [MapFile],
        receivers: &'a ReceiverSet<'a>,
        told: &'a RowsAbout<'a>,
        resources: &Resources<'a>,
    ) -> Result<Self> {
        let RowsAbout { called, about, place, .. } = told;
        let scene = told.scene.unwrap_or(receivers);
        for MapFile { path, format } in maps {
            let share = maps.len();
            let map = MapStart { path, format: *format, share, rows: self.rows, called, about, scene, receivers };
            let map = map.start(resources, self.groups.as_ref(), place)?;
            self.writers.push((path.clone(), ResultFile::Map(Box::new(map))));
        }
        Ok(self)
    }

    /// Creates the table. It is called once the replay is known to work, so a failed replay leaves
    /// no table.
    pub fn start(&mut self) -> Result<()> {
        if let Some(TableStart { path, names, count, about }) = self.table.take() {
            let places = Places { count, names: &*names };
            let table = self.rows.table(&path, &places, &about)?;
            self.writers.insert(0, (path, ResultFile::Table(self.rows, table)));
        }
        Ok(())
    }

    /// Hands the values of some places to all files; `extents` are the extents of groups.
    pub fn write(&mut self, names: &[String], values: &PlaceValues, extents: &[GroupGeometry]) -> Result<()> {
        self.writers.iter_mut().try_for_each(|(_, to)| to.write_tile(names, values, extents))
    }

    /// Returns true if the reader of a file, such as a pipe, has gone away.
    pub fn is_closed(&self) -> bool {
        self.writers.iter().any(|(_, to)| to.is_closed())
    }

    /// Completes the files.
    pub fn finish(self, observer: &dyn Observer) -> Result<()> {
        for (path, writer) in self.writers {
            if let Some(stats) = writer.finish()? {
                say_large(&path, &stats, observer);
            }
        }
        Ok(())
    }
}

impl<'a> ResultSink<'a> {
    /// Returns a sink of rows without any file yet.
    pub fn new(
        rows: &'a RowMaker,
        groups: Option<Groups>,
        question: Question,
        stream: &TileStream<'a>,
    ) -> Result<Self> {
        let memory = stream.resources.memory;
        let (sides, memory) = match question {
            Question::Irradiance => (1, memory.share(Use::SurfaceSums)),
            Question::Change => (2, memory.share(Use::ComparedSums) / 2),
        };
        let components = stream.light.columns();
        let means = groups.iter().flat_map(|groups| (0..sides).map(move |_| groups.clone()));
        let labels = stream.series.labels.len();
        let means = means.map(|groups| GroupMeans::new(groups, components.as_slice(), labels, memory));
        let means = means.collect::<Result<_>>()?;
        let has_positions = rows.layout().facts.contains(&Fact::Coordinate(0));
        let positions = has_positions.then(|| Box::new(stream.receivers.receivers()) as Positions);
        let north = stream.receivers.north();
        Ok(ResultSink { components, percentiles: None, means, positions, north, files: RowFiles::new(rows, groups) })
    }

    /// Writes percentiles in place of years.
    fn with_percentiles(self, percentiles: Option<Percentiles>) -> Self {
        ResultSink { percentiles, ..self }
    }

    /// Adds a table, which is created once the replay is known to work.
    pub fn with_table(mut self, path: &Path, stream: &TileStream<'a>, about: &Provenance) -> Self {
        self.files = self.files.with_table(path, stream.receivers, about);
        self
    }

    /// Adds maps, which share the memory for maps.
    pub fn with_maps(mut self, maps: &'a [MapFile], stream: &TileStream<'a>, told: &'a RowsAbout<'a>) -> Result<Self> {
        self.files = self.files.with_maps(maps, stream.receivers, told, &stream.resources)?;
        Ok(self)
    }

    /// Hands the values of some places in each archive to all files.
    fn write(&mut self, names: &[String], sides: &[&TileValues], extents: &[GroupGeometry]) -> Result<()> {
        let Some(percentiles) = &self.percentiles else {
            return self.files.write(names, &PlaceValues::new(sides, self.components.as_slice()), extents);
        };
        let of_years: Vec<TileValues> =
            sides.iter().map(|values| percentiles.of(values, self.components.set())).collect();
        let sides: Vec<&TileValues> = of_years.iter().collect();
        self.files.write(names, &PlaceValues::new(&sides, self.components.as_slice()), extents)
    }

    /// Returns the extents of the next receivers, if the table has their positions.
    fn extents(&mut self, count: usize) -> Result<Vec<GroupGeometry>> {
        let next = self.positions.iter_mut().flat_map(|all| all.take(count));
        next.map(|receiver| Ok(GroupGeometry::new(&receiver?, self.north))).collect()
    }

    /// Completes the files.
    pub fn finish(mut self, observer: &dyn Observer) -> Result<()> {
        let means = std::mem::take(&mut self.means);
        let mut sides: Vec<_> = means.iter().map(GroupMeans::tiles).collect();
        while let Some(tiles) = sides.iter_mut().map(Iterator::next).collect::<Option<Vec<_>>>() {
            let values: Vec<&TileValues> = tiles.iter().map(|(_, values, _)| values).collect();
            // There is a first side: this loop runs for groups only, with one archive or two.
            let Some((names, _, extents)) = tiles.first() else { break };
            self.write(names, &values, extents)?;
        }
        self.files.finish(observer)
    }
}

impl TileSink for ResultSink<'_> {
    fn components(&self) -> ComponentSet {
        self.components.set()
    }

    fn start(&mut self) -> Result<()> {
        self.files.start()
    }

    fn take(&mut self, tile: &Tile) -> Result<bool> {
        match self.means.is_empty() {
            true => {
                let extents = self.extents(tile.ids.len())?;
                self.write(tile.ids, &tile.sides().collect::<Vec<_>>(), &extents)?;
            }
            false => self.means.iter_mut().zip(tile.sides()).try_for_each(|(means, values)| means.add(values))?,
        }
        Ok(!self.files.is_closed())
    }
}

/// Writes the files of a request from the tiles that `feed` hands on.
pub fn write_rows<'s>(
    request: &'s OutputRequest,
    question: Question,
    stream: &TileStream<'s>,
    told: &'s RowsAbout<'s>,
    feed: impl FnOnce(&mut dyn TileSink) -> Result<()>,
) -> Result<()> {
    let RowsAbout { called, about, place, .. } = told;
    let plots = Plot::all(&request.plots, stream.series)?;
    let (mut rows, groups) = rows_of(stream, question, request.by, place)?;
    if request.positions {
        rows = rows.with_positions();
    }
    let percentiles = request.percentiles.then(|| Percentiles::new(stream.series, stream.resources.observer));
    let percentiles = percentiles.transpose()?;
    if percentiles.is_some() {
        rows = rows.with_labels(Percentiles::labels());
    }
    let drawn = plots.iter().filter(|(_, plot)| *plot == Plot::Map).map(|(path, _)| *path);
    let maps = request.maps(drawn)?;
    let mut sink = ResultSink::new(&rows, groups, question, stream)?.with_percentiles(percentiles);
    if request.wants_table()? {
        sink = sink.with_table(&request.output, stream, about);
    }
    sink = sink.with_maps(&maps, stream, told)?;
    let charts = plots.iter().filter(|(_, plot)| *plot != Plot::Map);
    let mut charts = charts.map(|(path, _)| AreaChart::new(path, stream, question)).collect::<Result<Vec<_>>>()?;
    let mut sinks = Sinks(vec![&mut sink]);
    sinks.0.extend(charts.iter_mut().map(|chart| chart as &mut dyn TileSink));
    feed(&mut sinks)?;
    sink.finish(stream.resources.observer)?;
    charts.into_iter().try_for_each(|chart| chart.finish(called, about))
}
