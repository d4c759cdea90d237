//! Time stamps as text. In: a cell. Out: a moment of the clock, and what that clock shows when it is noon UTC.

use crate::weather::options::parse_zone;
use crate::weather::time::calendar::Date;

/// How time stamps can be written.
pub const STAMPS: &str = "write 2021-06-01T12:30, with an offset such as +01:00 behind it if it is known";

/// A time stamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StampText {
    /// Seconds of the clock after its 1970-01-01 00:00.
    pub seconds: i64,
    /// Hours that the clock is ahead of UTC, where the stamp says so.
    pub zone_hours: Option<f64>,
}

/// Seconds of a clock after its 1970-01-01 00:00.
pub fn clock_seconds(date: Date, seconds: i64) -> i64 {
    i64::from(date.day_number()) * 86_400 + seconds
}

/// ISO 8601 (`2021-06-01T12:30:00+01:00`, a blank for the `T`, a slash for the hyphen, without seconds or without time), and
/// `20210601:1230` of PVGIS.
pub fn parse_stamp(text: &str) -> Option<StampText> {
    let (date, rest) = match text.as_bytes() {
        [_, _, _, _, b'-' | b'/', ..] => (date_of(text.get(..10)?, 5, 8)?, text.get(10..)?),
        _ => (date_of(text.get(..8)?, 4, 6)?, text.get(8..)?),
    };
    if rest.is_empty() {
        return Some(StampText { seconds: clock_seconds(date, 0), zone_hours: None });
    }
    let rest = rest.strip_prefix(['T', 't', ' ', ':'])?;
    let end = rest.find(|c: char| !matches!(c, '0'..='9' | ':' | '.')).unwrap_or(rest.len());
    let (clock, zone) = rest.split_at_checked(end)?;
    let zone_hours = match zone.trim() {
        "" => None,
        zone => Some(parse_zone(zone)?),
    };
    Some(StampText { seconds: clock_seconds(date, time_of(clock)?), zone_hours })
}

fn date_of(text: &str, month: usize, day: usize) -> Option<Date> {
    let parts = [text.get(..4)?, text.get(month..month + 2)?, text.get(day..day + 2)?];
    let [year, month, day] = parts.map(digits);
    Date::new(i32::try_from(year?).ok()?, month?, day?)
}

/// `12:30`, `12:30:15`, `12:30:15.000`, `1230`; 24:00 is the next midnight. Fractions of seconds are dropped.
fn time_of(text: &str) -> Option<i64> {
    let (hours, minutes, seconds) = match text.split_once(':') {
        Some((hours, rest)) => match rest.split_once(':') {
            Some((minutes, seconds)) => (hours, minutes, seconds.split('.').next()?),
            None => (hours, rest, "0"),
        },
        None if text.len() == 4 => (text.get(..2)?, text.get(2..)?, "0"),
        None => return None,
    };
    let [hours, minutes, seconds] = [digits(hours)?, digits(minutes)?, digits(seconds)?];
    let whole = i64::from(hours * 3600 + minutes * 60 + seconds);
    (hours <= 24 && minutes < 60 && seconds < 60 && whole <= 86_400).then_some(whole)
}

/// One to four digits and nothing else.
pub fn digits(text: &str) -> Option<u32> {
    let right = (1..=4).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_digit());
    text.parse().ok().filter(|_| right)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve ways to write 12:30 of 1 June 2021, 1,622,550,600 seconds after 1970, give it, six of them with a zone; midnight is 24:00
    /// of the day before.
    #[test]
    fn twelve_ways() {
        let noon = 1_622_550_600;
        for (text, zone) in [
            ("2021-06-01T12:30", None),
            ("2021-06-01 12:30", None),
            ("2021-06-01 12:30:00", None),
            ("2021-06-01T12:30:00.000", None),
            ("2021/06/01 12:30", None),
            ("20210601:1230", None),
            ("20210601T1230Z", Some(0.0)),
            ("2021-06-01T12:30Z", Some(0.0)),
            ("2021-06-01 12:30:00+00:00", Some(0.0)),
            ("2021-06-01T12:30:00-03:30", Some(-3.5)),
            ("2021-06-01T12:30+0545", Some(5.75)),
            ("2021-06-01 12:30 UTC", Some(0.0)),
        ] {
            assert_eq!(parse_stamp(text), Some(StampText { seconds: noon, zone_hours: zone }), "{text}");
        }
        assert_eq!(parse_stamp("2021-05-31T24:00"), parse_stamp("2021-06-01"));
    }

    /// Dates and times that do not exist, and orders that could mean two days, are none: 16 of 16.
    #[test]
    fn refusals() {
        for text in [
            "",
            "x",
            "0",
            "17",
            "2021",
            "2021-13-01T00:00",
            "2021-02-29T00:00",
            "01/06/2021 12:30",
            "2021-06-01T25:00",
            "2021-06-01T24:01",
            "2021-06-01T12:60",
            "2021-06-01T12",
            "2021-06-01T12:30+25:00",
            "2021-06-01T12:30 CET",
            "2021-06-01T-1:30",
            "2021-06-01T12:30:00:00",
        ] {
            assert_eq!(parse_stamp(text), None, "{text}");
        }
        // Characters of several bytes are no panic.
        assert_eq!(parse_stamp("2021-0\u{e9}-01T12:30"), None);
    }
}
