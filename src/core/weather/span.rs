//! A part of a weather file, `--from` and `--to`. In: two moments as a user writes them. Out: the
//! rows of the part.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use crate::error::{Error, Problem, Result};
use crate::weather::time::calendar::Date;
use crate::weather::time::sun::Interval;
use crate::weather::time::years::Years;

/// A day or a time of a day, `2019-03-01`, `03-01`, `2019-03-01T06:30`, in the local standard time
/// of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Year; `None` for every year.
    year: Option<i32>,
    month: u32,
    day: u32,
    /// Minutes of the day, to 1440; `None` for the whole day.
    minutes: Option<u32>,
}

/// A year with a 29 February.
const LEAP_YEAR: i32 = 2000;

impl FromStr for Moment {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let number = |part: &str| match part.bytes().all(|b| b.is_ascii_digit()) {
            true => part.parse::<u32>().ok(),
            false => None,
        };
        let read = || {
            let (date, time) = match text.split_once(['T', ' ']) {
                Some((date, time)) => (date, Some(time)),
                None => (text, None),
            };
            let parts: Vec<u32> = date.split('-').map(number).collect::<Option<_>>()?;
            let (year, month, day) = match parts[..] {
                [year, month, day] => (Some(i32::try_from(year).ok()?), month, day),
                [month, day] => (None, month, day),
                _ => return None,
            };
            Date::new(year.unwrap_or(LEAP_YEAR), month, day)?;
            let minutes = match time {
                None => None,
                Some(time) => {
                    let (hours, minutes) =
                        time.strip_suffix(":00").filter(|time| time.contains(':')).unwrap_or(time).split_once(':')?;
                    let (hours, minutes) = (number(hours)?, number(minutes)?);
                    if hours > 24 || minutes > 59 || hours * 60 + minutes > 1440 {
                        return None;
                    }
                    Some(hours * 60 + minutes)
                }
            };
            Some(Moment { year, month, day, minutes })
        };
        read().ok_or_else(|| "give a day that exists, 2019-03-01 or 03-01, or a time of it, 2019-03-01T06:00".into())
    }
}

impl Moment {
    /// Returns the day of the moment, in `year` if it names none (29 February in the year before if
    /// `year` has none); `None` for a time of a day.
    pub fn day_in(&self, year: i32) -> Option<Date> {
        let of = |year: i32| Date::new(year, self.month, self.day);
        if self.minutes.is_some() {
            return None;
        }
        match self.year {
            Some(year) => of(year),
            None => of(year).or_else(|| of(year - 1)).or_else(|| Date::of_no_year(self.month, self.day)),
        }
    }

    /// Returns true if it names a year.
    pub fn has_year(&self) -> bool {
        self.year.is_some()
    }
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(year) = self.year {
            write!(f, "{year:04}-")?;
        }
        write!(f, "{:02}-{:02}", self.month, self.day)?;
        match self.minutes {
            Some(minutes) => write!(f, "T{:02}:{:02}", minutes / 60, minutes % 60),
            None => Ok(()),
        }
    }
}

/// Sort key of a moment; the year is 0 for a moment of any year.
type Place = (i32, u32, u32, f64);

/// Part from one moment to another; days at its ends are included whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    from: Option<Moment>,
    to: Option<Moment>,
}

impl Span {
    /// Returns the span of two moments. The two have a year and are in order, or neither has one:
    /// then the first may be the later one, over the new year.
    pub fn new(from: Option<Moment>, to: Option<Moment>) -> Result<Self> {
        let span = Span { from, to };
        let refuse = |supported: &'static str| {
            let (what, found) = ("the part of the weather file".into(), span.to_string());
            Err(Error::Unsupported { what, found, supported: supported.into() })
        };
        match (from, to) {
            (Some(a), Some(b)) if a.year.is_some() != b.year.is_some() => {
                refuse("two dates with a year or two without")
            }
            (Some(a), Some(b)) if a.year.is_some() && a.start() > b.end() => refuse("a first date before the last one"),
            _ => Ok(span),
        }
    }

    /// Returns for each row of a file true if all of its interval lies in the span. It is an error
    /// if no row does, or if the span names a year and the file's months come from different ones.
    pub fn rows_of(&self, rows: &[Interval], file: &Path) -> Result<Vec<bool>> {
        let has_year = [self.from, self.to].into_iter().flatten().any(|moment| moment.year.is_some());
        if has_year && Years::new(rows.iter().map(|row| row.date)) == Years::Typical {
            let what = format!("its months come from different years, so the part {self} would hold only some of them");
            let hint = "give month and day alone, such as 03-01, or put them into one year with {year}";
            return Err(Error::input(file, None, what, hint).because(Problem::Lacks("hours")));
        }
        let chosen: Vec<bool> = rows.iter().map(|row| self.contains(row)).collect();
        if chosen.contains(&true) {
            return Ok(chosen);
        }
        let label =
            |moment: Option<(Date, f64)>| moment.map_or_else(String::new, |(date, minutes)| date.label(minutes as u32));
        let (first, last) = (label(rows.first().map(Interval::start)), label(rows.last().map(Interval::end)));
        let what = format!("no row lies in the part {self}; its rows reach from {first} to {last}");
        Err(Error::input(file, None, what, "choose dates within the file").because(Problem::Lacks("hours")))
    }

    fn contains(&self, interval: &Interval) -> bool {
        let (start, end) = (interval.start(), interval.end());
        // Whole days compare with the day that the interval counts to, times with the moment of its
        // light.
        let place = |moment: Moment, (date, minutes): (Date, f64)| {
            let Date { year, month, day } = if moment.minutes.is_some() { date } else { interval.date };
            (moment.year.map_or(0, |_| year), month, day, minutes)
        };
        let (Some(from), Some(to)) = (self.from, self.to) else {
            return self.from.is_none_or(|from| place(from, start) >= from.start())
                && self.to.is_none_or(|to| place(to, end) <= to.end());
        };
        // Start and end of the interval are each compared with the two ends of the span, because
        // over the new year an interval may start late in a year and end early in one.
        let after = |moment| place(from, moment) >= from.start();
        let before = |moment| place(to, moment) <= to.end();
        match from.start() > to.end() {
            true => (after(start) || before(end)) && (after(start) || before(start)) && (after(end) || before(end)),
            false => after(start) && before(start) && after(end) && before(end),
        }
    }
}

impl Moment {
    /// Returns the sort key of its start. A whole day has all intervals that count to it, also
    /// those that reach over its midnights.
    fn start(&self) -> Place {
        self.place(f64::NEG_INFINITY)
    }

    fn end(&self) -> Place {
        self.place(f64::INFINITY)
    }

    fn place(&self, otherwise: f64) -> Place {
        (self.year.unwrap_or(0), self.month, self.day, self.minutes.map_or(otherwise, f64::from))
    }
}

impl fmt::Display for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.from, self.to) {
            (Some(from), Some(to)) => write!(f, "from {from} to {to}"),
            (Some(from), None) => write!(f, "from {from}"),
            (None, Some(to)) => write!(f, "to {to}"),
            (None, None) => write!(f, "from the first to the last row"),
        }
    }
}

heliotile_requests::parse_by_text!(Moment: heliotile_requests::Form::TEXT);

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the hours of some days, given as (year, month, day).
    fn hours_of(days: &[(i32, u32, u32)]) -> Vec<Interval> {
        let hour = |&(year, month, day): &(i32, u32, u32), hour: u32| {
            let date = Date::new(year, month, day).expect("a date");
            let start_min = f64::from(hour * 60);
            Interval { date, start_min, end_min: start_min + 60.0 }
        };
        days.iter().flat_map(|day| (0..24).map(move |h| hour(day, h))).collect()
    }

    fn span(from: &str, to: &str) -> Result<Span> {
        let moment = |text: &str| (!text.is_empty()).then(|| text.parse().expect("a moment"));
        Span::new(moment(from), moment(to))
    }

    /// Spans take the expected hours of six days of 2019: whole days, parts of days, over the new
    /// year, one side open.
    #[test]
    fn spans_take_the_expected_hours() {
        let file = hours_of(&[(2019, 1, 1), (2019, 2, 28), (2019, 3, 1), (2019, 3, 31), (2019, 11, 1), (2019, 12, 31)]);
        for (from, to, hours) in [
            ("", "", 144),
            ("2019-03-01", "2019-03-31", 48),
            ("03-01", "03-31", 48),
            ("2019-03-01T06:00", "2019-03-01 12:00", 6),
            ("03-01T06:30", "03-01T12:30", 5),
            ("03-01", "03-01T24:00", 24),
            ("11-01", "02-28", 96),
            ("12-31T12:00", "01-01T01:00", 13),
            ("03-31", "", 72),
            ("", "2018-12-31", 0),
            ("", "2019-02-28", 48),
        ] {
            let chosen = span(from, to).expect("a span").rows_of(&file, Path::new("w.epw"));
            match hours {
                0 => {
                    let text = chosen.expect_err("nothing").to_string();
                    assert!(text.contains(
                        "in the part to 2018-12-31; its rows reach from 2019-01-01T00:00 to 2019-12-31T24:00"
                    ));
                }
                _ => assert_eq!(chosen.expect("rows").iter().filter(|c| **c).count(), hours, "{from} {to}"),
            }
        }
    }

    /// Days have hours that begin 41 minutes before the clock's, or 30 after, and so reach over
    /// midnight. Times take the hours that lie within them whole, days the 24 that count to them,
    /// also at the new year. The message names the true begin and end of the file.
    #[test]
    fn shifted_hours_count_to_their_days() {
        let moved = |days: &[(i32, u32, u32)], minutes: f64| {
            let shifted =
                |i: Interval| Interval { start_min: i.start_min + minutes, end_min: i.end_min + minutes, ..i };
            hours_of(days).into_iter().map(shifted).collect::<Vec<_>>()
        };
        let may = [(2019, 5, 1), (2019, 5, 2)];
        let new_year = [(2018, 12, 31), (2019, 1, 1)];
        for (days, minutes, from, to, hours) in [
            (may, -41.0, "2019-05-02", "2019-05-02", 24),
            (may, -41.0, "2019-05-02T00:00", "2019-05-02T24:00", 23),
            (may, -41.0, "2019-05-01T23:00", "2019-05-02T00:30", 1),
            (may, -41.0, "05-01T23:19", "05-02T00:19", 1),
            (may, 30.0, "2019-05-01T23:00", "2019-05-02T01:30", 2),
            (may, 30.0, "2019-05-02T00:00", "", 24),
            (may, 30.0, "", "05-02T00:00", 23),
            (may, 30.0, "", "05-01", 24),
            (new_year, -41.0, "2019-01-01T00:00", "2019-01-01T12:00", 11),
            (new_year, -41.0, "01-01T00:00", "01-01T12:00", 11),
            (new_year, -41.0, "01-01", "01-01", 24),
            (new_year, -41.0, "12-31T23:00", "01-01T00:30", 1),
            (new_year, -41.0, "12-31T23:30", "01-01T00:30", 0),
            (new_year, -41.0, "12-31", "01-01", 48),
            (new_year, -41.0, "01-01T00:00", "12-31T24:00", 48),
        ] {
            let chosen = span(from, to).expect("a span").rows_of(&moved(&days, minutes), Path::new("w.epw"));
            let found = chosen.map_or(0, |chosen| chosen.iter().filter(|chosen| **chosen).count());
            assert_eq!(found, hours, "{minutes} {from} {to}");
        }
        let of_june = span("06-01", "06-30").expect("a span");
        for (minutes, said) in [
            (-41.0, "its rows reach from 2019-04-30T23:19 to 2019-05-02T23:19"),
            (30.0, "its rows reach from 2019-05-01T00:30 to 2019-05-03T00:30"),
        ] {
            let text = of_june.rows_of(&moved(&may, minutes), Path::new("w.epw")).expect_err("May").to_string();
            assert!(text.contains(said), "{text}");
        }
    }

    /// A year is refused for a file whose months come from two years, and accepted for a file of
    /// two whole years: 24 of 48 hours.
    #[test]
    fn a_year_is_refused_for_months_of_two_years() {
        let file = Path::new("w.epw");
        let of_2007 = span("2007-01-01", "2007-12-31").expect("a span");
        let text = of_2007.rows_of(&hours_of(&[(2007, 1, 1), (2004, 2, 1)]), file).expect_err("typical").to_string();
        assert!(text.contains("different years") && text.contains("03-01"), "{text}");
        let two = hours_of(&[(2007, 1, 1), (2008, 1, 1)]);
        assert_eq!(of_2007.rows_of(&two, file).expect("rows").iter().filter(|c| **c).count(), 24);
        let every = span("01-01", "01-31").expect("a span").rows_of(&two, file).expect("rows");
        assert_eq!(every.iter().filter(|c| **c).count(), 48);
    }

    /// Days that do not exist and times of no clock are refused, 12 of 12, and so are a year on one
    /// side only and a wrong order.
    #[test]
    fn days_and_times_that_do_not_exist_are_refused() {
        for text in [
            "",
            "2019",
            "2019-02-29",
            "13-01",
            "04-31",
            "03-01T",
            "03-01T6",
            "03-01T25:00",
            "03-01T24:01",
            "03-01T06:60",
            "2019-3-x",
            "+3-01",
        ] {
            assert!(text.parse::<Moment>().is_err(), "{text}");
        }
        assert_eq!("02-29".parse::<Moment>().map(|m| m.to_string()), Ok("02-29".to_string()));
        for (from, to, part) in [("2019-03-01", "05-31", "with a year"), ("2019-03-02", "2019-03-01", "before")] {
            let text = span(from, to).expect_err(part).to_string();
            assert!(text.contains(part) && text.contains(from), "{text}");
        }
    }
}
