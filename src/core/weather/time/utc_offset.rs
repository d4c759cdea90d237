//! Offset of a clock from UTC. In: hours of a weather file's header. Out: whole minutes, as ISO
//! 8601 writes them.

use std::fmt;

/// Fixed offset of a clock from UTC, in whole minutes; there is no daylight saving time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UtcOffset {
    minutes: i32,
}

impl UtcOffset {
    /// Returns the offset of a zone in hours east, to the nearest minute: ISO 8601 has no finer
    /// ones.
    pub fn of_hours(hours: f64) -> Self {
        UtcOffset { minutes: (60.0 * hours).round() as i32 }
    }

    /// Returns the minutes ahead of UTC, negative in the west.
    pub fn minutes(self) -> i32 {
        self.minutes
    }
}

/// Writes the offset as `+05:30`; UTC is `+00:00`.
impl fmt::Display for UtcOffset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.minutes < 0 { '-' } else { '+' };
        let minutes = self.minutes.unsigned_abs();
        write!(f, "{sign}{:02}:{:02}", minutes / 60, minutes % 60)
    }
}

/// Reads hours ahead of UTC: `+01:00`, `-0330`, `1`, `5.5`, `UTC`, `Z`, `UTC+1`.
pub fn parse_zone(text: &str) -> Option<f64> {
    if ["UTC", "GMT", "Z"].iter().any(|name| text.eq_ignore_ascii_case(name)) {
        return Some(0.0);
    }
    let after_name = text.get(..3).filter(|name| ["UTC", "GMT"].iter().any(|known| name.eq_ignore_ascii_case(known)));
    let text = match after_name.and(text.get(3..)).map(str::trim_start) {
        Some(offset) if offset.starts_with(['+', '-']) => offset,
        Some(_) => return None,
        None => text,
    };
    let (sign, digits) = match (text.strip_prefix('-'), text.strip_prefix('+')) {
        (Some(digits), _) => (-1.0, digits),
        (_, Some(digits)) => (1.0, digits),
        _ => (1.0, text),
    };
    if !digits.starts_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let clock = match digits.split_once(':') {
        Some(clock) => Some(clock),
        None if digits.len() == 4 && digits.bytes().all(|b| b.is_ascii_digit()) => digits.split_at_checked(2),
        None => None,
    };
    let hours = match clock {
        Some((hours, minutes)) => {
            let whole = |text: &str| text.parse::<u32>().ok().filter(|_| (1..=2).contains(&text.len()));
            f64::from(whole(hours)?) + f64::from(whole(minutes).filter(|minutes| *minutes < 60)?) / 60.0
        }
        None => digits.parse().ok()?,
    };
    Some(sign * hours).filter(|hours| (-12.0..=14.0).contains(hours))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fourteen spellings of a zone give its hours; ten texts that are no zone are refused.
    #[test]
    fn spellings_of_zones_give_their_hours() {
        for (text, hours) in [
            ("+01:00", 1.0),
            ("-07:00", -7.0),
            ("-0330", -3.5),
            ("+05:45", 5.75),
            ("1", 1.0),
            ("-7", -7.0),
            ("5.5", 5.5),
            ("+14", 14.0),
            ("UTC", 0.0),
            ("utc", 0.0),
            ("Z", 0.0),
            ("0", 0.0),
            ("UTC+1", 1.0),
            ("GMT-03:30", -3.5),
        ] {
            assert_eq!(parse_zone(text), Some(hours), "{text}");
        }
        for text in ["", "+", "CET", "15", "+01:60", "nan", "inf", "--1", "UTC1", "GMT+"] {
            assert_eq!(parse_zone(text), None, "{text}");
        }
    }

    /// Nine zones, of whole and other hours, west and east, have their ISO 8601 offsets and
    /// minutes.
    #[test]
    fn zones_have_their_iso_8601_offsets() {
        for (hours, text, minutes) in [
            (1.0, "+01:00", 60),
            (0.0, "+00:00", 0),
            (-0.0, "+00:00", 0),
            (-7.0, "-07:00", -420),
            (5.5, "+05:30", 330),
            (9.5, "+09:30", 570),
            (5.75, "+05:45", 345),
            (-3.5, "-03:30", -210),
            (0.33, "+00:20", 20),
        ] {
            let offset = UtcOffset::of_hours(hours);
            assert_eq!((offset.to_string().as_str(), offset.minutes()), (text, minutes));
        }
    }
}
