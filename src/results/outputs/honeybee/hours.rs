//! Hours of a year as Honeybee counts them. In: conditions of a replay. Out: hours since the year
//! began of those with light, and the time step.

use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::time::calendar::Date;

/// Steps an hour that ladybug's analysis periods allow.
const STEPS: [u32; 12] = [1, 2, 3, 4, 5, 6, 10, 12, 15, 20, 30, 60];

/// Year without a leap day: Honeybee's files have none.
const PLAIN_YEAR: i32 = 2017;

/// Hours of a study, and which of them have light.
#[derive(Clone, Debug, PartialEq)]
pub struct LitHours {
    /// Number of steps an hour.
    pub timestep: u32,
    /// `[condition]`: start of the interval, hours since 1 January, 0:00.
    pub all: Vec<f64>,
    /// Indices into `all` of the hours with light of sun or sky.
    pub lit: Vec<usize>,
}

impl LitHours {
    /// Returns the hours of conditions, which must be in order. An error names what Honeybee cannot
    /// hold, and what to do.
    pub fn new(conditions: &[Condition]) -> Result<Self, (String, &'static str)> {
        let stamps = || conditions.iter().filter_map(|condition| condition.stamp);
        let hours = stamps().map(|stamp| stamp.hours).next().unwrap_or(1.0);
        let timestep = STEPS.into_iter().find(|steps| (f64::from(*steps) * hours - 1.0).abs() < 1e-9);
        let Some(timestep) = timestep.filter(|_| stamps().all(|stamp| (stamp.hours - hours).abs() < 1e-9)) else {
            return Err((
                format!("intervals of {} minutes", 60.0 * hours),
                "give weather in steps that divide an hour",
            ));
        };
        let mut all = Vec::with_capacity(conditions.len());
        for stamp in stamps() {
            let Date { month, day, .. } = stamp.date;
            let Some(date) = Date::new(PLAIN_YEAR, month, day) else {
                return Err(("29 February".into(), "put the rows into a year without it: {year} 2019"));
            };
            let steps = f64::from(timestep) * (24.0 * f64::from(date.day_of_year() - 1) + stamp.start_min / 60.0);
            if (steps - steps.round()).abs() > 1e-6 {
                return Err((
                    format!("an interval that begins at minute {}", stamp.start_min),
                    "shift the weather's clock by whole steps",
                ));
            }
            all.push(steps.round() / f64::from(timestep));
        }
        if all.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err(("rows that are not one year in order".into(), "choose a year with {from} and {to}"));
        }
        let has_light = |condition: &Condition| condition.dni_w_m2 > 0.0 || condition.dhi_w_m2 > 0.0;
        let lit =
            conditions.iter().enumerate().filter_map(|(i, condition)| has_light(condition).then_some(i)).collect();
        Ok(LitHours { timestep, all, lit })
    }

    /// Returns the text of `sun-up-hours.txt`: the lit hours, a number a line.
    pub fn text(&self) -> String {
        self.lit.iter().filter_map(|place| self.all.get(*place)).map(|hour| format!("{hour}\n")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use heliotile_core::weather::conditions::Stamp;

    fn day(year: i32, month: u32, day: u32) -> Date {
        Date::new(year, month, day).expect("a date")
    }

    fn condition(date: Date, start_min: f64, hours: f64, dhi: f64) -> Condition {
        let stamp = Some(Stamp { date, start_min, hours });
        Condition { stamp, ..Condition::new("c".into(), &[], DVec3::X, 0.0, dhi) }
    }

    /// The hour from 6:00 of 1 March is hour 1,422, in a leap year, too; quarters are 0.25 apart; 2
    /// of 3 hours have light.
    #[test]
    fn hours_of_leap_years_count_as_in_other_years() {
        for year in [2016, 2017] {
            let hours =
                [(360.0, 0.0), (420.0, 5.0), (480.0, 9.0)].map(|(min, dhi)| condition(day(year, 3, 1), min, 1.0, dhi));
            let hours = LitHours::new(&hours).expect("hours");
            assert_eq!((hours.timestep, hours.all[0], hours.lit.as_slice()), (1, 1422.0, &[1, 2][..]));
            assert_eq!(hours.text(), "1423\n1424\n");
        }
        let quarters = [0.0, 15.0].map(|min| condition(day(2017, 1, 1), min, 0.25, 1.0));
        assert_eq!(LitHours::new(&quarters).expect("quarters").text(), "0\n0.25\n");
    }

    /// A leap day, steps of 7 minutes, an hour from 6:10 and two years are refused: 4 of 4.
    #[test]
    fn hours_outside_of_one_plain_year_are_refused() {
        let refused = |conditions: &[Condition]| LitHours::new(conditions).expect_err("refused").0;
        assert_eq!(refused(&[condition(day(2016, 2, 29), 0.0, 1.0, 0.0)]), "29 February");
        assert!(refused(&[condition(day(2017, 1, 1), 0.0, 7.0 / 60.0, 0.0)]).contains("7 minutes"));
        assert!(refused(&[condition(day(2017, 1, 1), 370.0, 1.0, 0.0)]).contains("minute 370"));
        let twice = [2017, 2018].map(|year| condition(day(year, 1, 1), 0.0, 1.0, 0.0));
        assert!(refused(&twice).contains("one year"));
    }
}
