//! Choice of the rows of a weather file that results are made of, and their dates. In: a file's
//! intervals, a span, perhaps a year to put them into. Out: a choice of rows, each with its date.
//!
//! Only dates of results change. The suns of a row stay those of the date in the file, under which
//! its irradiances were measured.

use std::path::Path;

use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::{Message, message};
use heliotile_core::weather::span::Span;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::sun::Interval;
use heliotile_core::weather::time::years::Years;

/// Rows of a weather file with the dates that results give them.
#[derive(Clone, Debug, PartialEq)]
pub struct DatedRows {
    /// `[row]` of the file: true if it is used.
    pub chosen: Vec<bool>,
    /// `[row]` of the file: its date in results.
    pub dates: Vec<Date>,
    /// Meaning of the years of all these dates.
    pub years: Years,
    /// Sentences for the user, each naming the file.
    pub warnings: Vec<Message>,
}

impl DatedRows {
    /// Returns the rows of a span with the dates of the file.
    pub fn of_file(rows: &[Interval], file: &Path, span: &Span) -> Result<Self> {
        let dates: Vec<Date> = rows.iter().map(|row| row.date).collect();
        let (chosen, years) = (span.rows_of(rows, file)?, Years::new(dates.iter().copied()));
        Ok(DatedRows { chosen, dates, years, warnings: Vec::new() })
    }

    /// Returns the rows of a span with their dates put into one year. 29 February is left out, with
    /// a warning, where that year has none. Years in the span are the new year, except for a file
    /// of several years: there they choose among these.
    pub fn in_year(rows: &[Interval], file: &Path, span: &Span, year: i32) -> Result<Self> {
        let at = |date: Date| Date::new(year, date.month, date.day);
        let moved: Vec<Interval> =
            rows.iter().map(|row| Interval { date: at(row.date).unwrap_or(row.date), ..*row }).collect();
        // In a file of several years the span chooses by these; else it names the new year.
        let several = Years::new(rows.iter().map(|row| row.date)) == Years::Several;
        let mut chosen = span.rows_of(if several { rows } else { &moved }, file)?;
        let taken = || rows.iter().zip(&chosen).filter_map(|(row, chosen)| chosen.then_some(row.date));
        if Years::new(taken()) == Years::Several {
            let what = format!("months of several years cannot all be put into {year}");
            let hint = "choose the months of one year with {from} and {to}, or leave {year} out";
            return Err(Error::input(file, None, what, hint).because(Problem::Lacks("year")));
        }
        let lost = taken().filter(|date| at(*date).is_none()).count();
        let has = |month, day| taken().any(|date| (date.month, date.day) == (month, day));
        let lacks_a_day = Date::new(year, 2, 29).is_some() && has(2, 28) && has(3, 1) && !has(2, 29);
        let mut warnings = Vec::new();
        if lost > 0 {
            warnings.push(message!(
                "{}: 29 February is left out, because {year} has no such day: {lost} of {} rows",
                file.display(),
                taken().count()
            ));
        }
        if lacks_a_day {
            warnings.push(message!(
                "{}: results have no rows of 29 February, because the file lacks this day of {year}",
                file.display()
            ));
        }
        chosen.iter_mut().zip(rows).for_each(|(chosen, row)| *chosen &= at(row.date).is_some());
        if !chosen.contains(&true) {
            let what = format!("no row is left: all are of 29 February, and {year} has no such day");
            return Err(Error::input(file, None, what, "choose a leap year, or leave {year} out"));
        }
        let dates = moved.into_iter().map(|row| row.date).collect();
        Ok(DatedRows { chosen, dates, years: Years::One, warnings })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the twelve-hour halves of some days.
    fn halves(days: &[(i32, u32, u32)]) -> Vec<Interval> {
        let half = |&(year, month, day): &(i32, u32, u32), start_min: f64| {
            let date = Date::new(year, month, day).expect("a date");
            Interval { date, start_min, end_min: start_min + 720.0 }
        };
        days.iter().flat_map(|day| [half(day, 0.0), half(day, 720.0)]).collect()
    }

    fn span(from: &str, to: &str) -> Span {
        let moment = |text: &str| (!text.is_empty()).then(|| text.parse().expect("a moment"));
        Span::new(moment(from), moment(to)).expect("a span")
    }

    fn in_year(days: &[(i32, u32, u32)], from: &str, to: &str, year: i32) -> Result<DatedRows> {
        DatedRows::in_year(&halves(days), Path::new("w.epw"), &span(from, to), year)
    }

    fn count(rows: &DatedRows) -> usize {
        rows.chosen.iter().filter(|chosen| **chosen).count()
    }

    /// A typical year of 1999 and 1996 keeps these years, or gets 2019 with all of its 6 rows.
    /// Dates of 2019 then choose 2 of them.
    #[test]
    fn a_typical_year_can_get_one_year() {
        let days = [(1999, 1, 31), (1996, 2, 1), (1996, 2, 28)];
        let kept = DatedRows::of_file(&halves(&days), Path::new("w.epw"), &span("", "")).expect("rows");
        assert_eq!((kept.years, kept.dates[0].year, kept.dates[5].year, count(&kept)), (Years::Typical, 1999, 1996, 6));
        let put = in_year(&days, "", "", 2019).expect("rows");
        assert_eq!((put.years, count(&put), put.warnings.len()), (Years::One, 6, 0));
        assert!(put.dates.iter().all(|date| date.year == 2019));
        assert_eq!(count(&in_year(&days, "2019-02-01", "2019-02-01", 2019).expect("rows")), 2);
        let text = in_year(&days, "1996-02-01", "1996-02-01", 2019).expect_err("of 2019").to_string();
        assert!(
            text.contains(
                "in the part from 1996-02-01 to 1996-02-01; its rows reach from 2019-01-31T00:00 to 2019-02-28T24:00"
            ),
            "{text}"
        );
    }

    /// 29 February of 2020 is left out of 2019, 2 of 6 rows, and stays in 2024. Alone it is
    /// refused. A file without it leaves 2020 without it, with one warning.
    #[test]
    fn leap_days_exist_in_leap_years_only() {
        let leap = [(2020, 2, 28), (2020, 2, 29), (2020, 3, 1)];
        let put = in_year(&leap, "", "", 2019).expect("rows");
        assert_eq!(put.chosen, [true, true, false, false, true, true]);
        assert!(put.warnings[0].contains("w.epw: 29 February is left out, because 2019 has no such day: 2 of 6 rows"));
        let kept = in_year(&leap, "", "", 2024).expect("rows");
        assert_eq!((count(&kept), kept.warnings.len(), kept.dates[2].year), (6, 0, 2024));
        let text = in_year(&leap, "02-29", "02-29", 2019).expect_err("nothing").to_string();
        assert!(text.contains("all are of 29 February, and 2019 has no such day"), "{text}");
        let short = in_year(&[(2019, 2, 28), (2019, 3, 1)], "", "", 2020).expect("rows");
        assert_eq!((count(&short), short.warnings.len()), (4, 1));
        assert!(short.warnings[0].contains("the file lacks this day of 2020"), "{:?}", short.warnings);
        assert_eq!(in_year(&[(2019, 3, 1)], "", "", 2020).expect("rows").warnings.len(), 0);
    }

    /// Two Januaries do not go into one year. One of them, chosen by its own year, does: 2 of 4
    /// rows.
    #[test]
    fn two_januaries_do_not_go_into_one_year() {
        let days = [(2007, 1, 1), (2008, 1, 1)];
        let text = in_year(&days, "", "", 2019).expect_err("two").to_string();
        assert!(text.contains("several years cannot all be put into 2019"), "{text}");
        let one = in_year(&days, "2008-01-01", "2008-01-31", 2019).expect("rows");
        assert_eq!(one.chosen, [false, false, true, true]);
        assert!(one.dates.iter().all(|date| date.year == 2019));
    }
}
