//! Columns of results about the sun on days. In: a request, answers of a place. Out: the numbers of
//! its rows.

use super::days::DayPlan;
use super::places::{AnswerItem, DateRows, RowSubject};
use super::rule::Threshold;
use heliotile_core::weather::time::clock_zone::ClockZone;
use heliotile_results::outputs::quantities::{Measure, Quantity, ValueSource, Verdict as Judgement};
use heliotile_results::outputs::tables::bin_labels::BinLabels;
use heliotile_results::outputs::tables::layout::{BinKind, By, Layout};
use heliotile_sunlight::{HotSpot, Spells, Strongest, SunSeen};

/// Number of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Number {
    /// Minutes of sun of a day, or their sum; for groups the mean by area.
    Sun,
    /// Minutes in which enough of a group's area is lit at the same time.
    Lit,
    /// Mean of the days' minutes.
    Mean,
    /// Least minutes of a day.
    Least,
    /// Most minutes of a day, for glare.
    Most,
    /// Longest spell; for groups with enough of the area lit.
    Longest,
    /// Start of the first spell.
    First,
    /// End of the last spell.
    Last,
    /// Uncertainty of the minutes.
    Uncertain,
    /// Minutes before a change.
    Before,
    /// Minutes that are lost by a change, or added for glare.
    Lost,
    /// Greatest irradiance of the sun in mirrors.
    Irradiance,
    /// Angle between the sun and its image.
    Deflection,
    /// Greatest irradiance by all images of the sun together.
    HotSpot,
    /// Date of the greatest irradiance.
    HotSpotDate,
    /// Time of the greatest irradiance.
    HotSpotAt,
    /// Value of a rule.
    Value,
    /// Least value that meets the rule.
    AtLeast,
    /// Greatest value that meets the rule.
    AtMost,
    /// Uncertainty of the value.
    ValueUncertain,
    /// Result of the rule.
    Verdict,
    /// Value of a rule before a change.
    ValueBefore,
    /// Result of the rule before a change.
    VerdictBefore,
}

/// Columns of the results of a request.
pub struct DayColumns<'a> {
    /// Dates or rules of the request.
    pub asked: &'a RowSubject,
    zone: &'a ClockZone,
    plan: &'a DayPlan,
    /// True if the minutes are of glare, the sun in mirrors.
    is_glare: bool,
    numbers: Vec<Number>,
}

impl<'a> DayColumns<'a> {
    /// Returns the columns of a request. `is_of_groups`, `has_before` and `is_glare` say if rows
    /// are about groups, if there are values before a change, and if minutes are of glare.
    pub fn new(asked: &'a RowSubject, plan: &'a DayPlan, is_of_groups: bool, has_before: bool, is_glare: bool) -> Self {
        use Number::{
            AtLeast, AtMost, Before, Deflection, First, HotSpot, HotSpotAt, HotSpotDate, Irradiance, Last, Least, Lit,
            Longest, Lost, Mean, Most, Sun, Uncertain, Value, ValueBefore, ValueUncertain, Verdict, VerdictBefore,
        };
        let numbers = match asked {
            RowSubject::Dates(DateRows { is_by_day: true, .. }) => vec![Sun, Lit, Longest, First, Last, Uncertain],
            RowSubject::Dates(_) if is_glare => vec![Sun, Most, Lit, Longest, Uncertain],
            RowSubject::Dates(_) => vec![Sun, Mean, Least, Lit, Longest, Uncertain],
            RowSubject::Rules(rules) => {
                let asks = |is_such: fn(&Threshold) -> bool| rules.iter().any(|one| is_such(&one.rule.threshold));
                let least = asks(|threshold| matches!(threshold, Threshold::AtLeast(_))).then_some(AtLeast);
                let most = asks(|threshold| matches!(threshold, Threshold::AtMost(_))).then_some(AtMost);
                [Some(Value), least, most, Some(ValueUncertain), Some(Verdict)].into_iter().flatten().collect()
            }
        };
        let of_mirrors: &[Number] = match asked {
            RowSubject::Dates(DateRows { is_by_day: true, .. }) if is_glare => {
                &[Irradiance, Deflection, HotSpot, HotSpotAt]
            }
            RowSubject::Dates(_) if is_glare => &[Irradiance, Deflection, HotSpot, HotSpotDate, HotSpotAt],
            _ => &[],
        };
        let former: &[Number] = match (has_before, asked) {
            (false, _) => &[],
            (true, RowSubject::Dates(_)) => &[Before, Lost],
            (true, RowSubject::Rules(_)) => &[ValueBefore, VerdictBefore],
        };
        let numbers = numbers.into_iter().filter(|number| is_of_groups || *number != Lit);
        let numbers = numbers.chain(of_mirrors.iter().chain(former).copied()).collect();
        DayColumns { asked, zone: &plan.zone, plan, is_glare, numbers }
    }

    /// Returns the number of arrays of a place.
    pub fn count(&self) -> usize {
        self.numbers.len()
    }

    /// Returns the labels of the rows of a place.
    pub fn bin_labels(&self) -> BinLabels {
        match self.asked {
            RowSubject::Dates(rows) => rows.labels.clone(),
            RowSubject::Rules(rules) => {
                BinLabels::words(rules.iter().map(|planned| planned.rule.name.clone()).collect())
            }
        }
    }

    /// Returns the layout for tables and maps.
    pub fn layout(&self, by: By) -> Layout {
        let labels = if matches!(self.asked, RowSubject::Dates(_)) { BinKind::Dates } else { BinKind::Rules };
        let is_time = match self.asked {
            RowSubject::Dates(_) => true,
            RowSubject::Rules(rules) => rules.iter().all(|planned| !planned.rule.measure.is_percent()),
        };
        let quantity = |(array, number): (usize, &Number)| {
            let (name, words, measure) = number.described(self.is_glare, self.plan.names_years);
            let words = match (number, self.asked) {
                (Number::Value, RowSubject::Rules(rules)) if rules.len() == 1 => rules[0].rule.measure.words(),
                _ => words,
            };
            // A table of rules in percent and in minutes has no common unit.
            let is_of_rule = matches!(self.asked, RowSubject::Rules(_));
            let measure = if measure == Measure::Number && is_time && is_of_rule { Measure::Minutes } else { measure };
            Quantity { name: name.into(), words: words.into(), source: ValueSource::Array(array), measure }
        };
        Layout::of_quantities(labels, by, self.numbers.iter().enumerate().map(quantity).collect())
    }

    /// Returns the numbers of a place: `[number][label]`.
    pub fn values(&self, items: &[Option<AnswerItem>]) -> Vec<Vec<f32>> {
        match self.asked {
            RowSubject::Dates(rows) => {
                let of_label = |label: usize| {
                    let dates = (0..).zip(&rows.bin_of_date).filter(|(_, of)| **of == label).map(|(date, _)| date);
                    DayItems { dates: dates.collect(), items }
                };
                let labels: Vec<DayItems> = (0..rows.labels.len()).map(of_label).collect();
                let of_number =
                    |number: &Number| labels.iter().map(|days| self.of_days(*number, days) as f32).collect();
                self.numbers.iter().map(of_number).collect()
            }
            RowSubject::Rules(rules) => {
                let of_rule = |number: Number, rule: usize| {
                    let Some(asked) = rules.get(rule).map(|planned| &planned.rule) else { return f64::NAN };
                    let Some(item) = items.get(rule).and_then(Option::as_ref) else { return f64::NAN };
                    let before = item.before.as_ref();
                    let verdict_before = || before.map(|before| before.verdict(asked.threshold).number().into());
                    match number {
                        Number::Value => item.value.value,
                        Number::AtLeast | Number::AtMost => match (number, asked.threshold) {
                            (Number::AtLeast, Threshold::AtLeast(least)) => least,
                            (Number::AtMost, Threshold::AtMost(most)) => most,
                            _ => f64::NAN,
                        },
                        Number::Verdict => item.value.judged(asked, before).number().into(),
                        Number::ValueBefore => before.map_or(f64::NAN, |before| before.value),
                        Number::VerdictBefore => verdict_before().unwrap_or(f64::NAN),
                        _ => item.value.uncertain(),
                    }
                };
                let of_number = |number: &Number| (0..rules.len()).map(|rule| of_rule(*number, rule) as f32).collect();
                self.numbers.iter().map(of_number).collect()
            }
        }
    }

    fn of_days(&self, number: Number, days: &DayItems) -> f64 {
        let minutes = |of: fn(&AnswerItem) -> f64| days.items().map(of);
        let seen = || days.items().flat_map(|item| &item.days).map(|day: &SunSeen| &day.seen);
        let strongest = || days.items().filter_map(|item| item.strongest).reduce(Strongest::and);
        let hot_spot = || days.items().filter_map(|item| item.hot_spot).reduce(HotSpot::higher);
        let ahead_min = days.dates.first().and_then(|date| self.plan.dates.get(*date));
        let ahead_min = ahead_min.map_or(0.0, |date| self.zone.ahead_min(*date));
        match number {
            Number::Sun => minutes(|item| item.value.value).fold(0.0, |sum, minutes| sum + minutes),
            // A place that did not exist before has no minutes before.
            Number::Before => minutes(|item| item.before.map_or(f64::NAN, |before| before.value)).sum(),
            Number::Lost => {
                let sign = if self.is_glare { -1.0 } else { 1.0 };
                let lost = |item: &AnswerItem| item.before.map_or(f64::NAN, |before| before.value - item.value.value);
                sign * minutes(lost).sum::<f64>()
            }
            Number::Most => minutes(|item| item.value.value).fold(0.0, f64::max),
            Number::Irradiance => strongest().map_or(0.0, |one| one.irradiance_w_m2),
            Number::Deflection => strongest().map_or(f64::NAN, |one| one.deflection_deg),
            Number::HotSpot => hot_spot().map_or(0.0, |one| one.irradiance_w_m2),
            Number::HotSpotDate => hot_spot().map_or(f64::NAN, |one| one.date.day_number().into()),
            Number::HotSpotAt => hot_spot().map_or(f64::NAN, |one| one.at_min + self.zone.ahead_min(one.date)),
            Number::Mean => minutes(|item| item.value.value).sum::<f64>() / days.dates.len().max(1) as f64,
            Number::Least => minutes(|item| item.value.value).fold(f64::INFINITY, f64::min),
            Number::Lit => seen().map(Spells::minutes).sum(),
            Number::Longest => seen().map(Spells::longest_min).fold(0.0, f64::max),
            Number::First => seen().next().and_then(Spells::first_min).map_or(f64::NAN, |at| at + ahead_min),
            Number::Last => seen().next().and_then(Spells::last_min).map_or(f64::NAN, |at| at + ahead_min),
            _ => minutes(|item| item.value.uncertain()).sum(),
        }
    }
}

impl Number {
    /// Returns the name of the column, the description in words, and the measure.
    fn described(self, is_glare: bool, names_year: bool) -> (&'static str, &'static str, Measure) {
        match self {
            Number::Sun if is_glare => ("glare_minutes", "sun in mirrors", Measure::Minutes),
            Number::Lit if is_glare => ("any_minutes", "sun in mirrors at any of it", Measure::Minutes),
            Number::Longest if is_glare => ("longest_minutes", "longest spell of sun in mirrors", Measure::Minutes),
            Number::First if is_glare => ("first", "first minute of sun in mirrors", Measure::Clock),
            Number::Last if is_glare => ("last", "last minute of sun in mirrors", Measure::Clock),
            Number::Before if is_glare => ("before_minutes", "sun in mirrors before", Measure::Minutes),
            Number::Lost if is_glare => ("added_minutes", "sun in mirrors that is new", Measure::Minutes),
            Number::Most => ("most_minutes", "sun in mirrors, day with the most", Measure::Minutes),
            Number::Irradiance => ("irradiance_w_m2", "irradiance by the sun in mirrors at most", Measure::Number),
            Number::Deflection => ("deflection_deg", "least angle between the sun and its image", Measure::Number),
            Number::HotSpot => ("hot_spot_w_m2", "irradiance by all mirrors at once at most", Measure::Number),
            Number::HotSpotDate => ("hot_spot_date", "date of that irradiance", Measure::Date { names_year }),
            Number::HotSpotAt => ("hot_spot_at", "time of that irradiance", Measure::Clock),
            Number::Sun => ("sun_minutes", "possible sun", Measure::Minutes),
            Number::Lit => ("lit_minutes", "enough of it lit", Measure::Minutes),
            Number::Mean => ("mean_minutes", "possible sun, mean of the days", Measure::Minutes),
            Number::Least => ("least_minutes", "possible sun, least day", Measure::Minutes),
            Number::Longest => ("longest_minutes", "longest spell of sun", Measure::Minutes),
            Number::First => ("first", "first minute of sun", Measure::Clock),
            Number::Last => ("last", "last minute of sun", Measure::Clock),
            Number::Uncertain => ("uncertain_minutes", "how far that may be off", Measure::Minutes),
            Number::Before => ("before_minutes", "possible sun before", Measure::Minutes),
            Number::Lost => ("lost_minutes", "possible sun that is lost", Measure::Minutes),
            Number::ValueBefore => ("before", "value of the rule before", Measure::Number),
            Number::VerdictBefore => ("verdict_before", "whether the rule was met before", Measure::Verdict),
            Number::Value => ("value", "value of the rule", Measure::Number),
            Number::AtLeast => (Judgement::THRESHOLDS[0], "least value that meets the rule", Measure::Number),
            Number::AtMost => (Judgement::THRESHOLDS[1], "most that meets the rule", Measure::Number),
            Number::ValueUncertain => ("uncertain", "how far the value may be off", Measure::Number),
            Number::Verdict => (Judgement::COLUMN, "whether the rule is met", Measure::Verdict),
        }
    }
}

/// Answers of a place on the days of a row.
struct DayItems<'i> {
    dates: Vec<usize>,
    items: &'i [Option<AnswerItem>],
}

impl DayItems<'_> {
    fn items(&self) -> impl Iterator<Item = &AnswerItem> {
        self.dates.iter().filter_map(|date| self.items.get(*date)?.as_ref())
    }
}
