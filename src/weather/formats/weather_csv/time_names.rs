//! Names of columns that state times. In: the names of a head. Out: the place of a column, and if
//! any of them is of a time.

use crate::formats::weather_csv::names::squash;

/// Names of a column of whole stamps, squashed, the usual ones first.
pub(super) const TIME: &[&str] = &[
    "time",
    "timestamp",
    "datetime",
    "date",
    "valid_time",
    "observationtime",
    "observationperiod",
    "date/time",
    "dateandtime",
    "time_stamp",
    "messdatum",
    "unixtime",
    "unix",
    "epoch",
    "epochtime",
    "index",
    "datum",
    "zeitstempel",
    "day",
];

/// Names of a column of stamps at the start of intervals.
pub(super) const START: &[&str] =
    &["periodstart", "intervalstart", "starttime", "timestart", "start", "from", "begin", "hourbeginning", "startdate"];

/// Names of a column of stamps at the end of intervals.
pub(super) const END: &[&str] =
    &["periodend", "intervalend", "endtime", "timeend", "end", "to", "hourending", "enddate", "periodending"];

/// Names of a column of stamps in the middle of intervals.
pub(super) const MIDDLE: &[&str] =
    &["periodmid", "periodmiddle", "midtime", "timemid", "intervalmid", "periodcenter", "periodcentre"];

pub(super) const YEAR: &[&str] = &["year", "yyyy", "yr", "y"];

pub(super) const MONTH: &[&str] = &["month", "mo", "mm", "m"];

pub(super) const DAY: &[&str] = &["day", "dd", "dayofmonth", "dm", "dy", "d"];

pub(super) const HOUR: &[&str] = &["hour", "hr", "hh", "hourofday", "h"];

/// Returns the index of the first of the wanted names that exists.
pub fn place_of(names: &[String], wanted: &[&str]) -> Option<usize> {
    let plain: Vec<String> = names.iter().map(|name| bare(name)).collect();
    wanted.iter().find_map(|wanted| plain.iter().position(|name| *name == squash(wanted)))
}

/// Returns true if some column has a name of a time.
pub fn names_a_time(names: &[String]) -> bool {
    let has = |wanted: &[&str]| place_of(names, wanted).is_some();
    [TIME, START, END, MIDDLE].into_iter().any(has)
        || has(&["year"])
        || has(DAY) && has(HOUR) && (has(MONTH) || has(YEAR))
}

/// Returns a name without a zone and without text in brackets behind it.
pub(super) fn bare(name: &str) -> String {
    let squashed = squash(name);
    let plain = squashed.split(['(', '[']).next().unwrap_or_default();
    let ends = ["utc", "gmt", "lst", "local", "iso8601", "iso"];
    ends.iter().find_map(|end| plain.strip_suffix(end).filter(|start| !start.is_empty())).unwrap_or(plain).to_owned()
}
