//! Pictures of results: `--plot`. In: names of files, a series, means over its receivers. Out: which picture each file is, and charts; maps are
//! drawn where maps are ([`super::mapped`]).

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::cli::RecombineArgs;
use crate::commands::guard_output;
use crate::outputs::area_means::AreaMeans;
use crate::outputs::periods::Every;
use crate::outputs::pictures::bars::{Bars, Stack};
use crate::outputs::pictures::carpet::{Carpet, HOURS};
use crate::outputs::pictures::colours::{COMPONENTS, label};
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::layout::Layout;
use crate::recombine::Series;
use heliotile_core::error::{Error, Result};
use heliotile_core::weather::dated::DatedRows;
use heliotile_core::weather::time::calendar::Date;

/// Longer series have a column of hours for each month, shorter ones for each day.
const MOST_DAYS: usize = 62;
/// More bars are thinner than a point.
const MOST_BARS: usize = 800;
/// Of a total that has no parts.
const ONE_COLOUR: [u8; 3] = [0x5b, 0x67, 0x72];

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plot {
    Map,
    /// Periods by component.
    Bars,
    /// Hours of the day by month.
    Hours,
}

impl Plot {
    /// By the ending of a name, and by what rows stand for; none in a query.
    fn of(path: &Path, every: Option<Every>) -> Result<Self> {
        let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        match (ending.as_deref(), every) {
            (Some("png"), _) => Ok(Plot::Map),
            (Some("svg"), Some(Every::Hour)) => Ok(Plot::Hours),
            (Some("svg"), Some(Every::Total)) => Err(Error::argument(
                "--plot",
                format!("`{}` is a chart through time, and --every total has one sum", path.display()),
                "give --every month (bars) or hour (hours of the day by month), or a name that ends with .png for a map",
            )),
            (Some("svg"), _) => Ok(Plot::Bars),
            _ => Err(Error::Unsupported {
                what: "ending of a picture".into(),
                found: format!("`{}`", path.display()),
                supported: ".png for a map, .svg for a chart".into(),
            }),
        }
    }

    /// Those of a command line; an error where one cannot be drawn of a series.
    pub fn all<'p>(paths: &'p [PathBuf], series: &Series) -> Result<Vec<(&'p Path, Plot)>> {
        let count = series.labels.len();
        let plot = |path: &'p PathBuf| {
            let plot = Plot::of(path, series.every)?;
            match plot {
                Plot::Map if count != 1 && series.every != Some(Every::Month) => {
                    let hint = match series.every {
                        None => "give --conditions with one line, or a name that ends with .svg for bars",
                        Some(_) => "give --every month or total, or a name that ends with .svg for a chart",
                    };
                    let what = format!("`{}` is a map, which shows one value a place, not {count}", path.display());
                    Err(Error::argument("--plot", what, hint))
                }
                Plot::Bars if count > MOST_BARS => {
                    let what = "bars of a chart (take fewer with --from and --to, or a longer --every)";
                    Err(Error::Limit { what: what.into(), value: count as u64, max: MOST_BARS as u64 })
                }
                _ => Ok((path.as_path(), plot)),
            }
        };
        paths.iter().map(plot).collect()
    }
}

/// Refuses pictures of unknown endings, and such that would replace an input or one another.
pub fn guard(args: &RecombineArgs, forcing: &[&Path], every: Option<Every>) -> Result<()> {
    let archive = args.table.archive.as_path();
    for (i, path) in args.plot.iter().enumerate() {
        Plot::of(path, every)?;
        let inputs: Vec<&Path> = [archive].into_iter().chain(forcing.iter().copied()).collect();
        guard_output(path, &[&inputs[..], args.table.of.receivers.as_deref().as_slice()].concat())?;
        // A table has other endings.
        if args.plot.iter().take(i).any(|other| other == path) {
            let what = format!("`{}` is written twice", path.display());
            return Err(Error::argument("--plot", what, "give each output a name of its own"));
        }
    }
    Ok(())
}

/// What a replay is of, in words: a weather file, and the days that are taken of it.
pub fn called(weather: &Path, dated: &DatedRows) -> String {
    let mut days = dated.dates.iter().zip(&dated.chosen).filter_map(|(date, chosen)| chosen.then_some(date));
    let day = |date: &Date| match dated.years.matter() {
        true => format!("{:04}-{:02}-{:02}", date.year, date.month, date.day),
        false => format!("{:02}-{:02}", date.month, date.day),
    };
    let name = name_of(weather);
    let (first, last) = (days.next(), days.next_back());
    match (first.map(day), last.or(first).map(day)) {
        (Some(first), Some(last)) if first != last => format!("{name}, {first} to {last}"),
        (Some(only), _) => format!("{name}, {only}"),
        _ => name,
    }
}

/// Name of a file, in words.
pub fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Writes a chart; a map is none.
pub fn write_chart(
    (path, plot): (&Path, Plot),
    means: &AreaMeans,
    series: &Series,
    layout: &Layout,
    (called, about): (&str, &Provenance),
) -> Result<()> {
    let called = format!("{called}; {}", means.called());
    let svg = match plot {
        Plot::Map => return Ok(()),
        Plot::Bars => bars(means, series, layout, called).svg()?,
        Plot::Hours => carpet(means, series, layout, called).svg()?,
    };
    let mut sink = Sink::file(path)?;
    sink.write_all(about.in_svg(&svg).as_bytes()).map_err(Error::io(path, "write to"))?;
    sink.finish().map(drop)
}

fn bars(means: &AreaMeans, series: &Series, layout: &Layout, called: String) -> Bars {
    let parts = COMPONENTS.iter().filter(|(one, ..)| layout.components().contains(one));
    let mut stacks: Vec<Stack> = parts
        .map(|(one, colour, name)| {
            let values = means.mean(*one).unwrap_or_default();
            Stack { name: (*name).into(), colour: *colour, values }
        })
        .collect();
    if stacks.is_empty() {
        let main = layout.main();
        let values = means.mean(main).unwrap_or_default();
        stacks.push(Stack { name: label(main), colour: ONE_COLOUR, values });
    }
    let title = match series.every {
        Some(Every::Day) => "Sun and sky by day",
        Some(Every::Month) => "Sun and sky by month",
        Some(_) => "Sun and sky by year",
        None => "Sun and sky by condition",
    };
    Bars { title: title.into(), called, unit: layout.unit().into(), labels: series.labels.text.clone(), stacks }
}

fn carpet(means: &AreaMeans, series: &Series, layout: &Layout, called: String) -> Carpet {
    let main = layout.main();
    let values = means.mean(main).unwrap_or_default();
    let stamps = || series.conditions.iter().map(|condition| condition.stamp);
    let mut days: Vec<(u32, u32)> = stamps().flatten().map(|stamp| (stamp.date.month, stamp.date.day)).collect();
    days.sort_unstable();
    days.dedup();
    let by_month = days.len() > MOST_DAYS;
    let (mut labels, mut sums) = (Vec::<String>::new(), Vec::<[(f64, u32); HOURS]>::new());
    for (stamp, value) in stamps().zip(values) {
        let Some(stamp) = stamp else { continue };
        let (date, minutes) = stamp.date.after(stamp.start_min);
        let name = if by_month { format!("{:02}", date.month) } else { format!("{:02}-{:02}", date.month, date.day) };
        let place = labels.iter().position(|label| *label == name).unwrap_or_else(|| {
            labels.push(name);
            sums.push([(0.0, 0); HOURS]);
            labels.len() - 1
        });
        // Rows of several hours fill them all, as far as their day goes.
        let first = (minutes / 60.0 + 1e-9) as usize;
        let hours = (stamp.hours.ceil().max(1.0) as usize).min(HOURS);
        for cell in sums.get_mut(place).into_iter().flatten().skip(first).take(hours) {
            *cell = (cell.0 + value, cell.1 + 1);
        }
    }
    let mean = |(sum, count): (f64, u32)| (count > 0).then(|| sum / f64::from(count));
    let columns = sums.into_iter().map(|hours| hours.map(mean)).collect();
    let by = if by_month { "month" } else { "day" };
    Carpet { title: format!("{} by hour and {by}, W/m2", label(main)), called, labels, columns }
}
