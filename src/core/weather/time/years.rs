//! Meaning of the years of a weather file. In: the dates of its rows. Out: one year, a typical year
//! or several years.

use std::collections::HashMap;

use crate::weather::time::calendar::Date;

/// Longest gap between rows of one series, days. Months that are farther apart, or go backwards,
/// are not of one series.
const LONGEST_GAP_DAYS: i32 = 31;

/// Kinds of years of a series of dates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Years {
    /// All rows are of one year.
    One,
    /// A typical year: months come from different years, no month from two.
    Typical,
    /// Several real years: the series goes on over the new year, or some month occurs in two years.
    Several,
}

impl Years {
    /// Returns the kind of years of these dates, which are in the order of the file.
    pub fn new(dates: impl IntoIterator<Item = Date>) -> Self {
        let mut year_of_month = HashMap::new();
        let (mut before, mut years): (Option<Date>, _) = (None, Years::One);
        for date in dates {
            let Date { year, month, .. } = date;
            if *year_of_month.entry(month).or_insert(year) != year {
                return Years::Several;
            }
            if let Some(before) = before.replace(date).filter(|before| before.year != year) {
                let goes_on = (0..=LONGEST_GAP_DAYS).contains(&(date.day_number() - before.day_number()));
                years = match (years, goes_on) {
                    (Years::One | Years::Several, true) => Years::Several,
                    _ => Years::Typical,
                };
            }
        }
        years
    }

    /// Returns true if years tell rows apart; the years of a typical year do not.
    pub fn matter(self) -> bool {
        self != Years::Typical
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A winter from 31 December to 1 January is of two years, and so is December to January; 2007
    /// after 2008 is not.
    #[test]
    fn a_winter_over_the_new_year_has_two_years() {
        let of = |dates: &[(i32, u32, u32)]| Years::new(dates.iter().filter_map(|&(y, m, d)| Date::new(y, m, d)));
        assert_eq!(of(&[(2018, 12, 30), (2018, 12, 31), (2019, 1, 1), (2019, 2, 1)]), Years::Several);
        assert_eq!(of(&[(2018, 12, 1), (2019, 1, 1)]), Years::Several);
        assert_eq!(of(&[(2008, 12, 31), (2007, 1, 1), (2007, 2, 1)]), Years::Typical);
    }

    /// One year, a typical year of two years, and a month in two years are told apart: 3 of 3. Only
    /// the years of the typical year do not matter.
    #[test]
    fn one_year_typical_and_mixed_years_are_told_apart() {
        let of = |months: &[(i32, u32)]| {
            Years::new(months.iter().map(|&(year, month)| Date::new(year, month, 1).expect("a date")))
        };
        assert_eq!(of(&[(2019, 1), (2019, 12)]), Years::One);
        assert_eq!(of(&[(2007, 1), (2004, 2)]), Years::Typical);
        assert_eq!(of(&[(2007, 1), (2007, 2), (2008, 1)]), Years::Several);
        assert!(!Years::Typical.matter() && Years::One.matter() && Years::Several.matter());
    }
}
