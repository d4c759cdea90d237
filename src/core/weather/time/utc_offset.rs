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

#[cfg(test)]
mod tests {
    use super::*;

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
