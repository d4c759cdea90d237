//! Time stamps as text. In: a cell. Out: a moment of the clock, and the offset of that clock from
//! UTC.

use crate::formats::date_text::parse_date;
use heliotile_core::weather::options::DateOrder;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::utc_offset::parse_zone;

/// Advice on how to write time stamps.
pub const STAMPS: &str = "write 2021-06-01T12:30, with an offset such as +01:00 behind it if it is known";

/// A time stamp, read from text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StampText {
    /// Seconds of the clock after its 1970-01-01 00:00.
    pub seconds: i64,
    /// Hours that the clock is ahead of UTC, if the stamp states them.
    pub zone_hours: Option<f64>,
    /// True if it is the 24:00 that ends a day.
    pub ends_day: bool,
    /// True if it has a time of day.
    pub has_time: bool,
}

/// A time of day, read from text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClockText {
    /// Seconds after midnight.
    pub seconds: i64,
    /// True if its hour is 24.
    pub ends_day: bool,
}

/// Returns the seconds of a clock after its 1970-01-01 00:00.
pub fn clock_seconds(date: Date, seconds: i64) -> i64 {
    i64::from(date.day_number()) * 86_400 + seconds
}

/// Reads a date and a time: ISO 8601 (`2021-06-01T12:30:00+01:00`, a blank for the `T`, without
/// seconds or without time), `20210601:1230` of PVGIS, `2021060112` and `202106011230`, dates with
/// a slash, a dot or the name of a month, and seconds, thousandths, millionths or billionths of
/// seconds after 1970. Where either of two numbers could be the day, `order` decides.
pub fn parse_stamp(text: &str, order: Option<DateOrder>) -> Option<StampText> {
    let text = text.trim();
    let whole = text.strip_suffix(".0").unwrap_or(text);
    if whole.len() >= 9 && whole.bytes().all(|byte| byte.is_ascii_digit()) {
        return of_digits(whole);
    }
    let (date, rest) = parse_date(text, order)?;
    let plain = StampText { seconds: clock_seconds(date, 0), zone_hours: None, ends_day: false, has_time: false };
    let rest = rest.trim_end();
    if rest.is_empty() {
        return Some(plain);
    }
    // `2021060112:10` of the German weather service has no separator before the hour.
    let rest = rest.strip_prefix(['T', 't', ' ', ':', '_', ',']).unwrap_or(rest).trim_start();
    let end = rest.find(|c: char| !matches!(c, '0'..='9' | ':' | '.')).unwrap_or(rest.len());
    let (clock, behind) = rest.split_at_checked(end)?;
    let (half_day, zone) = half_day(behind.trim());
    let zone_hours = match zone {
        "" => None,
        zone => Some(parse_zone(zone)?),
    };
    let clock = on_24_hours(time_of(clock)?, half_day)?;
    Some(StampText {
        seconds: clock_seconds(date, clock.seconds),
        zone_hours,
        ends_day: clock.ends_day,
        has_time: true,
    })
}

/// Reads a time of day in its own cell: `12:30`, `12:30:00`, `1230`, `12`, `12.5` hours, `1:30 PM`.
pub fn parse_clock(text: &str) -> Option<ClockText> {
    let text = text.trim();
    let end = text.find(|c: char| !matches!(c, '0'..='9' | ':' | '.')).unwrap_or(text.len());
    let (clock, behind) = text.split_at_checked(end)?;
    let (half_day, rest) = half_day(behind.trim());
    if !rest.is_empty() {
        return None;
    }
    if clock.contains(':') || clock.len() == 4 && !clock.contains('.') {
        return on_24_hours(time_of(clock)?, half_day);
    }
    let hours: f64 = clock.parse().ok().filter(|hours| (0.0..=24.0).contains(hours))?;
    on_24_hours(ClockText { seconds: (hours * 3600.0).round() as i64, ends_day: hours == 24.0 }, half_day)
}

/// Reads nine digits and more: a date with hour, minute and second behind it, or a number of
/// seconds.
fn of_digits(text: &str) -> Option<StampText> {
    let dated = || {
        let (date, clock) = text.split_at_checked(8)?;
        let (date, _) = parse_date(date, None).filter(|(date, _)| (1900..2100).contains(&date.year))?;
        let clock = match clock.len() {
            2 => time_of(&format!("{clock}00"))?,
            4 => time_of(clock)?,
            6 => time_of(clock)?,
            _ => return None,
        };
        Some(StampText {
            seconds: clock_seconds(date, clock.seconds),
            zone_hours: None,
            ends_day: clock.ends_day,
            has_time: true,
        })
    };
    let counted = || {
        let per_second = match text.len() {
            // Seconds from 1973 to 2286 have nine or ten digits; milli-, micro- and nanoseconds
            // have three, six and nine more.
            9 | 10 => 1,
            12 | 13 => 1_000,
            15 | 16 => 1_000_000,
            18 | 19 => 1_000_000_000,
            _ => return None,
        };
        let seconds = text.parse::<i64>().ok()?.div_euclid(per_second);
        Some(StampText { seconds, zone_hours: Some(0.0), ends_day: false, has_time: true })
    };
    // Digits that make a date from 1900 to 2099 are more likely one than a count of seconds.
    dated().or_else(counted)
}

/// Splits `AM` or `PM` off the text behind a clock's digits; true is `PM`.
fn half_day(text: &str) -> (Option<bool>, &str) {
    let (word, rest) = text.split_at_checked(2).unwrap_or((text, ""));
    match word.to_ascii_lowercase().as_str() {
        "am" => (Some(false), rest.trim_start()),
        "pm" => (Some(true), rest.trim_start()),
        _ => (None, text),
    }
}

/// Converts a time of a 12-hour clock, which runs from 12 over 1 to 11 twice a day.
fn on_24_hours(clock: ClockText, afternoon: Option<bool>) -> Option<ClockText> {
    const HALF_S: i64 = 43_200;
    let Some(afternoon) = afternoon else { return Some(clock) };
    let in_half = (3600..HALF_S + 3600).contains(&clock.seconds).then_some(clock.seconds % HALF_S)?;
    Some(ClockText { seconds: in_half + if afternoon { HALF_S } else { 0 }, ends_day: false })
}

/// Reads `12:30`, `12:30:15`, `12:30:15.000`, `1230`, `123015`; 24:00 is the next midnight.
/// Fractions of seconds are dropped.
fn time_of(text: &str) -> Option<ClockText> {
    let (hours, minutes, seconds) = match text.split_once(':') {
        Some((hours, rest)) => match rest.split_once(':') {
            Some((minutes, seconds)) => (hours, minutes, seconds.split('.').next()?),
            None => (hours, rest, "0"),
        },
        None if text.len() == 4 => (text.get(..2)?, text.get(2..)?, "0"),
        None if text.len() == 6 => (text.get(..2)?, text.get(2..4)?, text.get(4..)?),
        None => return None,
    };
    let [hours, minutes, seconds] = [digits(hours)?, digits(minutes)?, digits(seconds)?];
    let whole = i64::from(hours * 3600 + minutes * 60 + seconds);
    let exists = hours <= 24 && minutes < 60 && seconds < 60 && whole <= 86_400;
    exists.then_some(ClockText { seconds: whole, ends_day: hours == 24 })
}

/// Reads one to four digits and nothing else.
pub fn digits(text: &str) -> Option<u32> {
    let right = (1..=4).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_digit());
    text.parse().ok().filter(|_| right)
}

/// Reads a length of time in minutes: `PT30M`, `PT1H`, `30`, `30 min`, `1 h`, `0:30`, `0 days
/// 01:00:00` of pandas.
pub fn parse_minutes(text: &str) -> Option<f64> {
    let lower = text.trim().to_ascii_lowercase();
    if let Some(iso) = lower.strip_prefix('p') {
        let time = iso.split_once('t').map(|(_, time)| time)?;
        let (mut minutes, mut number) = (0.0, String::new());
        for c in time.chars() {
            let of_unit = match c {
                'h' => 60.0,
                'm' => 1.0,
                's' => 1.0 / 60.0,
                _ => {
                    number.push(c);
                    continue;
                }
            };
            minutes += number.parse::<f64>().ok().filter(|number| number.is_finite())? * of_unit;
            number.clear();
        }
        return (number.is_empty() && minutes > 0.0).then_some(minutes);
    }
    let lower = lower.strip_prefix("0 days ").unwrap_or(&lower);
    if let Some((hours, minutes)) = lower.split_once(':') {
        return Some(f64::from(digits(hours)? * 60 + digits(minutes.get(..2)?)?)).filter(|minutes| *minutes > 0.0);
    }
    let end = lower.find(|c: char| !matches!(c, '0'..='9' | '.')).unwrap_or(lower.len());
    let (number, unit) = lower.split_at_checked(end)?;
    let of_unit = match unit.trim() {
        "" | "m" | "min" | "mins" | "minute" | "minutes" => 1.0,
        "h" | "hr" | "hour" | "hours" => 60.0,
        "s" | "sec" | "seconds" => 1.0 / 60.0,
        _ => return None,
    };
    number.parse::<f64>().ok().map(|number| number * of_unit).filter(|minutes| *minutes > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seconds of 1 June 2021, 12:30.
    const NOON: i64 = 1_622_550_600;

    /// Twenty-six ways to write 12:30 of 1 June 2021 give 1,622,550,600 seconds after 1970, eleven
    /// of them with a zone. Midnight is 24:00 of the day before.
    #[test]
    fn one_moment_reads_from_26_spellings() {
        for (text, zone) in [
            ("2021-06-01T12:30", None),
            ("2021-06-01 12:30", None),
            ("2021-06-01 12:30:00", None),
            ("2021-06-01T12:30:00.000", None),
            ("2021/06/01 12:30", None),
            ("2021/6/1 12:30", None),
            ("2021.06.01 12:30", None),
            ("20210601:1230", None),
            ("20210601 12:30", None),
            ("202106011230", None),
            ("20210601123000", None),
            ("2021060112:30", None),
            ("1-Jun-2021 12:30", None),
            ("01 June 2021 12:30 PM", None),
            ("Jun 1, 2021, 12:30:00 pm", None),
            ("20210601T1230Z", Some(0.0)),
            ("20210601T123000Z", Some(0.0)),
            ("2021-06-01T12:30Z", Some(0.0)),
            ("2021-06-01 12:30:00+00:00", Some(0.0)),
            ("2021-06-01T12:30:00-03:30", Some(-3.5)),
            ("2021-06-01T12:30+0545", Some(5.75)),
            ("2021-06-01 12:30 UTC", Some(0.0)),
            ("2021-06-01 12:30 UTC+1", Some(1.0)),
            ("1622550600", Some(0.0)),
            ("1622550600.0", Some(0.0)),
            ("1622550600000", Some(0.0)),
        ] {
            let stamp = parse_stamp(text, None).unwrap_or_else(|| panic!("{text}"));
            assert_eq!((stamp.seconds, stamp.zone_hours, stamp.has_time), (NOON, zone, true), "{text}");
        }
        let midnight = parse_stamp("2021-05-31T24:00", None).expect("midnight");
        assert_eq!((midnight.seconds, midnight.ends_day), (NOON - 45_000, true));
        assert_eq!(
            parse_stamp("2021-06-01", None).map(|day| (day.seconds, day.has_time)),
            Some((NOON - 45_000, false))
        );
        let ten = parse_stamp("2021060110", None).map(|stamp| stamp.seconds);
        assert_eq!(ten, Some(NOON - 9000));
    }

    /// A date of two numbers and a year is the day that the order decides. Without an order it is
    /// none, unless one number is above 12.
    #[test]
    fn a_stated_order_decides_the_day() {
        let of = |text, order| parse_stamp(text, order).map(|stamp| stamp.seconds);
        assert_eq!(of("01/06/2021 12:30", Some(DateOrder::Dmy)), Some(NOON));
        assert_eq!(of("06/01/2021 12:30", Some(DateOrder::Mdy)), Some(NOON));
        assert_eq!(of("1.6.21 12:30", Some(DateOrder::Dmy)), Some(NOON));
        assert_eq!(of("21/06/01 12:30", Some(DateOrder::Ymd)), Some(NOON));
        assert_eq!(of("01/06/2021 12:30", None), None);
        assert_eq!(of("13/06/2021 12:30", None), Some(NOON + 12 * 86_400));
        assert_eq!(of("13/06/2021 12:30", Some(DateOrder::Mdy)), None);
    }

    /// Dates and times that do not exist, and dates that could mean two days, are refused: 20 of
    /// 20.
    #[test]
    fn dates_that_do_not_exist_are_refused() {
        for text in [
            "",
            "x",
            "0",
            "17",
            "2021",
            "44348.5",
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
            "2021-06-01 13:00 PM",
            "1 Brumaire 2021 12:30",
            "99999999999",
        ] {
            assert_eq!(parse_stamp(text, None), None, "{text}");
        }
        // Characters of several bytes do not panic.
        assert_eq!(parse_stamp("2021-0\u{e9}-01T12:30", None), None);
        assert_eq!(parse_stamp("1\u{e9}/0\u{e9}/2021", None), None);
    }

    /// Seven clocks give their seconds after midnight, 24:00 among them, and eight lengths of time
    /// their minutes. Six texts of neither kind are refused.
    #[test]
    fn clocks_and_lengths_of_time_are_read() {
        let clocks =
            [("12:30", 45_000), ("1230", 45_000), ("12.5", 45_000), ("1", 3600), ("12:15 AM", 900), ("1 PM", 46_800)];
        for (text, seconds) in clocks {
            assert_eq!(parse_clock(text), Some(ClockText { seconds, ends_day: false }), "{text}");
        }
        assert_eq!(parse_clock("24:00"), Some(ClockText { seconds: 86_400, ends_day: true }));
        let lengths = [
            ("PT30M", 30.0),
            ("PT1H", 60.0),
            ("P0DT1H30M", 90.0),
            ("30", 30.0),
            ("5 min", 5.0),
            ("01:00", 60.0),
            ("01:00:00", 60.0),
            ("0 days 00:15:00", 15.0),
        ];
        for (text, minutes) in lengths {
            assert_eq!(parse_minutes(text), Some(minutes), "{text}");
        }
        for text in ["", "25", "noon"] {
            assert_eq!(parse_clock(text), None, "{text}");
        }
        for text in ["", "P1D", "soon"] {
            assert_eq!(parse_minutes(text), None, "{text}");
        }
    }
}
