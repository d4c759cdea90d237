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
use crate::outputs::results::{ResultFormat, ResultWriter};
use crate::outputs::shapes::writer::MapFormat;
use crate::outputs::tables::format::Places;
use crate::outputs::tables::layout::{By, Layout};
use crate::outputs::tables::row_labels::RowLabels;
use crate::receivers::ReceiverSet;
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
    question: Question,
    components: ComponentList,
    layout: Layout,
    labels: RowLabels,
    every: Option<Every>,
}

/// Files of the same rows, being written.
pub struct ResultSink<'a> {
    rows: &'a ResultRows,
    /// Of groups: their means in each archive, in the order of [`Tile::sides`].
    means: Vec<GroupMeans>,
    /// A table that begins with the first tile.
    table: Option<TableStart<'a>>,
    writers: Vec<(PathBuf, ResultWriter<'a>)>,
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
        let groups = match by {
            By::Receiver => None,
            by => {
                let receivers = stream.receivers;
                let groups = Groups::new(receivers.receivers(), by, place)?.facing(receivers.north());
                layout.facts = groups.facts(by, layout.has_energy);
                Some(groups)
            }
        };
        let (labels, every) = (series.labels.clone(), series.every);
        Ok((ResultRows { question, components, layout, labels, every }, groups))
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

impl<'a> ResultSink<'a> {
    /// A sink of rows that no file takes yet.
    pub fn new(rows: &'a ResultRows, groups: Option<Groups>, stream: &TileStream) -> Result<Self> {
        let memory = stream.resources.memory;
        let (sides, memory) = match rows.question {
            Question::Irradiance => (1, memory.share(Use::SurfaceSums)),
            Question::Change => (2, memory.share(Use::ComparedSums) / 2),
        };
        let (components, labels) = (rows.components.as_slice(), rows.labels.len());
        let means = groups.into_iter().flat_map(|groups| (0..sides).map(move |_| groups.clone()));
        let means = means.map(|groups| GroupMeans::new(groups, components, labels, memory));
        Ok(ResultSink { rows, means: means.collect::<Result<_>>()?, table: None, writers: Vec::new() })
    }

    /// Also writes a table, which begins once the replay is known to work.
    pub fn with_table(mut self, path: &Path, stream: &TileStream<'a>, about: &Provenance) -> Self {
        let (receivers, groups) = (stream.receivers, self.means.first().map(|means| means.groups().names().to_vec()));
        let count = groups.as_ref().map_or(receivers.count(), |groups| groups.len() as u64);
        let names = move || groups.as_ref().map_or_else(|| receivers.names(), |groups| Ok(groups.clone()));
        let (path, about) = (path.to_owned(), about.clone());
        self.table = Some(TableStart { path, names: Box::new(names), count, about });
        self
    }

    /// Also writes maps, which share the memory for them.
    pub fn with_maps(mut self, maps: &'a [MapFile], stream: &TileStream<'a>, told: &'a RowsAbout<'a>) -> Result<Self> {
        let RowsAbout { called, about, place, .. } = told;
        let scene = told.scene.unwrap_or(stream.receivers);
        for MapFile { path, format } in maps {
            let map = MapStart { path, format: *format, share: maps.len(), rows: self.rows, called, about, scene };
            let map = map.start(stream, self.means.first().map(GroupMeans::groups), place)?;
            self.writers.push((path.clone(), ResultWriter::Map(Box::new(map))));
        }
        Ok(self)
    }

    /// Hands the values of some places in all archives to all files.
    fn write(&mut self, names: &[String], sides: &[&TileValues], extents: &[Extent]) -> Result<()> {
        let values = PlaceValues::of(sides, self.rows.components.as_slice());
        self.writers.iter_mut().try_for_each(|(_, to)| to.write_tile(names, &values, extents))
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
        for (path, writer) in self.writers {
            if let Some(stats) = writer.finish()? {
                say_large(&path, &stats, observer);
            }
        }
        Ok(())
    }
}

impl TileSink for ResultSink<'_> {
    fn components(&self) -> ComponentSet {
        self.rows.components.set()
    }

    fn start(&mut self) -> Result<()> {
        if let Some(TableStart { path, names, count, about }) = self.table.take() {
            let places = Places { count, names: &*names };
            let table = ResultTable::create(&path, &self.rows.layout, &self.rows.labels, &places, &about)?;
            self.writers.insert(0, (path, ResultWriter::Table(table)));
        }
        Ok(())
    }

    fn take(&mut self, tile: &Tile) -> Result<bool> {
        match self.means.is_empty() {
            true => self.write(tile.ids, &tile.sides().collect::<Vec<_>>(), &[])?,
            false => self.means.iter_mut().zip(tile.sides()).try_for_each(|(means, values)| means.add(values))?,
        }
        Ok(!self.writers.iter().any(|(_, to)| to.is_closed()))
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
    let (output, RowsAbout { called, about, place, .. }) = (request.output.as_path(), told);
    let plots = Plot::all(&request.plots, stream.series)?;
    let (rows, groups) = ResultRows::new(stream, question, request.by, place)?;
    let mut maps = Vec::new();
    let mut sink = ResultSink::new(&rows, groups, stream)?;
    match ResultFormat::of(output, request.geo)? {
        ResultFormat::Map(format) => maps.push(MapFile { path: output.to_owned(), format }),
        ResultFormat::Table(_) if request.wants_table() => sink = sink.with_table(output, stream, about),
        ResultFormat::Table(_) => {}
    }
    let drawn = plots.iter().filter(|(_, plot)| *plot == Plot::Map);
    maps.extend(drawn.map(|(path, _)| MapFile { path: path.to_path_buf(), format: MapFormat::Png }));
    sink = sink.with_maps(&maps, stream, told)?;
    let charts = plots.iter().filter(|(_, plot)| *plot != Plot::Map);
    let mut charts = charts.map(|(path, _)| AreaChart::new(path, stream, question)).collect::<Result<Vec<_>>>()?;
    let mut sinks = Sinks(vec![&mut sink]);
    sinks.0.extend(charts.iter_mut().map(|chart| chart as &mut dyn TileSink));
    feed(&mut sinks)?;
    sink.finish(stream.resources.observer)?;
    charts.into_iter().try_for_each(|chart| chart.finish(called, about))
}
