//! Days and hours that count. In: dates, a place, rules, weather. Out: for each rule its days, and
//! the spells in which the sun counts.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::calendar::DaySpan;
use super::rule::{ClockHours, Rule, RuleClock, RuleMeasure};
use heliotile_core::weather::time::clock_zone::ClockZone;
use rayon::prelude::*;

use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::layers::sides::TextureSides;
use heliotile_core::site::north::North;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::sun::Location;
use heliotile_core::weather::time::utc_offset::UtcOffset;
use heliotile_sunlight::{DniSpell, Spell, Spells, SunDay, SunPasses};
use heliotile_weather::series::Weather;

/// Least direct normal irradiance of sunshine, W/m2 (World Meteorological Organization, "Guide to
/// instruments and methods of observation", WMO-No. 8, sunshine duration).
const SUNSHINE_DNI_W_M2: f64 = 120.0;

/// Minutes of a day; `NOON_MIN` is half of it.
const DAY_MIN: f64 = 1440.0;
const NOON_MIN: f64 = 720.0;

/// Days to compute.
pub struct DayPlan {
    /// Location, with the standard time of the clock.
    pub site: Location,
    /// Clock of the results.
    pub zone: ClockZone,
    /// Year of days that name none.
    year: i32,
    /// Dates in order, each once.
    pub dates: Vec<Date>,
    /// True if results name the year of a day.
    pub names_years: bool,
    /// Weather of the days, if any is given.
    pub weather: Option<WeatherDays>,
}

/// Sun on these days in the axes of a site, and its paths through the site's textures.
pub struct SunDays {
    /// `[date]`: the sun.
    pub days: Vec<SunDay>,
    /// `[date]`: its path through textures.
    pub passes: Vec<SunPasses>,
}

/// Rule with its days.
pub struct PlannedRule {
    /// Rule of sunlight.
    pub rule: Rule,
    /// Days of the rule, and the spells on them in which the sun counts.
    pub days: Vec<RuleDay>,
    /// Minutes that count on open ground, for shares of them.
    pub open_min: f64,
}

/// Day of a rule.
pub struct RuleDay {
    /// Index into [`DayPlan::dates`].
    pub number: usize,
    /// Spells in which the sun counts.
    pub counts: Spells,
}

/// Direct normal irradiance of weather, by month and day.
pub struct WeatherDays(BTreeMap<MonthDay, Vec<DniSpell>>);

/// Day of any year.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct MonthDay {
    month: u32,
    day: u32,
}

impl From<Date> for MonthDay {
    fn from(date: Date) -> Self {
        MonthDay { month: date.month, day: date.day }
    }
}

impl DayPlan {
    /// Returns a plan of the days of all spans; those without a year are in `year`.
    pub fn new(site: Location, zone: ClockZone, year: i32, spans: &[&[DaySpan]]) -> Self {
        let mut dates: Vec<Date> = spans.iter().copied().flatten().flat_map(|span| span.days(year)).collect();
        dates.sort_by_key(|date| date.day_number());
        dates.dedup();
        let names_years = !spans.is_empty() && spans.iter().copied().flatten().all(DaySpan::has_year);
        DayPlan { site, zone, year, dates, names_years, weather: None }
    }

    /// Returns the label of a day in results.
    pub fn label(&self, date: Date) -> String {
        date.day_label(self.names_years)
    }

    /// Returns the indices of the days of some spans, in order, each once.
    pub fn numbers(&self, spans: &[DaySpan]) -> Vec<usize> {
        let wanted: Vec<i32> =
            spans.iter().flat_map(|span| span.days(self.year)).map(|date| date.day_number()).collect();
        let is_wanted = |date: &Date| wanted.contains(&date.day_number());
        (0..).zip(&self.dates).filter_map(|(number, date)| is_wanted(date).then_some(number)).collect()
    }

    /// Returns the sun on these days, and its paths through textures.
    pub fn suns(&self, north: North, sides: TextureSides) -> SunDays {
        let weather = |date: Date| self.weather.as_ref().map(|weather| weather.on(date).to_vec());
        let day = |date: &Date| SunDay::new(&self.site, *date, north).under(weather(*date));
        let days: Vec<SunDay> = self.dates.par_iter().map(day).collect();
        SunDays { passes: days.par_iter().map(|day| day.passes(sides)).collect(), days }
    }

    /// Returns the rules with their days. Errors: a rule without days if none are requested, and a
    /// rule that counts sunny hours without weather.
    pub fn rules(&self, rules: Vec<Rule>, asked: &[DaySpan], least_altitude_deg: f64) -> Result<Vec<PlannedRule>> {
        let suns: Vec<SunDay> =
            self.dates.iter().map(|date| SunDay::new(&self.site, *date, North::default())).collect();
        let planned = |rule: Rule| {
            let days = match (rule.needs_days(), rule.dates.is_empty()) {
                (false, _) => Vec::new(),
                (true, true) => self.numbers(asked),
                (true, false) => self.numbers(&rule.dates),
            };
            if rule.needs_days() && days.is_empty() {
                let what = format!("the rule `{}` has no dates, and none are given", rule.name);
                return Err(Error::argument(
                    "rule, dates",
                    what,
                    "give {dates}, or dates in the rule: dates = [\"03-21\"]",
                )
                .because(Problem::Missing));
            }
            let weather = match (rule.measure, &self.weather) {
                (RuleMeasure::ProbablePercent, None) => {
                    let what =
                        format!("the rule `{}` counts the sunny hours of a weather file, and none is given", rule.name);
                    return Err(Error::argument(
                        "rule, weather",
                        what,
                        "give {weather} to {command:sunlight}, or leave the rule out",
                    )
                    .because(Problem::needs("weather")));
                }
                (RuleMeasure::ProbablePercent, Some(weather)) => Some(weather),
                _ => None,
            };
            let altitude_deg = rule.least_altitude_deg.max(least_altitude_deg);
            let (mut of_rule, mut open_min) = (Vec::new(), 0.0);
            for number in days {
                let Some(sun) = suns.get(number) else { continue };
                let mut counts = if altitude_deg > 0.0 { sun.above(altitude_deg) } else { sun.up.clone() };
                if let Some(hours) = rule.hours {
                    counts = counts.within(&self.standard(hours, sun));
                }
                if let Some(weather) = weather {
                    counts = counts.within(&weather.sunny(sun.date));
                }
                open_min += counts.minutes();
                of_rule.push(RuleDay { number, counts });
            }
            Ok(PlannedRule { rule, days: of_rule, open_min })
        };
        rules.into_iter().map(planned).collect()
    }

    /// Converts hours of a rule's clock to a spell of standard time.
    fn standard(&self, hours: ClockHours, sun: &SunDay) -> Spells {
        let later_min = match hours.clock {
            RuleClock::Standard => 0.0,
            RuleClock::Legal => -self.zone.ahead_min(sun.date),
            RuleClock::Solar => solar_noon_min(sun) - NOON_MIN,
        };
        Spells::one((hours.from_min + later_min).max(0.0), (hours.to_min + later_min).min(DAY_MIN))
    }
}

/// Returns the moment at which the sun passes the meridian, minutes of standard time; `sun` must be
/// by true north.
fn solar_noon_min(sun: &SunDay) -> f64 {
    let afternoon = sun.when(|direction| -direction.x);
    afternoon.iter().map(|spell| spell.start_min).find(|start| *start > 0.0).unwrap_or(NOON_MIN)
}

impl WeatherDays {
    /// Returns the intervals of weather, by a clock with this offset from UTC.
    pub fn new(weather: &Weather, offset: UtcOffset) -> Self {
        let later_min = f64::from(offset.minutes()) - 60.0 * weather.site.zone_hours;
        let mut found: BTreeMap<MonthDay, Vec<DniSpell>> = BTreeMap::new();
        for row in &weather.rows {
            let mut add = |date: Date, start_min: f64, end_min: f64| {
                let spell = Spell { start_min, end_min };
                found.entry(date.into()).or_default().push(DniSpell { spell, dni_w_m2: row.dni_w_m2 });
            };
            let (date, start_min) = row.interval.date.after(row.interval.start_min + later_min);
            let end_min = start_min + 60.0 * row.interval.hours();
            add(date, start_min, end_min.min(DAY_MIN));
            if end_min > DAY_MIN {
                add(date.after(DAY_MIN).0, 0.0, end_min - DAY_MIN);
            }
        }
        WeatherDays(found)
    }

    /// Returns the intervals of a day, in the order of the file. By another clock, the last rows of
    /// a year may lie in its first day.
    fn on(&self, date: Date) -> &[DniSpell] {
        self.0.get(&date.into()).map_or(&[], Vec::as_slice)
    }

    /// Returns the sunny spells of a day: those with direct irradiance of at least 120 W/m2, the
    /// World Meteorological Organization's definition of sunshine.
    fn sunny(&self, date: Date) -> Spells {
        let sunny = self.on(date).iter().filter(|one| one.dni_w_m2 >= SUNSHINE_DNI_W_M2);
        sunny.fold(Spells::default(), |sum, one| sum.and(&Spells::one(one.spell.start_min, one.spell.end_min)))
    }

    /// Refuses weather that lacks dates whose hours count, as missing hours would count as hours
    /// without sun.
    pub fn check<'d>(weather: &Weather, mut dates: impl Iterator<Item = &'d Date>, file: &Path) -> Result<()> {
        let held: BTreeSet<MonthDay> = weather.rows.iter().map(|row| row.interval.date.into()).collect();
        // Files of a typical year have no 29 February.
        let is_held = |date: &Date| held.contains(&(*date).into()) || (date.month, date.day) == (2, 29);
        match dates.find(|date| !is_held(date)) {
            None => Ok(()),
            Some(date) => {
                let what = format!("has no hours of {}, which are counted", date.day_label(false));
                Err(Error::input(file, None, what, "give weather of a whole year").because(Problem::Lacks("hours")))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sunlight::rule_files::read_rules;

    fn plan(zone: &str, longitude_deg: f64) -> DayPlan {
        let zone: ClockZone = zone.parse().expect("a zone");
        let offset_h = f64::from(zone.standard(2017).minutes()) / 60.0;
        let site = Location::new(52.0, longitude_deg, offset_h, 0.0).expect("a site");
        let spans: Vec<DaySpan> = ["06-21", "01-20", "12-22"].map(|text| text.parse().expect("days")).to_vec();
        DayPlan::new(site, zone, 2017, &[&spans])
    }

    /// Hours from 8 to 16 of true solar time are symmetric about the moment at which the sun is
    /// highest. On 20 January at 5 degrees east that is 12:51 of a clock one hour ahead of UTC (40
    /// minutes of longitude, 11 of the equation of time). 9 to 15 of summer time is 8 to 14 of
    /// standard time.
    #[test]
    fn hours_of_rules_follow_the_clock_of_the_rule() {
        let plan = plan("Europe/Amsterdam", 5.0);
        let rules = read_rules(&["gb-50180".into()]).expect("rules");
        let planned = plan.rules(rules, &[], 0.0).expect("a plan");
        let counts = &planned[0].days[0].counts;
        let (first, last) = (counts.first_min().unwrap_or_default(), counts.last_min().unwrap_or_default());
        assert!((0.5 * (first + last) - 771.0).abs() < 1.0, "{first} {last}");
        let hours = ClockHours { from_min: 540.0, to_min: 900.0, clock: RuleClock::Legal };
        let june = SunDay::new(&plan.site, plan.dates[1], North::default());
        assert_eq!(plan.standard(hours, &june), Spells::one(480.0, 840.0));
        assert_eq!(plan.standard(ClockHours { clock: RuleClock::Standard, ..hours }, &june), Spells::one(540.0, 900.0));
    }

    /// A rule of probable hours is refused without weather, and a rule without dates if none are
    /// requested; with dates it is planned.
    #[test]
    fn rules_without_their_weather_or_dates_are_refused() {
        let plan = plan("+01:00", 5.0);
        let apsh = plan.rules(read_rules(&["bre-apsh".into()]).expect("rules"), &[], 0.0);
        assert!(apsh.is_err_and(|error| error.to_string().contains("weather")));
        let undated = || -> Rule { toml::from_str("name = \"own\"\nat_least = 60").expect("a rule") };
        let refused = plan.rules(vec![undated()], &[], 0.0);
        assert!(refused.is_err_and(|error| error.to_string().contains("`own` has no dates")));
        let days = ["06-21".parse().expect("a day")];
        let planned = plan.rules(vec![undated()], &days, 0.0).expect("a plan");
        assert_eq!((planned[0].days.len(), planned[0].days[0].number), (1, 1));
    }
}
