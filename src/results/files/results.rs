//! Results of a stream as tables and maps of receivers or of groups of them. In: a stream, what rows are about. Out: files, in one pass over the
//! tiles.

use std::path::{Path, PathBuf};

use super::FileRequest;
use super::charts::{AreaChart, Plot};
use super::map::{MapStart, say_large};
use crate::outputs::groups::{Extent, GroupMeans, Groups};
use crate::outputs::periods::Every;
use crate::outputs::provenance::Provenance;
use crate::outputs::quantities::PlaceValues;
use crate::outputs::result_table::ResultTable;
use crate::outputs::results::ResultWriter;
use crate::outputs::shapes::writer::MapFormat;
use crate::outputs::tables::format::Places;
use crate::outputs::tables::layout::{By, Layout};
use crate::outputs::tables::row_labels::RowLabels;
use crate::receivers::ReceiverSet;
use crate::resources::Resources;
use crate::stream::{Sinks, Tile, TileSink, TileStream};
use heliotile_core::error::Result;
use heliotile_core::memory::Use;
use heliotile_core::observer::Observer;
use heliotile_core::replay::components::{ComponentList, ComponentSet};
use heliotile_core::replay::values::TileValues;

/// What the columns of results say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// What places get.
    Irradiance,
    /// What places get before and after, and how that changes.
    Change,
}

/// What files of rows say of themselves.
pub struct RowsAbout<'a> {
    /// What the values are of, in words, for pictures.
    pub called: String,
    /// What they were made from.
    pub about: Provenance,
    /// Where the archive or the atlas lies.
    pub place: &'a Path,
    /// Whose scene maps show around; none: that of the receivers.
    pub scene: Option<&'a ReceiverSet<'a>>,
}

/// The rows of a file: which columns they have, and how many of them each place has.
pub struct ResultRows {
    layout: Layout,
    labels: RowLabels,
    every: Option<Every>,
}

/// Files of the same rows, being written.
pub struct RowFiles<'a> {
    rows: &'a ResultRows,
    /// Of groups, where rows are about them.
    groups: Option<Groups>,
    /// A table that begins with the first row.
    table: Option<TableStart<'a>>,
    writers: Vec<(PathBuf, ResultWriter<'a>)>,
}

/// Files of results of a replay or of two of them, being written.
pub struct ResultSink<'a> {
    components: ComponentList,
    /// Of groups: their means in each archive, in the order of [`Tile::sides`].
    means: Vec<GroupMeans>,
    files: RowFiles<'a>,
}

/// A map to write.
#[derive(Clone, Debug)]
pub struct MapFile {
    /// Its name.
    pub path: PathBuf,
    /// Its format.
    pub format: MapFormat,
}

/// A table that is to be written.
struct TableStart<'a> {
    path: PathBuf,
    names: Box<dyn Fn() -> Result<Vec<String>> + 'a>,
    count: u64,
    about: Provenance,
}

impl ResultRows {
    /// Rows of a stream about receivers or groups of them, and these groups; `place` is that of the archive or of the atlas.
    pub fn new(stream: &TileStream, question: Question, by: By, place: &Path) -> Result<(Self, Option<Groups>)> {
        let (series, components) = (stream.series, stream.light.columns());
        let mut layout = match question {
            Question::Irradiance => Layout::of_components(series.kind, by, &components),
            Question::Change => Layout::of_changes(series.kind, by, &components),
        };
        let groups = groups_of(stream.receivers, by, place)?;
        if let Some(groups) = &groups {
            layout.facts = groups.facts(by, layout.has_energy);
        }
        Ok((ResultRows::of(layout, series.labels.clone(), series.every), groups))
    }

    /// Rows of these columns and labels.
    pub fn of(layout: Layout, labels: RowLabels, every: Option<Every>) -> Self {
        ResultRows { layout, labels, every }
    }

    /// The columns.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Labels of the rows of a place.
    pub fn labels(&self) -> &RowLabels {
        &self.labels
    }

    /// What a label stands for; none in a query.
    pub fn every(&self) -> Option<Every> {
        self.every
    }
}

/// The groups of receivers that rows are about, facing by true north; none where they are about receivers. `place` is that of the archive or of
/// the atlas.
pub fn groups_of(receivers: &ReceiverSet, by: By, place: &Path) -> Result<Option<Groups>> {
    match by {
        By::Receiver => Ok(None),
        by => Ok(Some(Groups::new(receivers.receivers(), by, place)?.facing(receivers.north()))),
    }
}

impl<'a> RowFiles<'a> {
    /// No file yet, of rows about groups, or about receivers where there are none.
    pub fn new(rows: &'a ResultRows, groups: Option<Groups>) -> Self {
        RowFiles { rows, groups, table: None, writers: Vec::new() }
    }

    /// Also writes a table, which begins with the first row.
    pub fn with_table(mut self, path: &Path, receivers: &'a ReceiverSet<'a>, about: &Provenance) -> Self {
        let groups = self.groups.as_ref().map(|groups| groups.names().to_vec());
        let count = groups.as_ref().map_or(receivers.count(), |groups| groups.len() as u64);
        let names = move || groups.as_ref().map_or_else(|| receivers.names(), |groups| Ok(groups.clone()));
        let (path, about) = (path.to_owned(), about.clone());
        self.table = Some(TableStart { path, names: Box::new(names), count, about });
        self
    }

    /// Also writes maps, which share the memory for them.
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
            self.writers.push((path.clone(), ResultWriter::Map(Box::new(map))));
        }
        Ok(self)
    }

    /// Starts the table: what it is made of is known to work.
    pub fn start(&mut self) -> Result<()> {
        if let Some(TableStart { path, names, count, about }) = self.table.take() {
            let places = Places { count, names: &*names };
            let table = ResultTable::create(&path, &self.rows.layout, &self.rows.labels, &places, &about)?;
            self.writers.insert(0, (path, ResultWriter::Table(table)));
        }
        Ok(())
    }

    /// Hands the values of some places to all files; `extents` are those of groups.
    pub fn write(&mut self, names: &[String], values: &PlaceValues, extents: &[Extent]) -> Result<()> {
        self.writers.iter_mut().try_for_each(|(_, to)| to.write_tile(names, values, extents))
    }

    /// Whether a reader has gone away.
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
    /// A sink of rows that no file takes yet.
    pub fn new(rows: &'a ResultRows, groups: Option<Groups>, question: Question, stream: &TileStream) -> Result<Self> {
        let memory = stream.resources.memory;
        let (sides, memory) = match question {
            Question::Irradiance => (1, memory.share(Use::SurfaceSums)),
            Question::Change => (2, memory.share(Use::ComparedSums) / 2),
        };
        let components = stream.light.columns();
        let means = groups.iter().flat_map(|groups| (0..sides).map(move |_| groups.clone()));
        let means = means.map(|groups| GroupMeans::new(groups, components.as_slice(), rows.labels.len(), memory));
        let means = means.collect::<Result<_>>()?;
        Ok(ResultSink { components, means, files: RowFiles::new(rows, groups) })
    }

    /// Also writes a table, which begins once the replay is known to work.
    pub fn with_table(mut self, path: &Path, stream: &TileStream<'a>, about: &Provenance) -> Self {
        self.files = self.files.with_table(path, stream.receivers, about);
        self
    }

    /// Also writes maps, which share the memory for them.
    pub fn with_maps(mut self, maps: &'a [MapFile], stream: &TileStream<'a>, told: &'a RowsAbout<'a>) -> Result<Self> {
        self.files = self.files.with_maps(maps, stream.receivers, told, &stream.resources)?;
        Ok(self)
    }

    /// Hands the values of some places in all archives to all files.
    fn write(&mut self, names: &[String], sides: &[&TileValues], extents: &[Extent]) -> Result<()> {
        self.files.write(names, &PlaceValues::of(sides, self.components.as_slice()), extents)
    }

    /// Completes the files.
    pub fn finish(mut self, observer: &dyn Observer) -> Result<()> {
        let means = std::mem::take(&mut self.means);
        let mut sides: Vec<_> = means.iter().map(GroupMeans::tiles).collect();
        while let Some(tiles) = sides.iter_mut().map(Iterator::next).collect::<Option<Vec<_>>>() {
            let values: Vec<&TileValues> = tiles.iter().map(|(_, values, _)| values).collect();
            // An archive or two always have a first one.
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
            true => self.write(tile.ids, &tile.sides().collect::<Vec<_>>(), &[])?,
            false => self.means.iter_mut().zip(tile.sides()).try_for_each(|(means, values)| means.add(values))?,
        }
        Ok(!self.files.is_closed())
    }
}

/// Writes the files of a request, of what `feed` hands on.
pub fn write_rows<'s>(
    request: &'s FileRequest,
    question: Question,
    stream: &TileStream<'s>,
    told: &'s RowsAbout<'s>,
    feed: impl FnOnce(&mut dyn TileSink) -> Result<()>,
) -> Result<()> {
    let RowsAbout { called, about, place, .. } = told;
    let plots = Plot::all(&request.plots, stream.series)?;
    let (rows, groups) = ResultRows::new(stream, question, request.by, place)?;
    let drawn = plots.iter().filter(|(_, plot)| *plot == Plot::Map).map(|(path, _)| *path);
    let maps = request.maps(drawn)?;
    let mut sink = ResultSink::new(&rows, groups, question, stream)?;
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
