//! Reader of weather as CSV with names of columns: plain files, NSRDB and PVGIS. In: a file's bytes. Out: its rows as they stand there.
//!
//! Which names of columns are read stands in [`columns`], what NSRDB and PVGIS write above them in [`head`]. Cells are
//! separated by commas, semicolons or tabs. Light that is empty, a word for missing, at most -900 or at least 9999 is missing.

mod cells;
mod columns;
mod head;
#[cfg(test)]
mod tests;

use std::path::Path;

use csv::{ByteRecord, ReaderBuilder, Trim};

use crate::error::{Error, Result};
use crate::weather::air::Air;
use crate::weather::formats::stamp_text::{STAMPS, clock_seconds, digits, parse_stamp};
use crate::weather::formats::stamped::{StampedRows, SteppedRows};
use crate::weather::judging::raw_weather::{RawRow, RawWeather};
use crate::weather::options::{StampedAt, WeatherOptions};
use crate::weather::time::calendar::Date;

use cells::{Cells, cell};
use columns::{Columns, StampColumns};
use head::{Head, Kind};

pub(super) fn read(path: &Path, bytes: &[u8], options: &WeatherOptions) -> Result<RawWeather> {
    let head = Head::read(path, bytes)?;
    let mut rows = Rows::new(path, &head, options)?;
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .delimiter(head.delimiter)
        .from_reader(head.rows_of(bytes));
    let mut record = ByteRecord::new();
    loop {
        let more = reader.read_byte_record(&mut record).map_err(|error| {
            let line = error.position().map(|at| at.line() as usize + head.lines);
            Error::input(path, line, error.to_string(), "save the file as CSV")
        })?;
        let line = record.position().map_or(0, |at| at.line() as usize) + head.lines;
        if !more || !rows.add(line, &record)? {
            break;
        }
    }
    rows.finish(head)
}

/// Minutes of a day, whose last one is the next midnight.
const DAY_MIN: u32 = 1440;

/// Rows read so far.
struct Rows<'a> {
    path: &'a Path,
    kind: Kind,
    columns: Columns,
    options: &'a WeatherOptions,
    /// The zone of the clock that days and labels go by, once it is known from a stamp.
    zone_hours: Option<f64>,
    /// Whether stamps say their zone; known from the first row on.
    stamps_say: Option<bool>,
    moved_s: i64,
    rows: Vec<RawRow>,
    seconds: Vec<i64>,
    air: Vec<Air>,
}

impl<'a> Rows<'a> {
    fn new(path: &'a Path, head: &Head, options: &'a WeatherOptions) -> Result<Self> {
        let columns = Columns::read(path, head)?;
        Ok(Rows {
            path,
            kind: head.kind,
            columns,
            options,
            zone_hours: options.zone_hours,
            stamps_say: None,
            moved_s: 0,
            rows: Vec::new(),
            seconds: Vec::new(),
            air: Vec::new(),
        })
    }

    /// Takes a row; false if the rows have ended.
    fn add(&mut self, line: usize, record: &ByteRecord) -> Result<bool> {
        let first = cell(record, 0);
        // A legend stands below the rows of PVGIS.
        if self.kind == Kind::Pvgis && !first.starts_with(|c: char| c.is_ascii_digit()) {
            return Ok(false);
        }
        if first.starts_with('#') {
            return Ok(true);
        }
        if record.len() != self.columns.count {
            let what = format!("the row has {} columns instead of {}", record.len(), self.columns.count);
            return Err(Error::input(self.path, line, what, "the file may be cut off; fetch it again"));
        }
        let cells = Cells { path: self.path, line, record };
        let seconds = self.stamp(&cells)?;
        self.seconds.push(seconds);
        self.rows.push(self.columns.row(&cells)?);
        if self.options.with_air {
            self.air.push(self.columns.air(&cells));
        }
        Ok(true)
    }

    /// Seconds of the clock that days and labels go by.
    fn stamp(&mut self, cells: &Cells) -> Result<i64> {
        let (seconds, said) = match &self.columns.stamp {
            StampColumns::Text { place, utc } => {
                let text = cells.text(*place);
                let bad = || cells.bad(*place, self.columns.name(*place), STAMPS);
                let stamp = parse_stamp(&text).ok_or_else(bad)?;
                (stamp.seconds, stamp.zone_hours.or(utc.then_some(0.0)))
            }
            StampColumns::Parts { year, month, day, hour, minute } => {
                let part = |place: usize| {
                    digits(&cells.text(place))
                        .ok_or_else(|| cells.bad(place, self.columns.name(place), "write a whole number"))
                };
                let date = Date::new(part(*year)? as i32, part(*month)?, part(*day)?);
                let hour = hour.map_or(Ok(0), part)?;
                let minute = minute.map_or(Ok(0), part)?;
                // Some files write the 60th minute of an hour; digits are four at most.
                let minutes = hour * 60 + minute;
                let (Some(date), 0..=60, 0..=DAY_MIN) = (date, minute, minutes) else {
                    let what = "year, month, day, hour and minute are no time that exists";
                    return Err(Error::input(self.path, cells.line, what, "correct the row"));
                };
                (clock_seconds(date, i64::from(minutes * 60)), None)
            }
        };
        if *self.stamps_say.get_or_insert(said.is_some()) != said.is_some() {
            let what = "some time stamps have an offset from UTC, others have none";
            return Err(Error::input(self.path, cells.line, what, "write an offset in every stamp or in none"));
        }
        let Some(said) = said else { return Ok(seconds) };
        let zone = *self.zone_hours.get_or_insert(said);
        let moved_s = ((zone - said) * 3600.0).round() as i64;
        if self.seconds.is_empty() {
            self.moved_s = moved_s;
        }
        Ok(seconds + moved_s)
    }

    fn finish(self, head: Head) -> Result<RawWeather> {
        let Rows { path, options, rows, seconds, air, moved_s, .. } = self;
        if rows.is_empty() {
            let hint = "it needs a line of names and a line for each interval below it";
            return Err(Error::input(path, None, "the file has no weather rows", hint));
        }
        let mut station = head.station;
        if self.stamps_say == Some(true) {
            (station.zone_hours, station.zone_is_certain) = (self.zone_hours, true);
        }
        let usual = match head.kind {
            Kind::Plain => StampedAt::Start,
            Kind::Nsrdb | Kind::Pvgis => StampedAt::Middle,
        };
        let stamped_at = options.stamped_at.unwrap_or(usual);
        // What PVGIS says of its values at one moment is of no use if they are said to be means.
        let late_min = if options.stamped_at.is_none() { head.late_min } else { 0.0 };
        let stamped = StampedRows { rows, seconds, stamped_at, day_of_start: true, late_min, moved_s };
        let SteppedRows { rows, step_min, warning } = stamped.stepped(path)?;
        Ok(RawWeather { station, rows, air, step_min, stamped_at, warnings: warning.into_iter().collect() })
    }
}
