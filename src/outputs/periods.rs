//! Periods that hourly results are summed over. In: when each condition was. Out: which period it belongs to.

use std::collections::HashMap;
use std::str::FromStr;

use heliotile_core::error::Error;
use heliotile_core::units::kwh_from_w;
use heliotile_core::weather::conditions::Stamp;
use heliotile_core::weather::time::bins::Bins;
use heliotile_core::weather::time::years::Years;

/// What a row of a replay's results stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Every {
    /// One row per interval of the weather file: means, W/m2
    #[default]
    Hour,
    /// Sums, kWh/m2, as the three below
    Day,
    Month,
    Year,
    /// One sum over all that is taken of the file
    Total,
}

impl FromStr for Every {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        match text {
            "hour" => Ok(Every::Hour),
            "day" => Ok(Every::Day),
            "month" => Ok(Every::Month),
            "year" => Ok(Every::Year),
            "total" => Ok(Every::Total),
            _ => Err(Error::Unsupported {
                what: "period of the results".into(),
                found: format!("`{text}`"),
                supported: "hour, day, month, year and total".into(),
            }),
        }
    }
}

/// The periods of a series, in order of first appearance.
#[derive(Clone, Debug, PartialEq)]
pub struct Periods {
    pub labels: Vec<String>,
    /// `[condition]`: place in `labels`.
    pub index_of_condition: Vec<usize>,
    /// `[condition]`: length of its interval. A sum in kWh/m2 is the sum over conditions of mean W/m2 x hours / 1000.
    pub hours: Vec<f64>,
}

impl Periods {
    /// Groups conditions, given with their labels. In a typical year days are labelled `MM-DD`, months `MM`, the year `year`;
    /// where the years of the file matter they are named: `YYYY-MM-DD`, `YYYY-MM`, `YYYY`. `total` is one period.
    pub fn new(every: Every, years: Years, conditions: &[(String, Stamp)]) -> Self {
        let named = years.matter();
        let mut place_of: HashMap<String, usize> = HashMap::new();
        let mut periods = Periods {
            labels: Vec::new(),
            index_of_condition: Vec::with_capacity(conditions.len()),
            hours: conditions.iter().map(|(_, stamp)| stamp.hours).collect(),
        };
        for (label, Stamp { date, .. }) in conditions {
            let (month, day) = (date.month, date.day);
            let year = if named { format!("{:04}-", date.year) } else { String::new() };
            let label = match every {
                Every::Hour => label.clone(),
                Every::Day => format!("{year}{month:02}-{day:02}"),
                Every::Month => format!("{year}{month:02}"),
                Every::Year if named => format!("{:04}", date.year),
                Every::Year => "year".to_string(),
                Every::Total => "total".to_string(),
            };
            let next = periods.labels.len();
            let place = if every == Every::Hour {
                // Rows stay rows, also where a label repeats.
                next
            } else {
                *place_of.entry(label.clone()).or_insert(next)
            };
            if place == next {
                periods.labels.push(label);
            }
            periods.index_of_condition.push(place);
        }
        periods
    }

    /// Sums of energy, kWh/m2, from means over the conditions, W/m2.
    pub fn bins(&self) -> Bins {
        let places = self.index_of_condition.iter().zip(&self.hours);
        Bins {
            count: self.labels.len(),
            of_condition: places.map(|(&place, &hours)| (place, kwh_from_w(1.0, hours))).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::weather::time::calendar::Date;

    fn series(days: &[(i32, u32, u32)]) -> Vec<(String, Stamp)> {
        days.iter()
            .map(|&(y, m, d)| {
                let date = Date::new(y, m, d).expect("a date");
                (date.label(0), Stamp { date, hours: 1.0 })
            })
            .collect()
    }

    fn periods(every: Every, series: &[(String, Stamp)]) -> Periods {
        Periods::new(every, Years::of(series.iter().map(|(_, stamp)| stamp.date)), series)
    }

    /// Two days of one year give 2 days, 2 months, 1 year and 1 total, the first three with the year in the label.
    #[test]
    fn one_year() {
        let s = series(&[(2019, 1, 31), (2019, 1, 31), (2019, 2, 1)]);
        let day = periods(Every::Day, &s);
        assert_eq!(day.labels, ["2019-01-31", "2019-02-01"]);
        assert_eq!(day.index_of_condition, [0, 0, 1]);
        assert_eq!(day.hours, [1.0; 3]);
        assert_eq!(periods(Every::Month, &s).labels, ["2019-01", "2019-02"]);
        assert_eq!(periods(Every::Year, &s).labels, ["2019"]);
        assert_eq!(periods(Every::Hour, &s).index_of_condition, [0, 1, 2]);
        let total = periods(Every::Total, &s);
        assert_eq!((total.labels, total.index_of_condition), (vec!["total".to_string()], vec![0; 3]));
    }

    /// A typical year with months of two years is one `year` without years in its labels.
    #[test]
    fn typical_year() {
        let s = series(&[(2007, 1, 1), (2004, 2, 1)]);
        assert_eq!(periods(Every::Day, &s).labels, ["01-01", "02-01"]);
        assert_eq!(periods(Every::Month, &s).labels, ["01", "02"]);
        assert_eq!(periods(Every::Year, &s).labels, ["year"]);
    }

    /// One month of a typical year is labelled as in the whole year: `01`, not with the year it comes from.
    #[test]
    fn part_of_typical_year() {
        let s = series(&[(2007, 1, 1), (2007, 1, 2)]);
        assert_eq!(Periods::new(Every::Month, Years::Typical, &s).labels, ["01"]);
    }

    /// Two Januaries are two months and two years; no rows give no periods.
    #[test]
    fn several_years() {
        let s = series(&[(2007, 1, 1), (2007, 2, 1), (2008, 1, 1)]);
        assert_eq!(periods(Every::Month, &s).labels, ["2007-01", "2007-02", "2008-01"]);
        assert_eq!(periods(Every::Year, &s).labels, ["2007", "2008"]);
        assert_eq!(periods(Every::Day, &[]).labels.len(), 0);
    }

    /// The five names are read; `week` is refused with the list.
    #[test]
    fn names() {
        for (name, every) in [
            ("hour", Every::Hour),
            ("day", Every::Day),
            ("month", Every::Month),
            ("year", Every::Year),
            ("total", Every::Total),
        ] {
            assert_eq!(name.parse::<Every>().expect("a name"), every);
        }
        let text = "week".parse::<Every>().expect_err("week").to_string();
        assert!(text.contains("hour, day, month, year and total"), "{text}");
    }
}
