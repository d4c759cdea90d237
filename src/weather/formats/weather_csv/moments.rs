//! The moments of rows. In: cells, and the columns that hold the time. Out: seconds of the clock by
//! which days go, the zone of stamps and the length of an interval, if stated.

use crate::formats::stamp_text::{
    ClockText, STAMPS, StampText, clock_seconds, digits, parse_clock, parse_minutes, parse_stamp,
};
use crate::formats::weather_csv::cells::{Cells, SHOWN};
use crate::formats::weather_csv::columns::Columns;
use crate::formats::weather_csv::stamp_columns::{StampColumns, StampPlace};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::excerpt;
use heliotile_core::weather::options::DateOrder;
use heliotile_core::weather::time::calendar::Date;

/// Minutes of a day; the last one is the next midnight.
const DAY_MIN: u32 = 1440;

/// Moment of a row, read from its cells.
pub struct Moment {
    /// Seconds after 1970-01-01 00:00 of the clock of the stamp.
    pub seconds: i64,
    pub zone_hours: Option<f64>,
    /// True if its hour is the 24th: labels of a file with one are ends.
    pub ends_day: bool,
    /// True if it lies in the first hour of a day, 0.
    pub starts_day: bool,
    /// Length of the interval, minutes, if the row states it.
    pub minutes: Option<f64>,
    /// True if the row names start and end, and `seconds` is the start.
    pub is_start: bool,
    /// True if it names no year, and one was put in.
    pub no_year: bool,
}

/// Reader of the cells of time.
pub struct MomentReader<'a> {
    pub columns: &'a StampColumns,
    pub names: &'a Columns,
    pub order: Option<DateOrder>,
}

impl MomentReader<'_> {
    pub fn read(&self, cells: &Cells) -> Result<Moment> {
        let mut moment = match self.columns.place {
            StampPlace::Text { date, clock } => self.of_text(cells, date, clock)?,
            StampPlace::Parts { year, month, day, hour, minute, clock } => {
                self.of_parts(cells, [year, month, Some(day), hour, minute, clock])?
            }
        };
        if let Some(place) = self.columns.end {
            let end = self.stamp(cells, place, &cells.text(place))?;
            moment.minutes = Some(self.length(cells, place, moment.seconds, &end)?);
            moment.is_start = true;
        } else if let Some(place) = self.columns.period {
            // A bare number may be the number of a row.
            let text = cells.text(place);
            let says_unit = text.chars().any(|c| c.is_alphabetic() || c == ':')
                || self.names.name(place).to_lowercase().contains("min");
            moment.minutes = parse_minutes(&text).filter(|_| says_unit);
        }
        Ok(moment)
    }

    fn stamp(&self, cells: &Cells, place: usize, text: &str) -> Result<StampText> {
        parse_stamp(text, self.order).ok_or_else(|| cells.bad(place, self.names.name(place), STAMPS))
    }

    /// Returns the minutes from a start to an end.
    fn length(&self, cells: &Cells, place: usize, start: i64, end: &StampText) -> Result<f64> {
        let minutes = (end.seconds - start) as f64 / 60.0;
        if minutes > 0.0 {
            return Ok(minutes);
        }
        Err(cells.bad(place, self.names.name(place), "write an end of the interval that is later than its start"))
    }

    fn of_text(&self, cells: &Cells, date: usize, clock: Option<usize>) -> Result<Moment> {
        let text = cells.text(date);
        // `2021-06-01T00:00/2021-06-01T01:00` of the CAMS radiation service, and
        // `2021-06-01T00:00/PT1H`.
        let pair = text.split_once('/').filter(|(start, end)| start.len() > 9 && !end.is_empty());
        let start = self.stamp(cells, date, pair.map_or(&text, |(start, _)| start))?;
        let mut moment = Moment {
            seconds: start.seconds,
            zone_hours: start.zone_hours.or(self.columns.zone_hours),
            ends_day: start.ends_day,
            starts_day: start.seconds.rem_euclid(86_400) < 3600,
            minutes: None,
            is_start: false,
            no_year: false,
        };
        if let Some((_, end)) = pair {
            let minutes = match parse_minutes(end) {
                Some(minutes) => minutes,
                None => self.length(cells, date, start.seconds, &self.stamp(cells, date, end)?)?,
            };
            (moment.minutes, moment.is_start) = (Some(minutes), true);
        }
        if let Some(place) = clock {
            let clock = self.clock(cells, place)?;
            moment.seconds += clock.seconds;
            moment.ends_day = clock.ends_day;
            moment.starts_day = clock.seconds < 3600;
        }
        Ok(moment)
    }

    fn clock(&self, cells: &Cells, place: usize) -> Result<ClockText> {
        let hint = "write a time of day from 00:00 to 24:00";
        parse_clock(&cells.text(place)).ok_or_else(|| cells.bad(place, self.names.name(place), hint))
    }

    /// Reads a moment from the columns of year, month, day, hour, minute and of a time of day.
    fn of_parts(&self, cells: &Cells, places: [Option<usize>; 6]) -> Result<Moment> {
        let [year, month, day, hour, minute, clock] = places;
        let part = |place: usize| {
            let text = cells.text(place);
            let whole = text.strip_suffix(".0").unwrap_or(&text);
            digits(whole).ok_or_else(|| cells.bad(place, self.names.name(place), "write a whole number"))
        };
        let whole = |place: Option<usize>| place.map(part).transpose();
        let (year, month, day) = (whole(year)?, whole(month)?, whole(day)?.unwrap_or_default());
        let date = match (year.filter(|year| *year > 0), month) {
            (Some(year), Some(month)) => i32::try_from(year).ok().and_then(|year| Date::new(year, month, day)),
            (None, Some(month)) => Date::of_no_year(month, day),
            (year, None) => {
                let first =
                    Date::new(year.map_or(Some(Date::NO_YEAR), |year| i32::try_from(year).ok()).unwrap_or(0), 1, 1);
                let number = first.map(|first| first.day_number() + i32::try_from(day).unwrap_or(0) - 1);
                number.filter(|_| (1..=366).contains(&day)).and_then(Date::of_day_number)
            }
        };
        let mut ends_day = false;
        let seconds = match clock {
            Some(place) => {
                let clock = self.clock(cells, place)?;
                ends_day = clock.ends_day;
                Some(clock.seconds)
            }
            None => {
                let hour = whole(hour)?.unwrap_or_default();
                let minute = whole(minute)?.unwrap_or_default();
                ends_day |= hour == 24;
                // Some files write the 60th minute of an hour. Parts have at most four digits, so
                // the sum cannot overflow.
                let minutes = hour * 60 + minute;
                (minute <= 60 && minutes <= DAY_MIN).then_some(i64::from(minutes * 60))
            }
        };
        let (Some(date), Some(seconds)) = (date, seconds) else {
            let what = "year, month, day, hour and minute do not form an existing time";
            return Err(Error::input(cells.path, cells.line, what, "correct the row"));
        };
        Ok(Moment {
            seconds: clock_seconds(date, seconds),
            zone_hours: self.columns.zone_hours,
            ends_day,
            starts_day: seconds < 3600,
            minutes: None,
            is_start: false,
            no_year: year.is_none_or(|year| year == 0),
        })
    }

    /// Returns the error of a column whose dates can be read in two ways.
    pub fn two_orders(&self, cells: &Cells) -> Error {
        let StampPlace::Text { date, .. } = self.columns.place else {
            return Error::input(cells.path, cells.line, "the date can be read in two ways", STAMPS);
        };
        let what = format!(
            "column `{}` holds `{}`, and no row shows which number is the day and which is the month",
            excerpt(self.names.name(date), SHOWN),
            excerpt(&cells.text(date), SHOWN)
        );
        let hint = "state their order with {date_order} dmy or mdy, or write 2021-06-01";
        Error::input(cells.path, cells.line, what, hint)
            .because(Problem::value(self.names.name(date), cells.text(date)))
    }
}
