//! Charts of results. In: names of files, a stream. Out: the kind of picture of each file, and
//! charts of the mean over receivers. Maps are drawn by [`super::map`].

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::Series;
use crate::outputs::area_means::AreaMeans;
use crate::outputs::periods::Every;
use crate::outputs::pictures::bars::{self, Bars, Stack};
use crate::outputs::pictures::carpet::{Carpet, HOURS};
use crate::outputs::pictures::colours::{COMPONENTS, ColourScale};
use crate::outputs::pictures::scale::titled;
use crate::outputs::provenance::Provenance;
use crate::outputs::quantities::{Quantity, capital};
use crate::outputs::sink::Sink;
use crate::outputs::tables::layout::{By, Layout, Question};
use crate::stream::{Tile, TileSink, TileStream};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::replay::components::{ComponentList, ComponentSet};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::message;
use heliotile_files::writing::claim::same_place;
use heliotile_files::writing::guards::guard_output;

/// Largest number of days that are columns of their own; longer series have a column for each
/// month.
const MAX_DAYS: usize = 62;
/// Distance of a bar's colour from the middle of a scale around zero, as a share of the half scale.
const BAR_SHARE: f32 = 0.6;
/// Colour of bars that are not split into components.
const ONE_COLOUR: [u8; 3] = [0x5b, 0x67, 0x72];

/// Kind of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Plot {
    Map,
    /// Bars of periods, stacked by component.
    Bars,
    /// Hours of the day by month.
    Hours,
}

impl Plot {
    /// Returns the kind of picture by the ending of a name and the period of rows; a query has no
    /// period.
    fn by_ending(path: &Path, every: Option<Every>) -> Result<Self> {
        let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        match (ending.as_deref(), every) {
            (Some("png"), _) => Ok(Plot::Map),
            (Some("svg"), Some(Every::Hour)) => Ok(Plot::Hours),
            (Some("svg"), Some(Every::Total)) => Err(Error::argument(
                "plot",
                message!("`{}` is a chart over time, and {{every}} total gives only one sum", path.display()),
                "give {every} month (bars) or hour (hours of the day by month), or a name that ends with .png for a map",
            ).because(Problem::excludes("every"))),
            (Some("svg"), _) => Ok(Plot::Bars),
            _ => Err(Error::Unsupported {
                what: "ending of a picture".into(),
                found: format!("`{}`", path.display()),
                supported: ".png for a map, .svg for a chart".into(),
            }),
        }
    }

    /// Returns the kind of each file's picture. Fails if one cannot be drawn for the series.
    pub fn all<'p>(paths: &'p [PathBuf], series: &Series) -> Result<Vec<(&'p Path, Plot)>> {
        let count = series.labels.len();
        let plot = |path: &'p PathBuf| {
            let plot = Plot::by_ending(path, series.every)?;
            match plot {
                Plot::Map if count != 1 && series.every != Some(Every::Month) => {
                    let hint = match series.every {
                        None => "give {conditions} with one line, or a name that ends with .svg for bars",
                        Some(_) => "give {every} month or total, or a name that ends with .svg for a chart",
                    };
                    let what =
                        format!("`{}` is a map, which shows one value for each place, not {count}", path.display());
                    Err(Error::argument("plot", what, hint).because(Problem::excludes("every")))
                }
                Plot::Bars => bars::check(count).map(|()| (path.as_path(), plot)),
                _ => Ok((path.as_path(), plot)),
            }
        };
        paths.iter().map(plot).collect()
    }
}

/// Refuses pictures of unknown endings, and pictures that would replace an input or each other.
pub fn check(plots: &[PathBuf], inputs: &[&Path], every: Option<Every>) -> Result<()> {
    for (i, path) in plots.iter().enumerate() {
        Plot::by_ending(path, every)?;
        guard_output(path, inputs)?;
        // A table cannot have the same name: it has another ending.
        if plots.iter().take(i).any(|other| same_place(other, path)) {
            let what = format!("`{}` is written twice", path.display());
            return Err(Error::argument("plot", what, "give each output a name of its own"));
        }
    }
    Ok(())
}

/// Chart of the mean by area over the receivers of a stream.
pub struct AreaChart<'a> {
    path: &'a Path,
    plot: Plot,
    series: &'a Series,
    components: ComponentList,
    means: AreaMeans,
    /// Means after; only in a comparison.
    after: Option<AreaMeans>,
    receivers: Box<dyn Iterator<Item = Result<Receiver>> + 'a>,
}

impl<'a> AreaChart<'a> {
    /// Returns a chart for an SVG file: bars of days, months, years or conditions, or hours of the
    /// day by month if rows are hours. In a comparison the chart shows the change of the main
    /// component.
    pub fn new(path: &'a Path, stream: &TileStream<'a>, question: Question) -> Result<Self> {
        let plot = Plot::by_ending(path, stream.series.every)?;
        let components = stream.light.columns();
        let means = AreaMeans::new(components.as_slice(), stream.series.labels.len());
        let after = (question == Question::Change).then(|| means.clone());
        let receivers = Box::new(stream.receivers.receivers());
        Ok(AreaChart { path, plot, series: stream.series, components, means, after, receivers })
    }

    /// Writes the chart; `called` describes its content.
    pub fn finish(self, called: &str, about: &Provenance) -> Result<()> {
        let called = about.with_place(&format!("{called}; {}", self.means.called()));
        let drawing = match self.plot {
            Plot::Hours => self.carpet(called).drawing(),
            Plot::Bars | Plot::Map => self.bars(called).drawing(),
        };
        let mut sink = Sink::file(self.path)?;
        sink.write_all(drawing.svg_file(about).as_bytes()).map_err(Error::io(self.path, "write to"))?;
        sink.finish().map(drop)
    }

    /// Returns the mean of the main component, or its change, for each label.
    fn main(&self) -> Vec<f64> {
        let of = |means: &AreaMeans| means.mean(self.components.main()).unwrap_or_default();
        let before = of(&self.means);
        match &self.after {
            Some(after) => before.iter().zip(of(after)).map(|(before, after)| after - before).collect(),
            None => before,
        }
    }

    /// Returns the columns that the chart shows, with their words and units.
    fn layout(&self) -> Layout {
        let of = if self.after.is_some() { Layout::of_changes } else { Layout::of_components };
        of(self.series.kind, By::Receiver, &self.components)
    }

    fn scale(&self) -> ColourScale {
        if self.after.is_some() { ColourScale::AroundZero } else { ColourScale::FromZero }
    }
}

impl TileSink for AreaChart<'_> {
    fn components(&self) -> ComponentSet {
        self.components.set()
    }

    fn take(&mut self, tile: &Tile) -> Result<bool> {
        for (row, receiver) in self.receivers.by_ref().take(tile.ids.len()).enumerate() {
            let receiver = receiver?;
            self.means.add(&receiver, tile.values, row);
            if let (Some(means), Some(values)) = (&mut self.after, tile.after) {
                means.add(&receiver, values, row);
            }
        }
        Ok(true)
    }
}

impl AreaChart<'_> {
    fn bars(&self, called: String) -> Bars {
        let layout = self.layout();
        let main = layout.main_quantity();
        let stacks = if self.after.is_some() { self.change() } else { self.parts(main) };
        let what = match stacks.len() {
            // Names of parts stand in the legend.
            2.. if self.after.is_none() => layout.light_noun().to_owned(),
            _ => layout.title(),
        };
        let by = match self.series.every {
            Some(Every::Day) => "day",
            Some(Every::Month) => "month",
            Some(_) => "year",
            None => "condition",
        };
        let title = capital(&format!("{what} by {by}"));
        let labels = self.series.labels.text.clone();
        Bars { title, called, unit: layout.unit_of(main).into(), labels, stacks, scale: self.scale() }
    }

    /// Returns the requested components that add up to the total, or else the main component alone.
    fn parts(&self, main: &Quantity) -> Vec<Stack> {
        let parts = COMPONENTS.iter().filter(|(one, ..)| self.components.as_slice().contains(one));
        let mut stacks: Vec<Stack> = parts
            .map(|(one, colour, name)| {
                let values = self.means.mean(*one).unwrap_or_default();
                Stack { name: (*name).into(), colour: *colour, values }
            })
            .collect();
        if stacks.is_empty() {
            stacks.push(Stack { name: main.words.clone(), colour: ONE_COLOUR, values: self.main() });
        }
        stacks
    }

    /// Returns gains and losses, each in its colour.
    fn change(&self) -> Vec<Stack> {
        let (scale, values) = (self.scale(), self.main());
        let stack = |name: &str, share: f32, of: fn(f64) -> f64| Stack {
            name: name.to_owned(),
            colour: scale.on_paper(share),
            values: values.iter().copied().map(of).collect(),
        };
        let [loss, gain] = scale.ends().unwrap_or_default();
        vec![stack(gain, BAR_SHARE, |value| value.max(0.0)), stack(loss, -BAR_SHARE, |value| value.min(0.0))]
    }

    fn carpet(&self, called: String) -> Carpet {
        let values = self.main();
        let stamps = || self.series.conditions.iter().map(|condition| condition.stamp);
        let mut days: Vec<(u32, u32)> = stamps().flatten().map(|stamp| (stamp.date.month, stamp.date.day)).collect();
        days.sort_unstable();
        days.dedup();
        let by_month = days.len() > MAX_DAYS;
        let (mut labels, mut sums) = (Vec::<String>::new(), Vec::<[(f64, u32); HOURS]>::new());
        for (stamp, value) in stamps().zip(values) {
            let Some(stamp) = stamp else { continue };
            let (date, minutes) = stamp.date.after(stamp.start_min);
            let name =
                if by_month { format!("{:02}", date.month) } else { format!("{:02}-{:02}", date.month, date.day) };
            let place = labels.iter().position(|label| *label == name).unwrap_or_else(|| {
                labels.push(name);
                sums.push([(0.0, 0); HOURS]);
                labels.len() - 1
            });
            // A row of several hours fills all of them, up to the end of its day.
            let first = (minutes / 60.0 + 1e-9) as usize;
            let hours = (stamp.hours.ceil().max(1.0) as usize).min(HOURS);
            for cell in sums.get_mut(place).into_iter().flatten().skip(first).take(hours) {
                *cell = (cell.0 + value, cell.1 + 1);
            }
        }
        let mean = |(sum, count): (f64, u32)| (count > 0).then(|| sum / f64::from(count));
        let columns = sums.into_iter().map(|hours| hours.map(mean)).collect();
        let by = if by_month { "month" } else { "day" };
        let layout = self.layout();
        let main = layout.main_quantity();
        let title = titled(&format!("{} by hour and {by}", layout.title()), layout.unit_of(main));
        Carpet { title, called, labels, columns, scale: self.scale() }
    }
}
