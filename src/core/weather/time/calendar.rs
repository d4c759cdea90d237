//! Calendar dates of weather rows: proleptic Gregorian, standard time, no daylight saving.

use jiff::{SignedDuration, civil};

/// A calendar date that exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Date {
    /// Year of the calendar, with all four digits.
    pub year: i32,
    /// Month, 1..=12.
    pub month: u32,
    /// Day of the month, 1..=28, 29, 30 or 31.
    pub day: u32,
}

/// Julian day number of 1970-01-01 00:00 UT.
const JULIAN_DAY_OF_1970: f64 = 2_440_587.5;

/// Day number 0.
const DAY_0: civil::Date = civil::date(1970, 1, 1);

/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

impl Date {
    /// Date of day number 0.
    pub const OF_DAY_0: Date = Date { year: 1970, month: 1, day: 1 };

    /// Returns a date that exists, in the years 1 to 2999 (the range of the delta T estimate ends
    /// in 3000).
    pub fn new(year: i32, month: u32, day: u32) -> Option<Self> {
        let exists = (1..3000).contains(&year) && civil_of(year, month, day).is_some();
        exists.then_some(Date { year, month, day })
    }

    /// Returns the date in the calendar of the library of time. Every date that can be made exists
    /// there.
    fn civil(self) -> civil::Date {
        civil_of(self.year, self.month, self.day).unwrap_or(DAY_0)
    }

    fn of_civil(date: civil::Date) -> Self {
        Date {
            year: date.year().into(),
            month: date.month().unsigned_abs().into(),
            day: date.day().unsigned_abs().into(),
        }
    }

    /// Year for weather that names none. It starts on a Sunday, as files of EnergyPlus say, and has
    /// no 29 February.
    pub const NO_YEAR: i32 = 2017;

    /// Returns a date without a year: in [`Date::NO_YEAR`], but 29 February in the year before.
    pub fn of_no_year(month: u32, day: u32) -> Option<Self> {
        Date::new(Date::NO_YEAR, month, day).or_else(|| Date::new(Date::NO_YEAR - 1, month, day))
    }

    /// Returns the day of the year: 1 on 1 January, 366 on 31 December of a leap year.
    pub fn day_of_year(self) -> u32 {
        self.civil().day_of_year().unsigned_abs().into()
    }

    /// Returns the Julian date (UT) of `minutes` after the local midnight that starts this date, in
    /// a zone `zone_hours` east.
    pub fn julian_date(self, minutes: f64, zone_hours: f64) -> f64 {
        JULIAN_DAY_OF_1970 + f64::from(self.day_number()) + (minutes - 60.0 * zone_hours) / 1440.0
    }

    /// Returns the days from 1970-01-01 to this date, negative before.
    pub fn day_number(self) -> i32 {
        (self.civil().duration_since(DAY_0).as_secs() / DAY_S as i64) as i32
    }

    /// Returns the moment `minutes` after the midnight that starts this date, to the second: its
    /// date, and the minutes of that day, from 0 to below 1440. The date may lie in the year 0 or
    /// 3000, for labels of shifted clocks and of last hours.
    pub fn after(self, minutes: f64) -> (Self, f64) {
        let seconds = (60.0 * minutes).round();
        let days = (seconds / DAY_S).floor();
        let date = self.civil().checked_add(of_days(days as i64)).ok().map(Date::of_civil);
        let date = date.filter(|date| (0..=3000).contains(&date.year));
        (date.unwrap_or(self), (seconds - DAY_S * days) / 60.0)
    }

    /// Returns the date of a [`Date::day_number`], in the years 1 to 2999.
    pub fn of_day_number(days: i32) -> Option<Self> {
        let date = Date::of_civil(DAY_0.checked_add(of_days(days.into())).ok()?);
        Date::new(date.year, date.month, date.day)
    }

    /// Returns `YYYY-MM-DD`, or `MM-DD` without the year.
    pub fn day_label(self, names_year: bool) -> String {
        let Date { year, month, day } = self;
        if names_year { format!("{year:04}-{month:02}-{day:02}") } else { format!("{month:02}-{day:02}") }
    }

    /// Returns `YYYY-MM-DDTHH:MM`, for minutes of this date (0..1440).
    pub fn label(self, minutes: u32) -> String {
        let Date { year, month, day } = self;
        format!("{year:04}-{month:02}-{day:02}T{:02}:{:02}", minutes / 60, minutes % 60)
    }

    /// Returns true if `next` is the day after this one in a file whose months may come from
    /// different years. Years are not compared, 29 February may be absent, and 31 December is
    /// followed by 1 January.
    pub fn is_followed_by(self, next: Date) -> bool {
        let last: u32 = self.civil().days_in_month().unsigned_abs().into();
        if next.month == self.month {
            return next.day == self.day + 1;
        }
        let at_end = self.day == last || (self.month == 2 && self.day == 28);
        at_end && next.day == 1 && next.month == self.month % 12 + 1
    }
}

/// Returns the length of whole days.
fn of_days(days: i64) -> SignedDuration {
    SignedDuration::from_hours(days.saturating_mul(24).clamp(i64::MIN / 3600, i64::MAX / 3600))
}

fn civil_of(year: i32, month: u32, day: u32) -> Option<civil::Date> {
    civil::Date::new(year.try_into().ok()?, month.try_into().ok()?, day.try_into().ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Julian dates agree with Reda and Andreas (2003), table A4.1: 2000-01-01 12:00 UT is
    /// 2451545.0, 1987-01-27 00:00 is 2446822.5, 1600-12-31 00:00 is 2305812.5.
    #[test]
    fn julian_dates_agree_with_reda_and_andreas() {
        for (year, month, day, minutes, expected) in
            [(2000, 1, 1, 720.0, 2_451_545.0), (1987, 1, 27, 0.0, 2_446_822.5), (1600, 12, 31, 0.0, 2_305_812.5)]
        {
            let date = Date::new(year, month, day).expect("a date");
            assert_eq!(date.julian_date(minutes, 0.0), expected);
        }
    }

    /// The first 730,000 days from 1 January of the year 1, and the last of 2999, come back from
    /// their numbers, which count up by 1 from day to day. 1970-01-01 is 0, and numbers outside of
    /// the years 1 to 2999 have no date.
    #[test]
    fn days_come_back_from_their_numbers() {
        let first = Date::new(1, 1, 1).expect("a date").day_number();
        let mut before = Date::of_day_number(first).expect("a date");
        for number in first + 1..first + 730_000 {
            let date = Date::of_day_number(number).expect("a date");
            assert!(date.day_number() == number && before.is_followed_by(date), "{before:?} {date:?}");
            before = date;
        }
        let last = Date::new(2999, 12, 31).expect("a date");
        assert_eq!(
            (Date::of_day_number(0), Date::of_day_number(last.day_number())),
            (Date::new(1970, 1, 1), Some(last))
        );
        for outside in [first - 1, last.day_number() + 1, i32::MIN, i32::MAX] {
            assert_eq!(Date::of_day_number(outside), None);
        }
    }

    /// 29 February exists in 2000 and 2016, not in 1900 and 2007; 31 December 2016 is day 366.
    #[test]
    fn centuries_are_leap_years_every_400_years() {
        for (year, exists) in [(2000, true), (2016, true), (1900, false), (2007, false)] {
            assert_eq!(Date::new(year, 2, 29).is_some(), exists, "{year}");
        }
        assert_eq!(Date::new(2016, 12, 31).expect("a date").day_of_year(), 366);
        assert!(Date::new(2016, 13, 1).is_none() && Date::new(2016, 4, 31).is_none());
    }

    /// 1970-01-01 is day 0, the day before it -1, 2000-03-01 day 11017 (Reda and Andreas'
    /// 2000-01-01 is 10957). From 1600 to 2400 the number of each next day is larger by 1: 292,194
    /// days.
    #[test]
    fn each_next_day_has_the_next_number() {
        let date = |y, m, d| Date::new(y, m, d).expect("a date");
        for ((y, m, d), days) in
            [((1970, 1, 1), 0), ((1969, 12, 31), -1), ((2000, 3, 1), 11_017), ((1, 1, 1), -719_162)]
        {
            assert_eq!(date(y, m, d).day_number(), days);
        }
        let (mut day, mut count) = (date(1600, 1, 1), 0);
        while day != date(2400, 1, 1) {
            let (next, minutes) = day.after(1440.0);
            assert_eq!((next.day_number(), minutes), (day.day_number() + 1, 0.0));
            (day, count) = (next, count + 1);
        }
        assert_eq!(count, 292_194);
    }

    /// Minutes before and after a day give the right date, over the ends of months, leap days and
    /// years, also into the years 0 and 3000, and to the second: 11 of 11.
    #[test]
    fn minutes_before_and_after_a_day_give_its_date() {
        for ((y, m, d), minutes, expected) in [
            ((2019, 1, 1), -41.0, ((2018, 12, 31), 1399.0)),
            ((2019, 1, 1), 0.0, ((2019, 1, 1), 0.0)),
            ((2019, 1, 1), 1439.5, ((2019, 1, 1), 1439.5)),
            ((2019, 1, 1), 1440.0, ((2019, 1, 2), 0.0)),
            ((2020, 2, 28), 1500.0, ((2020, 2, 29), 60.0)),
            ((2019, 2, 28), 2880.0, ((2019, 3, 2), 0.0)),
            ((2019, 3, 1), -1e-9, ((2019, 3, 1), 0.0)),
            ((2019, 3, 1), 1440.0 - 1e-9, ((2019, 3, 2), 0.0)),
            ((2999, 12, 31), 1440.0, ((3000, 1, 1), 0.0)),
            ((1, 1, 1), -1.0, ((0, 12, 31), 1439.0)),
            ((1, 1, 1), -1440.0, ((0, 12, 31), 0.0)),
        ] {
            let ((year, month, day), rest) = expected;
            let found = Date::new(y, m, d).expect("a date").after(minutes);
            assert_eq!(found, (Date { year, month, day }, rest), "{y}-{m}-{d} {minutes}");
            assert_eq!(
                found.0.day_number(),
                Date::new(y, m, d).map_or(0, Date::day_number) + (minutes / 1440.0 + 1e-9).floor() as i32
            );
        }
    }

    /// The day after 28 February may be 29 February or 1 March in any year; two days on is not the
    /// day after.
    #[test]
    fn february_is_followed_by_leap_day_or_march() {
        let date = |y, m, d| Date::new(y, m, d).expect("a date");
        assert!(date(2008, 2, 28).is_followed_by(date(2008, 2, 29)));
        assert!(date(2008, 2, 28).is_followed_by(date(2013, 3, 1)));
        assert!(date(2016, 12, 31).is_followed_by(date(2016, 1, 1)));
        assert!(!date(2016, 12, 30).is_followed_by(date(2017, 1, 1)));
        assert!(!date(2016, 3, 1).is_followed_by(date(2016, 3, 3)));
    }
}
