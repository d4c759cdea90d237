//! What the years of a weather file stand for.

use std::collections::HashMap;

use crate::weather::time::calendar::Date;

/// Years of a series of dates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Years {
    /// All rows share one.
    One,
    /// A typical year: months come from different years, none from two.
    Typical,
    /// Some month occurs in two years: the series is really several years long.
    Several,
}

impl Years {
    /// What the years of these dates, in the order of the file, stand for.
    pub fn of(dates: impl IntoIterator<Item = Date>) -> Self {
        let mut year_of_month = HashMap::new();
        let (mut first, mut years) = (None, Years::One);
        for Date { year, month, .. } in dates {
            if *first.get_or_insert(year) != year {
                years = Years::Typical;
            }
            if *year_of_month.entry(month).or_insert(year) != year {
                return Years::Several;
            }
        }
        years
    }

    /// Whether years tell rows apart; those of a typical year do not.
    pub fn matter(self) -> bool {
        self != Years::Typical
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One year, months of two years, a month in two years: 3 of 3, and the years of the second do not matter.
    #[test]
    fn three_kinds() {
        let of = |months: &[(i32, u32)]| {
            Years::of(months.iter().map(|&(year, month)| Date::new(year, month, 1).expect("a date")))
        };
        assert_eq!(of(&[(2019, 1), (2019, 12)]), Years::One);
        assert_eq!(of(&[(2007, 1), (2004, 2)]), Years::Typical);
        assert_eq!(of(&[(2007, 1), (2007, 2), (2008, 1)]), Years::Several);
        assert!(!Years::Typical.matter() && Years::One.matter() && Years::Several.matter());
    }
}
