//! Clocks of rules and results. In: an offset from UTC, or the name of a zone. Out: standard time,
//! and the lead of the legal clock over it on a day.

use std::fmt;
use std::str::FromStr;

use jiff::Timestamp;
use jiff::tz::TimeZone;
use serde::{Deserialize, Serialize};

use heliotile_core::weather::options::parse_zone;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::utc_offset::UtcOffset;

/// Clock of a place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum ClockZone {
    /// Fixed offset from UTC.
    Fixed(UtcOffset),
    /// Legal time of a zone of the tz database, such as `Europe/Amsterdam`.
    Named(TimeZone),
}

/// Seconds of a day.
const DAY_S: i64 = 86_400;

impl FromStr for ClockZone {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(hours) = parse_zone(text) {
            return Ok(ClockZone::Fixed(UtcOffset::of_hours(hours)));
        }
        TimeZone::get(text).map(ClockZone::Named).map_err(|_| {
            format!("`{text}` is not a time zone: give hours ahead of UTC, such as +01:00, or a name of the tz database, such as Europe/Amsterdam")
        })
    }
}

impl TryFrom<String> for ClockZone {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<ClockZone> for String {
    fn from(zone: ClockZone) -> String {
        zone.to_string()
    }
}

impl fmt::Display for ClockZone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ClockZone::Fixed(offset) => write!(f, "{offset}"),
            ClockZone::Named(zone) => write!(f, "{}", zone.iana_name().unwrap_or("UTC")),
        }
    }
}

impl ClockZone {
    /// Returns the zone of a longitude in whole hours, as ships keep them.
    pub fn of_longitude(longitude_deg: f64) -> Self {
        ClockZone::Fixed(UtcOffset::of_hours((longitude_deg / 15.0).round()))
    }

    /// Returns the standard time in a year: the earlier of the clocks of January and July.
    pub fn standard(&self, year: i32) -> UtcOffset {
        let at = |month| Date::new(year, month, 1).map(|date| self.minutes_on(date));
        let minutes = at(1).into_iter().chain(at(7)).min().unwrap_or_default();
        UtcOffset::of_hours(f64::from(minutes) / 60.0)
    }

    /// Returns the minutes that the legal clock is ahead of standard time at noon of a day.
    pub fn ahead_min(&self, date: Date) -> f64 {
        f64::from(self.minutes_on(date) - self.standard(date.year).minutes())
    }

    /// Returns the minutes ahead of UTC at noon of a day.
    fn minutes_on(&self, date: Date) -> i32 {
        match self {
            ClockZone::Fixed(offset) => offset.minutes(),
            ClockZone::Named(zone) => {
                // All dates of the years 1 to 2999 are valid timestamps.
                let noon = Timestamp::from_second(i64::from(date.day_number()) * DAY_S + DAY_S / 2).unwrap_or_default();
                zone.to_offset(noon).seconds() / 60
            }
        }
    }
}

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
        assert_eq!(ClockZone::of_longitude(4.3), ClockZone::Fixed(UtcOffset::default()));
        assert!("The Hague".parse::<ClockZone>().is_err_and(|text| text.contains("Europe/Amsterdam")));
    }
}
