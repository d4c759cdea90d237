//! Days of a request. In: text such as `03-21`, `2026-03-21`, `02-19..10-21` or `year`. Out: dates
//! in order.

use std::fmt;
use std::str::FromStr;

use heliotile_core::weather::span::Moment;
use heliotile_core::weather::time::calendar::Date;

/// Day, or all days from one to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DaySpan {
    first: Moment,
    last: Moment,
}

/// Text for all days of a year.
const YEAR: &str = "year";

/// Largest number of days: a hundred years.
const MAX_DAYS: i32 = 36_525;

impl FromStr for DaySpan {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = if text == YEAR { "01-01..12-31" } else { text };
        let (first, last) = text.split_once("..").unwrap_or((text, text));
        let day = |text: &str| {
            let moment: Option<Moment> = text.parse().ok().filter(|moment: &Moment| moment.day_in(0).is_some());
            moment.ok_or_else(|| {
                format!(
                    "`{text}` is not a day: give a day as 03-21 or 2026-03-21, a span of days as 02-19..10-21, or year"
                )
            })
        };
        let span = DaySpan { first: day(first)?, last: day(last)? };
        if span.first.has_year() != span.last.has_year() {
            return Err(format!("`{text}` has a year for one of its days: give it for both days, or for none"));
        }
        match span.days(Date::NO_YEAR).len() {
            0 => Err(format!("`{text}` ends before it begins, or lasts for more than a hundred years")),
            _ => Ok(span),
        }
    }
}

impl fmt::Display for DaySpan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.first)?;
        if self.last == self.first { Ok(()) } else { write!(f, "..{}", self.last) }
    }
}

impl DaySpan {
    /// Returns the days in order. Days without a year are in `year`, and over the new year in the
    /// next one.
    pub fn days(&self, year: i32) -> Vec<Date> {
        let Some((first, last)) = self.first.day_in(year).zip(self.last.day_in(year)) else { return Vec::new() };
        let is_over_new_year = last.day_number() < first.day_number() && !self.first.has_year();
        let last = if is_over_new_year { self.last.day_in(year + 1).unwrap_or(last) } else { last };
        let numbers = first.day_number()..=last.day_number();
        match numbers.end() - numbers.start() {
            0..=MAX_DAYS => numbers.filter_map(Date::of_day_number).collect(),
            _ => Vec::new(),
        }
    }

    /// Returns true if the days name their year.
    pub fn has_year(&self) -> bool {
        self.first.has_year()
    }
}

heliotile_requests::parse_by_text!(DaySpan: heliotile_requests::Form::TEXT);

heliotile_core::serde_by_text!(DaySpan);

#[cfg(test)]
mod tests {
    use super::*;

    /// Spans are a day, the 245 of the Dutch rule, 121 days over the new year and a leap year of
    /// 366; five texts that are no days are refused.
    #[test]
    fn a_span_over_the_new_year_has_its_days() {
        let days = |text: &str, year| text.parse::<DaySpan>().expect("days").days(year);
        assert_eq!(days("03-21", 2026), [Date { year: 2026, month: 3, day: 21 }]);
        assert_eq!(days("2026-03-21", 2017).first().map(|date| date.year), Some(2026));
        assert_eq!(days("02-19..10-21", 2017).len(), 245);
        assert_eq!(days("11-01..03-01", 2017).len(), 121);
        assert_eq!((days("year", 2024).len(), days("year", 2023).len()), (366, 365));
        assert_eq!("02-19..10-21".parse::<DaySpan>().expect("days").to_string(), "02-19..10-21");
        for wrong in ["03-32", "2026-03-21..04-01", "2026-05-01..2026-04-01", "03-21T08:00", ""] {
            assert!(wrong.parse::<DaySpan>().is_err(), "{wrong}");
        }
    }
}
