//! Light that objects take from receivers, and that they reflect to them. In: a stream of receivers
//! under a series. Out: a table with a row for each receiver or group, each object that it sees and
//! each period.

mod pictures;
mod sums;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::archives::Archives;
use crate::buildings::check_table;
use crate::outputs::pictures::bars;
use crate::outputs::shading::{ShareRows, write_shares};
use crate::outputs::tables::format::table_help;
use crate::outputs::tables::layout::By;
use crate::receivers::{PartReceivers, TileReceivers};
use crate::stream::TileStream;
use heliotile_core::error::{Error, Problem, Result, check_ranges};
use heliotile_core::named::NamedValues;
use heliotile_core::opened::{SceneObjects, SeenObject, SurfaceOf};
use heliotile_core::replay::by_object::ObjectDisc;
use heliotile_core::replay::receiver_view::ReceiverView;
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::text::{Message, counted, message};
use heliotile_requests::{DefaultRequest, Request};
use pictures::Hemisphere;
use sums::Sums;

/// Request for the light that objects take from receivers, and that they reflect to them.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct ShadingRequest {
    /// Table, in a format by the ending of its name; `-`: CSV on standard output.
    #[field(short = 'o', default = "-", help = output_help, output = Table)]
    pub output: PathBuf,
    /// Grouping of rows: what light is taken from.
    #[field(default = "receiver")]
    pub by: By,
    /// Grouping of rows: what takes light.
    #[field(default = "building")]
    pub takers: Takers,
    /// Draw a picture. A name that ends with .svg is a chart: what is taken from all receivers,
    /// stacked by what takes it, for each row of --every. One that ends with .png is what a single
    /// chosen receiver sees, in the colours of the chart. May be repeated; a table is then written
    /// only if --output names one.
    #[field(name = "plot", python = "plots", metavar = "FILE", output = File)]
    pub plots: Vec<PathBuf>,
}

/// Grouping of what takes light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Takers {
    /// Buildings, and other objects by name.
    #[default]
    Building,
    /// Objects by name.
    Object,
    /// Objects of one type together.
    Type,
}

/// Counts of what a table holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadingSummary {
    /// Number of receivers or groups.
    pub places: u64,
    /// Number of objects that take light or give it.
    pub takers: u64,
    /// Name of the object that takes most direct light, and its share of what all objects take,
    /// percent; `None` if nothing takes any.
    pub most: Option<(String, f64)>,
}

/// Object with its name in the table.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Taker {
    name: String,
    class: &'static str,
    /// True if it is what the receiver is on.
    is_own: bool,
}

impl ShadingSummary {
    /// Returns the summary as a sentence.
    pub fn text(&self) -> String {
        let most = self.most.as_ref().map_or_else(
            || "nothing takes direct light".to_owned(),
            |(name, percent)| format!("`{name}` takes most, {percent:.0} % of what all take"),
        );
        format!("{} and {} around them: {most}", counted(self.places, "place"), counted(self.takers, "object"))
    }
}

impl ShadingRequest {
    /// Refuses a table of an unknown ending, and one that would replace an input.
    pub fn check(&self, inputs: &[&Path]) -> Result<()> {
        check_ranges(self)?;
        pictures::check(&self.plots, inputs)?;
        check_table(&self.output, inputs)
    }

    /// Writes the table; `place` is the path of the archive or of the atlas.
    pub fn write(&self, stream: &TileStream, archives: Archives, place: &Path) -> Result<ShadingSummary> {
        let of_one = self.plots.iter().find(|plot| !pictures::is_chart(plot));
        if let Some(plot) = of_one.filter(|_| stream.receivers.count() != 1) {
            let what = message!(
                "`{}` shows what one receiver sees, and {} are chosen",
                plot.display(),
                stream.receivers.count()
            );
            let hint = "choose one with {receivers}, or give a name that ends with .svg";
            return Err(Error::argument("plot", what, hint).because(Problem::needs("receivers")));
        }
        if self.plots.iter().any(|plot| pictures::is_chart(plot)) {
            bars::check(stream.series.labels.len())?;
        }
        let mut hemisphere = None;
        let mut sums = Sums::new(self.by, stream, place)?;
        let progress = stream.receivers.progress(stream.resources.observer);
        for part in stream.receivers.parts().iter().filter(|part| !part.tiles().is_empty()) {
            let objects = self.add_part(part, stream, &mut sums, |count| progress.advance(count))?;
            if of_one.is_some() {
                hemisphere = self.hemisphere(part, &objects)?;
            }
        }
        let (summary, shares) = sums.finished();
        let rows = ShareRows { by: self.by, kind: stream.series.kind, labels: &stream.series.labels };
        let about = stream.about(archives, place);
        pictures::draw(&self.plots, &rows, &shares, hemisphere, &stream.series.called, &about)?;
        if self.plots.is_empty() || self.output != Path::new("-") {
            write_shares(&self.output, &rows, &shares, &about)?;
        }
        Ok(summary)
    }

    /// Returns what the chosen receiver of an archive sees, by name.
    fn hemisphere(&self, part: &PartReceivers, objects: &SceneObjects) -> Result<Option<Hemisphere>> {
        let mut rows =
            part.tiles().iter().flat_map(|tile| (0..part.site.tile_rows(tile.number)).map(move |row| (*tile, row)));
        let Some((tile, row)) = rows.find(|(tile, row)| part.is_chosen(*tile, *row)) else { return Ok(None) };
        let view = ReceiverView::at(&part.site, tile.number, row)?;
        let disc = ObjectDisc::of_view(&view, objects);
        let on = ModelPart::default();
        let names = disc.all().map(|seen| (seen, self.taker(seen, objects, part, &on).name)).collect();
        Ok(Some(Hemisphere { view, disc, names, place: part.archive.manifest().place, north: part.site.north() }))
    }

    /// Adds the light of the chosen receivers of an archive.
    fn add_part(
        &self,
        part: &PartReceivers,
        stream: &TileStream,
        sums: &mut Sums,
        advance: impl Fn(u64),
    ) -> Result<SceneObjects> {
        let replay = stream.by_object(part)?;
        let objects = SceneObjects::new(&part.site, part.archive.manifest().scene.origin_m.into())?;
        if objects.objects().is_empty() {
            let what = message!(
                "{}: names no objects, or a single one, so rows are materials (archives of models with named objects that hold their \
                 scene tell objects apart)",
                part.archive.path().display()
            );
            stream.resources.observer.note(what);
        }
        let mut receivers = part.rows::<()>();
        let together = rayon::current_num_threads().max(1);
        for tiles in part.tiles().chunks(together) {
            let light = |tile: &TileReceivers| replay.tile(tile.number, &objects, |row| part.is_chosen(*tile, row));
            let found = tiles.par_iter().map(light).collect::<Result<Vec<_>>>()?;
            for light in found.iter().flatten() {
                let Some(receiver) = receivers.next().transpose()? else { break };
                sums.add(&receiver.receiver, light, |seen| self.taker(seen, &objects, part, &receiver.receiver.part))?;
            }
            advance(found.iter().map(|tile| tile.len() as u64).sum());
            if stream.resources.observer.cancelled() {
                return Err(Error::Stopped { what: "before all receivers were replayed".into() });
            }
        }
        Ok(objects)
    }

    /// Returns the name and the class of what a receiver sees.
    fn taker(&self, seen: SeenObject, objects: &SceneObjects, part: &PartReceivers, on: &ModelPart) -> Taker {
        let class = match seen {
            SeenObject { of: SurfaceOf::Unknown, .. } => "unknown",
            SeenObject { is_ground: true, .. } => "ground",
            _ => "obstruction",
        };
        let SurfaceOf::Object(number) = seen.of else {
            let name = match seen.of {
                SurfaceOf::Material(number) => part.site.materials()[usize::from(number)].name.clone(),
                _ => "unknown".to_owned(),
            };
            return Taker { name, class, is_own: false };
        };
        let object = &objects.objects()[number as usize];
        let note = &object.note;
        let first = |texts: &[&String]| texts.iter().find(|text| !text.is_empty()).map_or("", |text| text).to_owned();
        let own_name = first(&[&note.object, &object.name]);
        let is_same = |one: &str, other: &str| !one.is_empty() && one == other;
        Taker {
            name: match self.takers {
                Takers::Building => first(&[&note.building, &own_name]),
                Takers::Object => own_name.clone(),
                Takers::Type => first(&[&note.object_type, &own_name]),
            },
            class,
            is_own: is_same(&note.building, &on.building) || is_same(&own_name, &on.object),
        }
    }
}

impl NamedValues for Takers {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("building", "Buildings with all of their parts, and other objects by name", Takers::Building),
        ("object", "Objects by name", Takers::Object),
        ("type", "Objects of one type together, such as all trees", Takers::Type),
    ];
}

heliotile_core::serde_by_name!(Takers);

heliotile_core::parse_by_name!(Takers);

/// Returns the help of the output.
fn output_help() -> Message {
    table_help("Table to write")
}
