//! Reader of weather as a table with names of columns: CSV files, plain or of some service, and
//! JSON. In: a file's bytes. Out: its rows, not yet filled or checked against each other.
//!
//! [`names`] lists the names of columns that are read, [`units`] their units, and [`layout`] the
//! lines that services write above them. Cells are separated by commas, semicolons, tabs or blanks.
//! Light is missing if its cell is empty, a word for missing, at most -900 or at least 9999.

#[cfg(test)]
mod case_tests;
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
mod time_names;
mod units;

use std::path::Path;

use csv::ByteRecord;

use crate::formats::date_text::{ColumnOrder, OrderFinder};
use crate::formats::stamped::{LegalDays, StampedRows, SteppedRows};
use crate::judging::raw_weather::{RawRow, RawWeather};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::{Message, excerpt, message};
use heliotile_core::weather::air::Air;
use heliotile_core::weather::options::{DateOrder, StampedAt, WeatherOptions};
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::clock_zone::{ClockZone, LocalOffset};

use cells::{Cells, SHOWN, cell};
use columns::{Columns, OutOfRange};
use head::{Head, Kind};
use moments::MomentReader;
use source::RowSource;
use stamp_columns::{StampColumns, StampPlace, is_time_name};

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
    warnings.extend(
        columns
            .check_unread(path, &head, |place| stamps.holds(place) || is_time_name(&head.names[place]))?
            .into_iter()
            .map(Message::from),
    );
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
    /// Rows with light, and those among them whose direct horizontal irradiance exceeds GHI.
    beam_above_ghi: [usize; 2],
    zenith_deg: Vec<Option<f64>>,
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
            zone_hours: None,
            stamps_say: None,
            moved_s: 0,
            ends_day: false,
            are_starts: false,
            no_year: 0,
            stated_min: None,
            beam_above_ghi: [0; 2],
            zenith_deg: Vec::new(),
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
        if first.starts_with('#') || is_sum(record) {
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
        self.zenith_deg.push(self.columns.zenith_deg(&cells));
        if let Some((beam, ghi)) = self.columns.beam_and_ghi(&cells)
            && beam > MIN_LIGHT
        {
            self.beam_above_ghi[0] += 1;
            self.beam_above_ghi[1] += usize::from(beam > MAX_BEAM_SHARE * ghi);
        }
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
        let year = Date::of_day_number((seconds / 86_400) as i32).map_or(Date::NO_YEAR, |date| date.year);
        let asked = self.options.zone.map(|zone| zone.standard_hours(year));
        let Some(said) = said else {
            self.zone_hours = self.zone_hours.or(asked);
            return self.by_standard_time(cells, seconds);
        };
        let zone = *self.zone_hours.get_or_insert(asked.unwrap_or(said));
        let moved_s = ((zone - said) * 3600.0).round() as i64;
        if self.seconds.is_empty() {
            self.moved_s = moved_s;
        }
        Ok(seconds + moved_s)
    }

    /// Returns the seconds by standard time of a stamp without an offset. Files of services keep
    /// standard time; any other file keeps the legal time of a zone that the user names.
    fn by_standard_time(&mut self, cells: &Cells, seconds: i64) -> Result<i64> {
        let (Some(zone @ ClockZone::Named(_)), Kind::Plain, Some(hours)) =
            (self.options.zone, self.head.kind, self.zone_hours)
        else {
            return Ok(seconds);
        };
        let standard_s = (hours * 3600.0).round() as i64;
        let by = |offset_s: i64| seconds - offset_s + standard_s;
        let found = match zone.offset_at_local(seconds) {
            LocalOffset::Once(offset_s) => by(offset_s),
            // The first of the two hours is followed by the second.
            LocalOffset::Twice(first_s, then_s) => {
                let first = by(first_s);
                if self.seconds.last().is_some_and(|last| *last >= first) { by(then_s) } else { first }
            }
            LocalOffset::Never => {
                let what = format!("the clock of {zone} never shows this time, because summer time begins");
                let hint =
                    "if the file keeps standard time in summer, too, state its zone in hours: {time_zone} +01:00";
                return Err(Error::input(self.path, cells.line, what, hint));
            }
        };
        if self.seconds.is_empty() {
            self.moved_s = found - seconds;
        }
        Ok(found)
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

    /// Puts rows in order of time that stand newest first, as Solcast gives them.
    fn put_in_order(&mut self) {
        if self.seconds.len() > 1 && self.seconds.windows(2).all(|pair| pair[0] > pair[1]) {
            self.seconds.reverse();
            self.rows.reverse();
            self.air.reverse();
            self.zenith_deg.reverse();
        }
    }

    fn finish(mut self) -> Result<RawWeather> {
        self.put_in_order();
        if self.rows.is_empty() {
            let hint = "write a line of names and below it a line for each interval";
            return Err(Error::input(self.path, None, "the file has no weather rows", hint));
        }
        self.check_beam()?;
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
        let named = self.are_starts || self.moments.columns.at.is_some();
        let is_default = options.stamped_at.is_none() && head.kind == Kind::Plain && stamped_at == StampedAt::Start;
        let is_default = is_default && !named;
        let legal = match (options.zone, self.zone_hours) {
            (Some(zone @ ClockZone::Named(_)), Some(hours))
                if self.stamps_say == Some(true) || head.kind == Kind::Plain =>
            {
                Some(LegalDays { zone, standard_hours: hours })
            }
            _ => None,
        };
        let mut stamped = StampedRows { rows, seconds, stamped_at, day_of_start: true, late_min, moved_s, legal };
        let mut by_clock = None;
        if is_default && let Some((at, add_s)) = stamped.place_by_clock(path, self.zone_hours == Some(0.0))? {
            stamped.stamped_at = at;
            stamped.seconds.iter_mut().for_each(|stamp| *stamp += add_s);
            by_clock = Some(message!(
                "{}: time stamps stand {}: they are read as the {} of their intervals; {{weather_stamp}} states another \
                 place",
                path.display(),
                match add_s {
                    0 => "at half a step".to_owned(),
                    _ => format!("{add_s} s before a step ends"),
                },
                at.name()
            ));
        }
        let stamped_at = stamped.stamped_at;
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
        let mut warnings: Vec<Message> = warning.into_iter().map(Message::from).collect();
        warnings.extend(head.warnings.iter().cloned());
        warnings.extend(columns.odd_numbers(path, &odd).into_iter().map(Message::from));
        if self.no_year > 0 {
            warnings.push(message!(
                "{}: {} rows state no year and are read as rows of {}; {{year}} puts results into another year",
                path.display(),
                self.no_year,
                Date::NO_YEAR
            ));
        }
        warnings.extend(by_clock);
        let is_default = is_default && !columns.has_all_light() && stamped_at == StampedAt::Start;
        let zenith_deg = if is_default && columns.has_zenith() { self.zenith_deg } else { Vec::new() };
        if is_default && zenith_deg.is_empty() && runs_to_midnight(first_s, last_s, step_min) {
            warnings.push(message!(
                "{}: stamps run from the end of the first interval of a day to midnight, as ends of intervals do, \
                 but are read as starts; {{weather_stamp}} end reads them as ends, {{weather_stamp}} start confirms \
                 that they are starts",
                path.display()
            ));
        }
        Ok(RawWeather { station, rows, air, step_min, stamped_at, zenith_deg, warnings })
    }

    /// Refuses a column of direct horizontal irradiance that exceeds GHI, as direct normal
    /// irradiance does.
    fn check_beam(&self) -> Result<()> {
        let [lit, above] = self.beam_above_ghi;
        if above < FEWEST_ABOVE || above as f64 <= MIN_SHARE_ABOVE * lit as f64 {
            return Ok(());
        }
        let name = self.columns.beam_name().unwrap_or_default();
        let what = format!(
            "column `{}` has the name of direct horizontal irradiance, and exceeds GHI in {above} of {lit} rows, as only \
             direct normal irradiance can",
            excerpt(name, SHOWN)
        );
        Err(Error::input(self.path, self.head.line_of_names(), what, "name it dni if it is direct normal irradiance"))
    }
}

/// Words in the first cell of a row of sums below the rows of light.
const SUMS: [&str; 8] = ["total", "totals", "sum", "average", "averages", "mean", "minimum", "maximum"];

/// Returns true for a row of sums or means.
fn is_sum(record: &ByteRecord) -> bool {
    let first = record.iter().find(|cell| !cell.is_empty()).unwrap_or_default();
    let word = String::from_utf8_lossy(first);
    let word = word.trim_matches([':', ' ', '"']);
    SUMS.iter().any(|sum| word.eq_ignore_ascii_case(sum))
}

/// Least direct irradiance that is compared with GHI, W/m2.
const MIN_LIGHT: f64 = 50.0;
/// Largest ratio of direct horizontal irradiance to GHI, with room for errors of instruments.
const MAX_BEAM_SHARE: f64 = 1.05;
/// Least number of rows, and share of those with direct light, that prove another quantity.
const FEWEST_ABOVE: usize = 3;
const MIN_SHARE_ABOVE: f64 = 0.1;

/// Returns true if whole days are stamped from one step after midnight to midnight.
fn runs_to_midnight(first_s: i64, last_s: i64, step_min: f64) -> bool {
    let step_s = (60.0 * step_min).round() as i64;
    first_s.rem_euclid(86_400) == step_s && last_s.rem_euclid(86_400) == 0 && last_s - first_s >= 86_400 - step_s
}
