//! Periods that hourly results are summed over. In: the moment of each condition. Out: the period
//! that it belongs to.

use std::collections::HashMap;

use crate::outputs::tables::bin_labels::{BinLabels, Precision};
use heliotile_core::named::NamedValues;
use heliotile_core::units::kwh_from_w;
use heliotile_core::weather::conditions::Stamp;
use heliotile_core::weather::options::StampedAt;
use heliotile_core::weather::time::bins::Bins;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::utc_offset::UtcOffset;
use heliotile_core::weather::time::years::Years;

/// Period of a row of a replay's results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Every {
    /// Interval of the weather file, one row each: means, W/m2.
    #[default]
    Hour,
    /// Day: sums, kWh/m2, as for the periods below.
    Day,
    /// Month of a year, or of typical years: sums, kWh/m2.
    Month,
    /// Calendar year: sums, kWh/m2.
    Year,
    /// All of the chosen time: one sum, kWh/m2.
    Total,
}

impl Every {
    /// Returns the word for several of them, as in names of files.
    pub fn periods(self) -> &'static str {
        match self {
            Every::Hour => "hours",
            Every::Day => "days",
            Every::Month => "months",
            Every::Year => "years",
            Every::Total => "total",
        }
    }
}

/// Clock and convention of labels for moments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClockReading {
    /// Offset of the weather file's clock from UTC.
    pub offset: UtcOffset,
    /// Moment of its interval that labels a row of means: 06:00, 06:30 or 07:00 for 06:00 to 07:00.
    /// The end of a day's last hour is 00:00 of the next day.
    pub at: StampedAt,
}

/// Periods of a series, in order of first appearance.
#[derive(Clone, Debug, PartialEq)]
pub struct Periods {
    pub labels: BinLabels,
    /// `[condition]`: index into `labels`.
    pub index_of_condition: Vec<usize>,
    /// `[condition]`: length of its interval, hours. A sum in kWh/m2 is the sum over conditions of
    /// mean W/m2 x hours / 1000.
    pub hours: Vec<f64>,
}

impl Periods {
    /// Groups conditions by period. In a typical year labels are words: days `MM-DD`, months `MM`,
    /// the year `year`. If years matter, labels name them, `YYYY-MM-DD`, `YYYY-MM`, `YYYY`, and are
    /// instants, too: the starts of the periods. `total` is one period, labelled by a word.
    /// Intervals are always instants.
    pub fn new(every: Every, years: Years, stamps: &[Stamp], clock: ClockReading) -> Self {
        let mut place_of: HashMap<(i32, u32, u32), usize> = HashMap::new();
        let (mut starts, mut index_of_condition) = (Vec::new(), Vec::with_capacity(stamps.len()));
        for stamp in stamps {
            let Date { year, month, day } = stamp.date;
            let year = if years.matter() { year } else { 0 };
            let next = starts.len();
            let place = match every {
                // Each interval keeps its row, even if labels repeat.
                Every::Hour => next,
                Every::Day => *place_of.entry((year, month, day)).or_insert(next),
                Every::Month => *place_of.entry((year, month, 1)).or_insert(next),
                Every::Year => *place_of.entry((year, 1, 1)).or_insert(next),
                Every::Total => 0,
            };
            if place == next {
                starts.push(match every {
                    Every::Hour => (stamp.date, stamp.start_min + clock.at.share_before() * 60.0 * stamp.hours),
                    Every::Day | Every::Total => (stamp.date, 0.0),
                    Every::Month => (Date { day: 1, ..stamp.date }, 0.0),
                    Every::Year => (Date { month: 1, day: 1, ..stamp.date }, 0.0),
                });
            }
            index_of_condition.push(place);
        }
        let moments = |precision| BinLabels::moments(&starts, clock.offset, precision);
        let words = |word: fn(&Date) -> String| BinLabels::words(starts.iter().map(|(date, _)| word(date)).collect());
        let labels = match (every, years.matter()) {
            (Every::Hour, _) => moments(Precision::Minute),
            (Every::Day, true) => moments(Precision::Day),
            (Every::Month, true) => moments(Precision::Month),
            (Every::Year, true) => moments(Precision::Year),
            (Every::Day, false) => words(|date| format!("{:02}-{:02}", date.month, date.day)),
            (Every::Month, false) => words(|date| format!("{:02}", date.month)),
            (Every::Year, false) => words(|_| "year".into()),
            (Every::Total, _) => words(|_| "total".into()),
        };
        Periods { labels, index_of_condition, hours: stamps.iter().map(|stamp| stamp.hours).collect() }
    }

    /// Returns the bins that turn means over the conditions, W/m2, into sums of energy, kWh/m2.
    pub fn bins(&self) -> Bins {
        let places = self.index_of_condition.iter().zip(&self.hours);
        Bins {
            count: self.labels.len(),
            of_condition: places.map(|(&place, &hours)| (place, kwh_from_w(1.0, hours))).collect(),
        }
    }
}

impl NamedValues for Every {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("hour", "One row for each interval of the weather file: means", Every::Hour),
        ("day", "One row for each day: sums", Every::Day),
        ("month", "One row for each month: sums", Every::Month),
        ("year", "One row for each year: sums", Every::Year),
        ("total", "One row for all chosen time: sums", Every::Total),
    ];
}

heliotile_core::serde_by_name!(Every);

heliotile_core::parse_by_name!(Every);

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the last hours of some days.
    fn series(days: &[(i32, u32, u32)]) -> Vec<Stamp> {
        let stamp = |&(y, m, d): &(i32, u32, u32)| Stamp {
            date: Date::new(y, m, d).expect("a date"),
            start_min: 1380.0,
            hours: 1.0,
        };
        days.iter().map(stamp).collect()
    }

    fn in_zone(hours: f64, at: StampedAt) -> ClockReading {
        ClockReading { offset: UtcOffset::of_hours(hours), at }
    }

    fn periods(every: Every, stamps: &[Stamp]) -> Periods {
        Periods::new(every, Years::new(stamps.iter().map(|stamp| stamp.date)), stamps, in_zone(1.0, StampedAt::Start))
    }

    /// The label of the last hour of 31 December is 23:00, 23:30 or 00:00 of the new year by its
    /// start, middle or end; the middle of a quarter of an hour is at 07:30 min; sums keep the
    /// start of their period.
    #[test]
    fn labels_follow_start_middle_or_end_of_an_hour() {
        let last = series(&[(2019, 12, 31)]);
        for (at, text, utc_s) in [
            (StampedAt::Start, "2019-12-31T23:00+01:00", 1_577_829_600),
            (StampedAt::Middle, "2019-12-31T23:30+01:00", 1_577_831_400),
            (StampedAt::End, "2020-01-01T00:00+01:00", 1_577_833_200),
        ] {
            let labels = Periods::new(Every::Hour, Years::One, &last, in_zone(1.0, at)).labels;
            assert_eq!((labels.text[0].as_str(), labels.instants.map(|i| i.utc_s)), (text, Some(vec![utc_s])));
            let month = Periods::new(Every::Month, Years::One, &last, in_zone(1.0, at)).labels;
            assert_eq!(
                (month.text[0].as_str(), month.instants.map(|i| i.utc_s)),
                ("2019-12", Some(vec![1_575_154_800]))
            );
        }
        let quarter = [Stamp { start_min: 0.0, hours: 0.25, ..last[0] }];
        let labels = Periods::new(Every::Hour, Years::One, &quarter, in_zone(-3.5, StampedAt::Middle)).labels;
        assert_eq!(labels.text, ["2019-12-31T00:07:30-03:30"]);
    }

    /// Two days of one year give 2 days, 2 months, 1 year and 1 total, the first three with the
    /// year in the label; days are instants at local midnight.
    #[test]
    fn periods_of_one_year_show_the_year() {
        let s = series(&[(2019, 1, 31), (2019, 1, 31), (2019, 2, 1)]);
        let day = periods(Every::Day, &s);
        assert_eq!(day.labels.text, ["2019-01-31", "2019-02-01"]);
        assert_eq!(day.index_of_condition, [0, 0, 1]);
        assert_eq!(day.hours, [1.0; 3]);
        assert_eq!(periods(Every::Month, &s).labels.text, ["2019-01", "2019-02"]);
        assert_eq!(periods(Every::Year, &s).labels.text, ["2019"]);
        assert_eq!(periods(Every::Hour, &s).index_of_condition, [0, 1, 2]);
        let total = periods(Every::Total, &s);
        assert_eq!((total.labels, total.index_of_condition), (BinLabels::words(vec!["total".into()]), vec![0; 3]));
        assert_eq!(day.labels.instants.map(|i| i.utc_s), Some(vec![1_548_889_200, 1_548_975_600]));
    }

    /// A typical year with months of two years is one `year` without years in its labels.
    #[test]
    fn a_typical_year_has_no_year_in_its_labels() {
        let s = series(&[(2007, 1, 1), (2004, 2, 1)]);
        assert_eq!(periods(Every::Day, &s).labels.text, ["01-01", "02-01"]);
        assert_eq!(periods(Every::Month, &s).labels.text, ["01", "02"]);
        assert_eq!(periods(Every::Year, &s).labels, BinLabels::words(vec!["year".into()]));
        assert_eq!(periods(Every::Hour, &s).labels.text, ["2007-01-01T23:00+01:00", "2004-02-01T23:00+01:00"]);
    }

    /// One month of a typical year is labelled as in the whole year: `01`, without the year that it
    /// comes from.
    #[test]
    fn a_month_of_a_typical_year_shows_no_year() {
        let s = series(&[(2007, 1, 1), (2007, 1, 2)]);
        let month = Periods::new(Every::Month, Years::Typical, &s, ClockReading::default());
        assert_eq!(month.labels, BinLabels::words(vec!["01".into()]));
    }

    /// Two Januaries are two months and two years; no rows give no periods.
    #[test]
    fn two_januaries_are_two_months_and_two_years() {
        let s = series(&[(2007, 1, 1), (2007, 2, 1), (2008, 1, 1)]);
        assert_eq!(periods(Every::Month, &s).labels.text, ["2007-01", "2007-02", "2008-01"]);
        assert_eq!(periods(Every::Year, &s).labels.text, ["2007", "2008"]);
        assert_eq!(periods(Every::Day, &[]).labels.len(), 0);
    }
}
