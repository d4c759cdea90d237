//! Columns of the time. In: names of columns and the first row. Out: their indices, and the place
//! of a stamp in its interval by their names.

use std::path::Path;

use crate::formats::stamp_text::{parse_clock, parse_stamp};
use crate::formats::weather_csv::head::{Head, Kind};
use crate::formats::weather_csv::names::squash;
use crate::formats::weather_csv::time_names::{DAY, END, HOUR, MIDDLE, MONTH, START, TIME, YEAR, bare, place_of};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::excerpt;
use heliotile_core::weather::options::{DateOrder, StampedAt};
use heliotile_core::weather::time::utc_offset::parse_zone;

/// Names of a column of times of day, beside a column of dates.
const CLOCK: &[&str] = &[
    "time",
    "hour",
    "hr",
    "clock",
    "timeofday",
    "hh:mm",
    "localtime",
    "hhmm",
    "hourofday",
    "uhrzeit",
    "zeit",
    "mst",
    "pst",
    "est",
    "cst",
    "hst",
    "akst",
    "gmt",
    "utc",
];

/// Standard times of North America that NREL's MIDC names its column of times of day by, with their
/// hours ahead of UTC.
const STANDARD_TIMES: [(&str, f64); 6] =
    [("mst", -7.0), ("pst", -8.0), ("est", -5.0), ("cst", -6.0), ("hst", -10.0), ("akst", -9.0)];

const MINUTE: &[&str] = &["minute", "min", "mi", "minutes"];

/// Names of a column with the length of an interval.
const PERIOD: &[&str] =
    &["period", "interval", "periodminutes", "intervalminutes", "duration", "periodmin", "intervalmin"];

/// Place of a time stamp in a row.
pub enum StampPlace {
    /// A whole stamp in one cell, or a date with its time of day in another.
    Text { date: usize, clock: Option<usize> },
    /// Year, month, day, hour and minute in their own cells. Without a year any year is meant;
    /// without a month `day` is the day of the year.
    Parts {
        year: Option<usize>,
        month: Option<usize>,
        day: usize,
        hour: Option<usize>,
        minute: Option<usize>,
        clock: Option<usize>,
    },
}

/// Columns of a row's time, with the facts that their names state.
pub struct StampColumns {
    pub place: StampPlace,
    /// Hours ahead of UTC, by the name of the column.
    pub zone_hours: Option<f64>,
    /// Place of the stamp in its interval, by the name of the column.
    pub at: Option<StampedAt>,
    /// Column of the end stamp, if the first stamp is that of the start.
    pub end: Option<usize>,
    pub period: Option<usize>,
    /// Order of day and month, by a name such as `Date (MM/DD/YYYY)`.
    pub order: Option<DateOrder>,
}

/// A column of whole stamps.
#[derive(Clone, Copy)]
struct Found {
    place: usize,
    at: Option<StampedAt>,
}

/// Returns true if a name is that of a column of time.
pub fn is_time_name(name: &str) -> bool {
    let plain = bare(name);
    let lists =
        [TIME, START, END, MIDDLE, CLOCK, YEAR, MONTH, DAY, HOUR, MINUTE, PERIOD, &["second", "doy", "dayofyear"]];
    lists.iter().any(|names| names.iter().any(|name| squash(name) == plain))
}

impl StampColumns {
    /// Returns true if a column belongs to the time of rows.
    pub fn holds(&self, place: usize) -> bool {
        let (text, parts) = match self.place {
            StampPlace::Text { date, clock } => ([Some(date), clock], [None; 6]),
            StampPlace::Parts { year, month, day, hour, minute, clock } => {
                ([None; 2], [year, month, Some(day), hour, minute, clock])
            }
        };
        text.into_iter().chain(parts).chain([self.end, self.period]).any(|of_time| of_time == Some(place))
    }

    /// Finds the time: a column with a name for it, else the first one if it holds time stamps,
    /// else year, month, day, hour and minute.
    pub fn find(path: &Path, head: &Head) -> Result<Self> {
        let names = head.names.as_slice();
        let place = |wanted: &[&str]| place_of(names, wanted);
        let period = place(PERIOD).filter(|place| !squash(names.get(*place).map_or("", String::as_str)).contains('/'));
        let of_name = |place: usize| names.get(place).map(String::as_str).unwrap_or_default();
        let with = |found: Found, clock: Option<usize>, end: Option<usize>| {
            let name = of_name(found.place);
            let zone_hours = zone_of(name).or_else(|| clock.and_then(|clock| zone_of(of_name(clock))));
            let zone_hours = zone_hours.or_else(|| zone_of_layout(head));
            StampColumns {
                place: StampPlace::Text { date: found.place, clock },
                zone_hours,
                at: found.at,
                end,
                period,
                order: order_of(name),
            }
        };
        let (start, end) = (place(START), place(END));
        if let Some(start) = start
            && looks_dated(head, start)
        {
            return Ok(with(Found { place: start, at: Some(StampedAt::Start) }, None, end));
        }
        if let Some(end) = end
            && looks_dated(head, end)
        {
            return Ok(with(Found { place: end, at: Some(StampedAt::End) }, None, None));
        }
        if let Some(middle) = place(MIDDLE) {
            return Ok(with(Found { place: middle, at: Some(StampedAt::Middle) }, None, None));
        }
        let (month, hour, minute) = (place(MONTH), place(HOUR), place(MINUTE));
        let parts = |day: usize, year: Option<usize>, month: Option<usize>| {
            let clock = hour.is_none().then(|| place(CLOCK)).flatten();
            let place = StampPlace::Parts { year, month, day, hour, minute, clock };
            let zone_hours = [hour, clock].into_iter().flatten().find_map(|place| zone_of(of_name(place)));
            let zone_hours = zone_hours.or_else(|| zone_of_layout(head));
            StampColumns { place, zone_hours, at: None, end: None, period, order: None }
        };
        let whole: Vec<usize> = TIME.iter().filter_map(|name| place(&[name])).collect();
        let dated = whole.iter().copied().find(|place| is_whole(head, *place));
        if let Some(place) = dated {
            return Ok(with(Found { place, at: None }, None, None));
        }
        // A date, and a time of day beside it.
        let date = whole.iter().copied().find(|place| looks_dated(head, *place));
        let clocks = |names: &[&str]| {
            let places = names.iter().filter_map(|name| place(&[name]));
            places.into_iter().find(|place| Some(*place) != date && parse_clock(head.first(*place)).is_some())
        };
        let clock = clocks(CLOCK);
        for (clock, at) in [
            (clock, None),
            (clocks(&["hourending", "he"]), Some(StampedAt::End)),
            (clocks(&["hourbeginning", "hb"]), Some(StampedAt::Start)),
        ] {
            if let (Some(date), Some(_)) = (date, clock) {
                return Ok(with(Found { place: date, at }, clock, None));
            }
        }
        if parse_stamp(head.first(0), Some(DateOrder::Dmy)).is_some_and(|stamp| stamp.has_time) {
            return Ok(with(Found { place: 0, at: None }, None, None));
        }
        let (year, day) = (place(YEAR), place(DAY));
        if let (Some(month), Some(day)) = (month, day)
            && (year.is_some() || hour.is_some() || place(CLOCK).is_some())
        {
            return Ok(parts(day, year, Some(month)));
        }
        // The day of the year, with its time.
        let day_of_year = place(&["day_of_year", "doy", "dy"]).or(day);
        if let Some(day) = day_of_year
            && (hour.is_some() || clock.is_some())
            && head.first(day).parse::<u32>().is_ok()
        {
            return Ok(parts(day, year, None));
        }
        if let Some(place) = date.or(whole.first().copied()) {
            return Ok(with(Found { place, at: None }, None, None));
        }
        let what = format!("no column of time among `{}`", excerpt(&names.join(","), 120));
        let hint = "name one `time`, such as 2021-06-01T12:30+01:00, or give year, month, day, hour and minute";
        Err(Error::input(path, head.line_of_names(), what, hint))
    }
}

/// Returns true if a cell of the first row starts with a date of any order, or is the whole stamp
/// of an interval.
fn looks_dated(head: &Head, place: usize) -> bool {
    let text = head.first(place);
    let text = text.split_once('/').filter(|(start, _)| start.len() > 9).map_or(text, |(start, _)| start);
    [DateOrder::Dmy, DateOrder::Mdy].into_iter().any(|order| parse_stamp(text, Some(order)).is_some())
}

/// Returns true if a cell of the first row is a date with a time of day, or the whole stamp of an
/// interval.
fn is_whole(head: &Head, place: usize) -> bool {
    let text = head.first(place);
    let text = text.split_once('/').filter(|(start, _)| start.len() > 10).map_or(text, |(start, _)| start);
    let stamp = |order| parse_stamp(text, Some(order)).is_some_and(|stamp| stamp.has_time);
    [DateOrder::Dmy, DateOrder::Mdy].into_iter().any(stamp)
}

/// Returns the zone that all stamps of a layout are in, as if each of them stated it.
fn zone_of_layout(head: &Head) -> Option<f64> {
    match head.kind {
        Kind::Pvgis => Some(0.0),
        // The user may give another zone for NSRDB.
        Kind::Nsrdb => None,
        _ => head.station.zone_hours.filter(|_| head.station.zone_is_certain),
    }
}

/// Returns the zone that a name states: `time(UTC)`, `timestamp_utc`, `Time (UTC+1)`.
fn zone_of(name: &str) -> Option<f64> {
    let lower = name.trim().to_lowercase();
    if let Some((_, hours)) = STANDARD_TIMES.iter().find(|(known, _)| *known == lower) {
        return Some(*hours);
    }
    let at = lower.find("utc").or_else(|| lower.find("gmt"))?;
    let zone: String =
        lower.get(at..)?.chars().take_while(|c| c.is_alphanumeric() || matches!(c, '+' | '-' | ':')).collect();
    parse_zone(&zone).or(Some(0.0).filter(|_| !zone.contains(['+', '-'])))
}

/// Returns the order of a date that a name states: `Date (MM/DD/YYYY)`.
fn order_of(name: &str) -> Option<DateOrder> {
    let letters: String = name.to_lowercase().chars().filter(char::is_ascii_alphabetic).collect();
    let is = |order: &str| letters.contains(order);
    match () {
        () if is("mmddyy") => Some(DateOrder::Mdy),
        () if is("ddmmyy") => Some(DateOrder::Dmy),
        () if is("yymmdd") => Some(DateOrder::Ymd),
        () => None,
    }
}
