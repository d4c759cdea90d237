//! Labels of a table's rows. In: words, or moments of a local clock. Out: text for CSV, and
//! instants for formats with times.

use crate::outputs::tables::zone_name;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::utc_offset::UtcOffset;

/// Precision of the text of a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// Year, as in `2019`.
    Year,
    /// Month, as in `2019-03`.
    Month,
    /// Day, as in `2019-03-01`.
    Day,
    /// Minute, as in `2019-03-01T06:00+01:00`.
    Minute,
    /// Second, as in `2019-03-01T06:00:30+01:00`.
    Second,
}

impl Precision {
    /// Returns the text of a moment of a local clock: a day, and seconds after its midnight.
    fn text(self, day: Date, seconds: i64, zone: &str) -> String {
        let Date { year, month, day } = day;
        let (hour, minute) = (seconds / 3600, seconds / 60 % 60);
        match self {
            Precision::Year => format!("{year:04}"),
            Precision::Month => format!("{year:04}-{month:02}"),
            Precision::Day => format!("{year:04}-{month:02}-{day:02}"),
            Precision::Minute => format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}{zone}"),
            Precision::Second => {
                format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{:02}{zone}", seconds % 60)
            }
        }
    }
}

/// Labels as instants.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instants {
    /// Seconds since 1970-01-01 00:00 UTC.
    pub utc_s: Vec<i64>,
    /// Offset of the labels' local standard time from UTC.
    pub offset: UtcOffset,
    /// Precision of the text.
    pub precision: Precision,
}

/// Labels of the rows of a receiver, in order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BinLabels {
    /// Text for CSV.
    pub text: Vec<String>,
    /// Labels as instants; `None` for names of conditions, `total` and the periods of a typical
    /// year.
    pub instants: Option<Instants>,
}

impl BinLabels {
    /// Returns labels that are no times.
    pub fn words(text: Vec<String>) -> Self {
        BinLabels { text, instants: None }
    }

    /// Returns the labels of moments of a local clock: a date, and minutes after its midnight.
    /// Minutes of shifted clocks may lie in the day before or after.
    pub fn moments(moments: &[(Date, f64)], offset: UtcOffset, precision: Precision) -> Self {
        let seconds = |minutes: f64| (60.0 * minutes).round() as i64;
        let odd = moments.iter().any(|(_, minutes)| seconds(*minutes) % 60 != 0);
        let precision = if odd && precision == Precision::Minute { Precision::Second } else { precision };
        let zone = offset.to_string();
        let text = moments.iter().map(|(date, minutes)| {
            let (date, minutes) = date.after(*minutes);
            precision.text(date, seconds(minutes), &zone)
        });
        let text = text.collect();
        let utc = |&(date, minutes): &(Date, f64)| {
            i64::from(date.day_number()) * DAY_S + seconds(minutes) - 60 * i64::from(offset.minutes())
        };
        let utc_s = moments.iter().map(utc).collect();
        BinLabels { text, instants: Some(Instants { utc_s, offset, precision }) }
    }

    /// Returns true if there are no labels.
    pub fn is_empty(&self) -> bool {
        self.text.is_empty()
    }

    /// Returns the number of labels.
    pub fn len(&self) -> usize {
        self.text.len()
    }
}

/// Seconds of a day.
const DAY_S: i64 = 86_400;

impl Instants {
    /// Returns microseconds since 1970-01-01 00:00 UTC, the unit of pandas, Polars and DuckDB.
    pub fn utc_us(&self) -> Vec<i64> {
        self.utc_s.iter().map(|seconds| seconds * 1_000_000).collect()
    }

    /// Returns the readings of the local clock, in seconds since its reading of 1970-01-01 00:00.
    pub fn local_s(&self) -> Vec<i64> {
        self.utc_s.iter().map(|seconds| seconds + 60 * i64::from(self.offset.minutes())).collect()
    }

    /// Returns the time zone of a column.
    pub fn zone(&self) -> String {
        zone_name::of(self.offset, self.utc_s.iter().copied().min().unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(moments: &[((i32, u32, u32), f64)], hours: f64, precision: Precision) -> BinLabels {
        let moments: Vec<_> =
            moments.iter().map(|((y, m, d), minutes)| (Date::new(*y, *m, *d).expect("a date"), *minutes)).collect();
        BinLabels::moments(&moments, UtcOffset::of_hours(hours), precision)
    }

    /// A clock moved by 41 minutes begins on the day before, at 23:19, and another row is on the
    /// day after, at 00:19: text and UTC agree.
    #[test]
    fn text_and_utc_agree_over_midnight() {
        let found = labels(&[((2019, 1, 1), -41.0), ((2019, 1, 1), 1459.0)], 0.0, Precision::Minute);
        assert_eq!(found.text, ["2018-12-31T23:19+00:00", "2019-01-02T00:19+00:00"]);
        let utc = found.instants.map(|instants| instants.utc_s).unwrap_or_default();
        assert_eq!(utc.first().zip(utc.get(1)).map(|(a, b)| b - a), Some(25 * 3600));
    }

    /// 06:00 in zones of +1, -7 and +5.5 h is 05:00, 13:00 and 00:30 UTC; 24:00 of 31 December is
    /// 00:00 of the new year; half minutes add seconds to all labels.
    #[test]
    fn local_times_become_utc() {
        let day = 17_956 * 86_400;
        for (hours, text, utc) in [
            (1.0, "2019-03-01T06:00+01:00", day + 5 * 3600),
            (-7.0, "2019-03-01T06:00-07:00", day + 13 * 3600),
            (5.5, "2019-03-01T06:00+05:30", day + 1800),
        ] {
            let labels = labels(&[((2019, 3, 1), 360.0)], hours, Precision::Minute);
            assert_eq!(labels.text, [text]);
            let instants = labels.instants.expect("instants");
            assert_eq!((instants.utc_s[0], instants.local_s()[0]), (utc, day + 6 * 3600));
            assert_eq!(instants.utc_us()[0], utc * 1_000_000);
        }
        let end = labels(&[((2019, 12, 31), 1440.0), ((2020, 2, 28), 1440.0)], 0.0, Precision::Minute);
        assert_eq!(end.text, ["2020-01-01T00:00+00:00", "2020-02-29T00:00+00:00"]);
        assert_eq!(end.instants.expect("instants").utc_s[0], 1_577_836_800);
        let half = labels(&[((2019, 3, 1), 0.5), ((2019, 3, 1), 1.0)], 1.0, Precision::Minute);
        assert_eq!(half.text, ["2019-03-01T00:00:30+01:00", "2019-03-01T00:01:00+01:00"]);
    }

    /// Days, months and years are dates without a clock, and instants at local midnight: 23:00 UTC
    /// of the day before at +1 h.
    #[test]
    fn days_are_instants_at_local_midnight() {
        for (precision, text) in
            [(Precision::Day, "2019-03-01"), (Precision::Month, "2019-03"), (Precision::Year, "2019")]
        {
            let labels = labels(&[((2019, 3, 1), 0.0)], 1.0, precision);
            assert_eq!(labels.text, [text]);
            assert_eq!(labels.instants.expect("instants").utc_s, [17_956 * 86_400 - 3600]);
        }
    }
}
