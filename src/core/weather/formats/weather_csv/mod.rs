//! Reader of weather as a table with names of columns: CSV files, plain or of some service, and
//! JSON. In: a file's bytes. Out: its rows, not yet filled or checked against each other.
//!
//! [`names`] lists the names of columns that are read, [`units`] their units, and [`layout`] the
//! lines that services write above them. Cells are separated by commas, semicolons, tabs or blanks.
//! Light is missing if its cell is empty, a word for missing, at most -900 or at least 9999.

mod cells;
mod columns;
mod head;
mod json;
mod layout;
#[cfg(test)]
mod layout_tests;
#[cfg(test)]
mod made_layouts;
mod moments;
mod names;
mod source;
mod stamp_columns;
#[cfg(test)]
mod tests;
mod units;

use std::path::Path;

use csv::ByteRecord;

use crate::error::{Error, Result};
use crate::weather::air::Air;
use crate::weather::formats::date_text::{ColumnOrder, OrderFinder};
use crate::weather::formats::stamped::{StampedRows, SteppedRows};
use crate::weather::judging::raw_weather::{RawRow, RawWeather};
use crate::weather::options::{DateOrder, StampedAt, WeatherOptions};
use crate::weather::time::calendar::Date;

use cells::{Cells, cell};
use columns::{Columns, OutOfRange};
use head::{Head, Kind};
use moments::MomentReader;
use source::RowSource;
use stamp_columns::{StampColumns, StampPlace};

pub(super) use json::is_json;
pub(super) use units::is_watts;

pub(super) fn read(path: &Path, bytes: &[u8], options: &WeatherOptions) -> Result<RawWeather> {
    let head = Head::read(path, bytes)?;
    let source = RowSource::Text { bytes: head.rows_of(bytes), delimiter: head.delimiter, above: head.lines };
    read_table(path, head, &source, options)
}

pub(super) fn read_json(path: &Path, bytes: &[u8], options: &WeatherOptions) -> Result<RawWeather> {
    let table = json::table(path, bytes)?;
    read_table(path, table.head, &RowSource::Records(table.records), options)
}

fn read_table(path: &Path, mut head: Head, source: &RowSource, options: &WeatherOptions) -> Result<RawWeather> {
    let stamps = StampColumns::find(path, &head)?;
    let mut warnings = Vec::new();
    let columns = Columns::read(path, &head, options.with_air, &mut warnings)?;
    head.warnings.append(&mut warnings);
    let order = order_of(path, &head, &columns, &stamps, source, options)?;
    let moments = MomentReader { columns: &stamps, names: &columns, order };
    let mut rows = Rows::new(path, &head, &columns, moments, options);
    source.for_each(path, &mut |line, record| rows.add(line, record))?;
    rows.finish()
}

/// Finds the order of day and month in a column: as the user or the name of the column states, or
/// as all of its dates show.
fn order_of(
    path: &Path,
    head: &Head,
    columns: &Columns,
    stamps: &StampColumns,
    source: &RowSource,
    options: &WeatherOptions,
) -> Result<Option<DateOrder>> {
    let StampPlace::Text { date, .. } = stamps.place else { return Ok(None) };
    if let Some(order) = options.date_order.or(stamps.order) {
        return Ok(Some(order));
    }
    let mut finder = OrderFinder::new();
    finder.add(head.first(date));
    if finder.order() == ColumnOrder::Plain {
        return Ok(None);
    }
    let mut finder = OrderFinder::new();
    let mut first = None;
    source.for_each(path, &mut |line, record| {
        first.get_or_insert_with(|| (line, record.clone()));
        finder.add(&cell(record, date));
        Ok(true)
    })?;
    match (finder.order(), first) {
        (ColumnOrder::Is(order), _) => Ok(Some(order)),
        (ColumnOrder::Unknown, Some((line, record))) => {
            let cells = Cells { path, line, record: &record, style: head.style };
            Err(MomentReader { columns: stamps, names: columns, order: None }.two_orders(&cells))
        }
        _ => Ok(None),
    }
}

/// Rows read so far.
struct Rows<'a> {
    path: &'a Path,
    head: &'a Head,
    columns: &'a Columns,
    moments: MomentReader<'a>,
    options: &'a WeatherOptions,
    /// Zone of the clock by which days and labels go, once it is known from a stamp.
    zone_hours: Option<f64>,
    /// True if stamps state their zone; known from the first row on.
    stamps_say: Option<bool>,
    moved_s: i64,
    /// True if an hour 24 occurs.
    ends_day: bool,
    /// True if rows name their start and their end.
    are_starts: bool,
    /// Number of rows without a year.
    no_year: usize,
    /// Length of an interval in the first row that states it, minutes, and its line.
    stated_min: Option<(f64, usize)>,
    odd: OutOfRange,
    rows: Vec<RawRow>,
    seconds: Vec<i64>,
    air: Vec<Air>,
}

impl<'a> Rows<'a> {
    fn new(
        path: &'a Path,
        head: &'a Head,
        columns: &'a Columns,
        moments: MomentReader<'a>,
        options: &'a WeatherOptions,
    ) -> Self {
        Rows {
            path,
            head,
            columns,
            moments,
            options,
            zone_hours: options.zone_hours,
            stamps_say: None,
            moved_s: 0,
            ends_day: false,
            are_starts: false,
            no_year: 0,
            stated_min: None,
            odd: OutOfRange::default(),
            rows: Vec::new(),
            seconds: Vec::new(),
            air: Vec::new(),
        }
    }

    /// Adds a row; returns false if the rows have ended.
    fn add(&mut self, line: usize, record: &ByteRecord) -> Result<bool> {
        let first = cell(record, 0);
        let kind = self.head.kind;
        // A legend stands below the rows of PVGIS, and a table of days below the hours of
        // Open-Meteo.
        let ends = kind == Kind::Pvgis && !first.starts_with(|c: char| c.is_ascii_digit())
            || kind == Kind::OpenMeteo && first.eq_ignore_ascii_case("time");
        if ends {
            return Ok(false);
        }
        if first.starts_with('#') {
            return Ok(true);
        }
        let count = self.columns.count;
        let extra = record.iter().skip(count).any(|cell| !cell.is_empty());
        if record.len() < count || extra {
            let what = format!("the row has {} columns instead of {count}", record.len());
            return Err(Error::input(self.path, line, what, "the file may be cut off; fetch it again"));
        }
        let cells = Cells { path: self.path, line, record, style: self.head.style };
        let seconds = self.stamp(&cells)?;
        self.seconds.push(seconds);
        self.rows.push(self.columns.row(&cells, &mut self.odd)?);
        if self.options.with_air {
            self.air.push(self.columns.air(&cells, &mut self.odd));
        }
        Ok(true)
    }

    /// Returns the seconds of the clock by which days and labels go.
    fn stamp(&mut self, cells: &Cells) -> Result<i64> {
        let moment = self.moments.read(cells)?;
        let (seconds, said) = (moment.seconds, moment.zone_hours);
        if *self.stamps_say.get_or_insert(said.is_some()) != said.is_some() {
            let what = "some time stamps have an offset from UTC, others have none";
            return Err(Error::input(self.path, cells.line, what, "write an offset in every stamp or in none"));
        }
        self.ends_day |= moment.ends_day;
        self.are_starts |= moment.is_start;
        self.no_year += usize::from(moment.no_year);
        if let Some(minutes) = moment.minutes {
            let (stated, _) = *self.stated_min.get_or_insert((minutes, cells.line));
            if (stated - minutes).abs() > 0.02 {
                let what = format!("the interval is stated as {minutes} min, in the rows before as {stated} min");
                return Err(Error::input(self.path, cells.line, what, "give rows at one step"));
            }
        }
        let Some(said) = said else { return Ok(seconds) };
        let zone = *self.zone_hours.get_or_insert(said);
        let moved_s = ((zone - said) * 3600.0).round() as i64;
        if self.seconds.is_empty() {
            self.moved_s = moved_s;
        }
        Ok(seconds + moved_s)
    }

    /// Returns the place of a stamp in its interval: first as the user says, then as the names of
    /// the columns and the rows show, then as is usual for the layout.
    fn stamped_at(&self) -> Result<StampedAt> {
        if let Some(at) = self.options.stamped_at {
            return Ok(at);
        }
        let by_names = self.are_starts.then_some(StampedAt::Start).or(self.moments.columns.at);
        if let Some(at) = by_names.or(self.ends_day.then_some(StampedAt::End)) {
            return Ok(at);
        }
        let has_minutes = !matches!(self.moments.columns.place, StampPlace::Parts { minute: None, clock: None, .. });
        self.head.usual_stamp(self.path, has_minutes, self.columns.instants)
    }

    fn finish(self) -> Result<RawWeather> {
        if self.rows.is_empty() {
            let hint = "write a line of names and below it a line for each interval";
            return Err(Error::input(self.path, None, "the file has no weather rows", hint));
        }
        let stamped_at = self.stamped_at()?;
        let Rows { path, head, columns, options, rows, seconds, mut air, moved_s, odd, .. } = self;
        let mut station = head.station.clone();
        if self.stamps_say == Some(true) {
            (station.zone_hours, station.zone_is_certain) = (self.zone_hours, true);
        }
        // PVGIS' time offset is that of values at one moment. It does not apply if the user says
        // that they are means.
        let late_min = if options.stamped_at.is_none() { head.late_min } else { 0.0 };
        // First and last stamp by the file's own clock.
        let first_s = seconds.first().copied().unwrap_or_default() - moved_s;
        let last_s = seconds.last().copied().unwrap_or_default() - moved_s;
        let stamped = StampedRows { rows, seconds, stamped_at, day_of_start: true, late_min, moved_s };
        let SteppedRows { mut rows, step_min, warning } = stamped.stepped(path)?;
        if let Some((stated, line)) = self.stated_min
            && (stated - step_min).abs() > 0.02
        {
            let what = format!("the interval is stated as {stated} min, but rows are {step_min} min apart");
            return Err(Error::input(path, line, what, "give rows whose intervals follow each other"));
        }
        if columns.has_energies() {
            for row in &mut rows {
                columns.to_watts(path, row, 60.0 * step_min)?;
            }
            air.iter_mut().for_each(|air| columns.air_to_watts(air, 60.0 * step_min));
        }
        let mut warnings: Vec<String> = warning.into_iter().collect();
        warnings.extend(head.warnings.iter().cloned());
        warnings.extend(columns.odd_numbers(path, &odd));
        if self.no_year > 0 {
            warnings.push(format!(
                "{}: {} rows state no year and are read as rows of {}; {{year}} puts results into another year",
                path.display(),
                self.no_year,
                Date::NO_YEAR
            ));
        }
        let is_default = options.stamped_at.is_none() && head.kind == Kind::Plain && stamped_at == StampedAt::Start;
        let named = self.are_starts || self.moments.columns.at.is_some();
        if is_default && !named && !columns.has_all_light() && runs_to_midnight(first_s, last_s, step_min) {
            warnings.push(format!(
                "{}: stamps run from the end of the first interval of a day to midnight, as ends of intervals do, \
                 but are read as starts; {{weather_stamp}} end reads them as ends, {{weather_stamp}} start confirms \
                 that they are starts",
                path.display()
            ));
        }
        Ok(RawWeather { station, rows, air, step_min, stamped_at, warnings })
    }
}

/// Returns true if whole days are stamped from one step after midnight to midnight.
fn runs_to_midnight(first_s: i64, last_s: i64, step_min: f64) -> bool {
    let step_s = (60.0 * step_min).round() as i64;
    first_s.rem_euclid(86_400) == step_s && last_s.rem_euclid(86_400) == 0 && last_s - first_s >= 86_400 - step_s
}
