//! Clocks of weather, rules and results. In: an offset from UTC, or the name of a zone. Out:
//! standard time, and the lead of the legal clock over it.

use std::collections::HashMap;
use std::fmt;
use std::str::FromStr;
use std::sync::{LazyLock, Mutex, PoisonError};

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::{AmbiguousOffset, Offset, TimeZone};

use crate::weather::time::calendar::Date;
use crate::weather::time::utc_offset::{UtcOffset, parse_zone};

/// Clock of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClockZone {
    /// Fixed number of hours ahead of UTC.
    Hours(f64),
    /// Legal time of a zone of the tz database, such as `Europe/Amsterdam`.
    Named(&'static TimeZone),
}

/// Seconds of a day.
const DAY_S: i64 = 86_400;

/// Zones in use, by name. Each is kept for the life of the program; the database has some 600.
static ZONES: LazyLock<Mutex<HashMap<String, &'static TimeZone>>> = LazyLock::new(Mutex::default);

/// Offsets of a local time from UTC, seconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LocalOffset {
    /// The clock shows this time once.
    Once(i64),
    /// The clock shows this time twice, when summer time ends.
    Twice(i64, i64),
    /// The clock never shows this time, because summer time begins.
    Never,
}

impl FromStr for ClockZone {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(hours) = parse_zone(text) {
            return Ok(ClockZone::Hours(hours));
        }
        let found = TimeZone::get(text).map_err(|_| {
            format!("`{text}` is not a time zone: give hours ahead of UTC, such as +01:00, or a name of the tz database, such as Europe/Amsterdam")
        })?;
        let name = found.iana_name().unwrap_or(text).to_owned();
        let mut zones = ZONES.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(ClockZone::Named(zones.entry(name).or_insert_with(|| Box::leak(Box::new(found)))))
    }
}

impl fmt::Display for ClockZone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ClockZone::Hours(hours) => write!(f, "{}", UtcOffset::of_hours(*hours)),
            ClockZone::Named(zone) => write!(f, "{}", zone.iana_name().unwrap_or("UTC")),
        }
    }
}

impl ClockZone {
    /// Returns the zone of a longitude in whole hours, as ships keep them.
    pub fn of_longitude(longitude_deg: f64) -> Self {
        ClockZone::Hours((longitude_deg / 15.0).round())
    }

    /// Returns the value of an option: a number of hours with all of its digits, or a name.
    pub fn option(&self) -> String {
        match self {
            ClockZone::Hours(hours) => hours.to_string(),
            ClockZone::Named(_) => self.to_string(),
        }
    }

    /// Returns the standard time in a year: the earlier of the clocks of January and July.
    pub fn standard(&self, year: i32) -> UtcOffset {
        UtcOffset::of_hours(self.standard_hours(year))
    }

    /// Returns the hours that standard time is ahead of UTC in a year.
    pub fn standard_hours(&self, year: i32) -> f64 {
        match self {
            ClockZone::Hours(hours) => *hours,
            ClockZone::Named(_) => {
                let at = |month| Date::new(year, month, 1).map(|date| self.minutes_on(date));
                let minutes = at(1).into_iter().chain(at(7)).min().unwrap_or_default();
                f64::from(minutes) / 60.0
            }
        }
    }

    /// Returns the minutes that the legal clock is ahead of standard time at noon of a day.
    pub fn ahead_min(&self, date: Date) -> f64 {
        f64::from(self.minutes_on(date) - self.standard(date.year).minutes())
    }

    /// Returns the minutes ahead of UTC at noon of a day.
    fn minutes_on(&self, date: Date) -> i32 {
        (self.offset_s(i64::from(date.day_number()) * DAY_S + DAY_S / 2) / 60) as i32
    }

    /// Returns the seconds ahead of UTC at a moment, in seconds after 1970-01-01 00:00 UTC.
    pub fn offset_s(&self, utc_s: i64) -> i64 {
        match self {
            ClockZone::Hours(hours) => i64::from(UtcOffset::of_hours(*hours).minutes()) * 60,
            ClockZone::Named(zone) => {
                // All dates of the years 1 to 2999 are valid timestamps.
                i64::from(zone.to_offset(Timestamp::from_second(utc_s).unwrap_or_default()).seconds())
            }
        }
    }

    /// Returns the seconds ahead of UTC when the clock shows a local time, in seconds after its
    /// 1970-01-01 00:00.
    pub fn offset_at_local(&self, local_s: i64) -> LocalOffset {
        let ClockZone::Named(zone) = self else { return LocalOffset::Once(self.offset_s(0)) };
        let shown: DateTime = Offset::UTC.to_datetime(Timestamp::from_second(local_s).unwrap_or_default());
        let seconds = |offset: Offset| i64::from(offset.seconds());
        match zone.to_ambiguous_timestamp(shown).offset() {
            AmbiguousOffset::Unambiguous { offset } => LocalOffset::Once(seconds(offset)),
            AmbiguousOffset::Fold { before, after } => LocalOffset::Twice(seconds(before), seconds(after)),
            AmbiguousOffset::Gap { .. } => LocalOffset::Never,
        }
    }
}

heliotile_requests::parse_by_text!(ClockZone: heliotile_requests::Form::TEXT);

crate::serde_by_text!(ClockZone);

#[cfg(test)]
mod tests {
    use super::*;

    /// Amsterdam has +01:00 and is an hour ahead of it in June; Sydney has +10:00 and is ahead in
    /// December; Dublin, whose winter is the exception by law, has +00:00; 5.5 hours east the clock
    /// never changes. A town is no zone.
    #[test]
    fn legal_time_is_an_hour_ahead_in_summer() {
        for (text, standard, june, december) in [
            ("Europe/Amsterdam", "+01:00", 60.0, 0.0),
            ("Australia/Sydney", "+10:00", 0.0, 60.0),
            ("Europe/Dublin", "+00:00", 60.0, 0.0),
            ("+05:30", "+05:30", 0.0, 0.0),
            ("Asia/Kolkata", "+05:30", 0.0, 0.0),
        ] {
            let zone: ClockZone = text.parse().expect("a zone");
            let day = |month| Date::new(2026, month, 21).expect("a date");
            let found = (zone.standard(2026).to_string(), zone.ahead_min(day(6)), zone.ahead_min(day(12)));
            assert_eq!(found, (standard.to_owned(), june, december), "{text}");
            assert_eq!(zone.to_string(), text);
        }
        assert_eq!(ClockZone::of_longitude(4.3), ClockZone::Hours(0.0));
        assert!("The Hague".parse::<ClockZone>().is_err_and(|text| text.contains("Europe/Amsterdam")));
    }

    /// Amsterdam's clock shows 02:30 twice on 31 October 2021, 7200 and 3600 s ahead of UTC, never
    /// on 28 March, and once on 1 June.
    #[test]
    fn a_clock_with_summer_time_shows_an_hour_twice_or_never() {
        let zone: ClockZone = "Europe/Amsterdam".parse().expect("a zone");
        let at = |month, day| {
            let date = Date::new(2021, month, day).expect("a date");
            zone.offset_at_local(i64::from(date.day_number()) * DAY_S + 9000)
        };
        assert_eq!(at(10, 31), LocalOffset::Twice(7200, 3600));
        assert_eq!(at(3, 28), LocalOffset::Never);
        assert_eq!(at(6, 1), LocalOffset::Once(7200));
    }
}
