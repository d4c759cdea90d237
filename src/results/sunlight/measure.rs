//! What a rule measures of spells of sun. In: a rule with its days, the sun that is seen on them. Out: a value, how far it may be off, a verdict.

use super::days::PlannedRule;
use super::rule::{DaysTogether, Rule, RuleMeasure};
use crate::outputs::quantities::Verdict;
use heliotile_core::sunlight::{Spells, SunSeen};

/// A value with the least and the most that it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RuleValue {
    /// Minutes, or percent.
    pub value: f64,
    /// Of what is sure.
    pub low: f64,
    /// Of what is possible.
    pub high: f64,
}

/// Values nearer to a threshold than this are on it: minutes are sums of rounded numbers.
const ON_IT: f64 = 1e-6;

impl RuleValue {
    /// A value without a doubt.
    pub fn certain(value: f64) -> Self {
        RuleValue { value, low: value, high: value }
    }

    /// How far the value may be off.
    pub fn uncertain(&self) -> f64 {
        (self.value - self.low).max(self.high - self.value).max(0.0)
    }

    /// What a rule makes of it, and of what it was before a change.
    pub fn judged(&self, rule: &Rule, before: Option<&RuleValue>) -> Verdict {
        let verdict = self.verdict(rule.at_least);
        match (rule.former_share, before) {
            // Less than what was asked for before may be enough now, too.
            (Some(share), Some(before)) if verdict != Verdict::Met => {
                let of_former = RuleValue {
                    value: self.value - share * before.value,
                    low: self.low - share * before.high,
                    high: self.high - share * before.low,
                };
                match of_former.verdict(0.0) {
                    Verdict::Broken => verdict,
                    enough => enough,
                }
            }
            _ => verdict,
        }
    }

    /// What the threshold makes of it.
    pub fn verdict(&self, at_least: f64) -> Verdict {
        let reaches = |value: f64| value >= at_least - ON_IT;
        match (reaches(self.low), reaches(self.high)) {
            (true, _) => Verdict::Met,
            (_, false) => Verdict::Broken,
            _ => Verdict::Close,
        }
    }

    /// The least value that is reached on this share of an area: of parts with their values, whose shares add up to 1.
    pub fn reached_on(share: f64, parts: &[(f64, RuleValue)]) -> Self {
        let reached = |of: fn(&RuleValue) -> f64| {
            let mut sorted: Vec<(f64, f64)> = parts.iter().map(|(share, value)| (of(value), *share)).collect();
            sorted.sort_by(|a, b| b.0.total_cmp(&a.0));
            let mut sum = 0.0;
            let at = sorted.iter().find(|(_, part)| {
                sum += part;
                sum >= share - ON_IT
            });
            at.or(sorted.last()).map_or(0.0, |(value, _)| *value)
        };
        RuleValue {
            value: reached(|value| value.value),
            low: reached(|value| value.low),
            high: reached(|value| value.high),
        }
    }
}

impl PlannedRule {
    /// The value of what is seen on the rule's days, `[day of the rule]`, when the sun counts.
    pub fn value(&self, seen: &[SunSeen]) -> RuleValue {
        let of = |set: fn(&SunSeen) -> &Spells| {
            let minutes: Vec<f64> = seen.iter().map(|day| self.minutes(set(day))).collect();
            self.together(&minutes)
        };
        RuleValue { value: of(|day| &day.seen), low: of(|day| &day.sure), high: of(|day| &day.possible) }
    }

    /// Minutes of a day that the rule counts.
    fn minutes(&self, spells: &Spells) -> f64 {
        match (self.rule.measure, self.rule.least_spell_min) {
            (RuleMeasure::LongestSpell, _) => spells.longest_min(),
            (_, least) if least > 0.0 => spells.lasting(least).minutes(),
            _ => spells.minutes(),
        }
    }

    fn together(&self, minutes: &[f64]) -> f64 {
        let (sum, count) = (minutes.iter().sum::<f64>(), minutes.len().max(1) as f64);
        let joined = match self.rule.days {
            DaysTogether::Each => minutes.iter().copied().reduce(f64::min).unwrap_or_default(),
            DaysTogether::Any => minutes.iter().copied().fold(0.0, f64::max),
            DaysTogether::Mean => sum / count,
            DaysTogether::Sum => sum,
        };
        match self.rule.measure {
            RuleMeasure::ProbablePercent if self.open_min > 0.0 => 100.0 * joined / self.open_min,
            _ => joined,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 120 minutes that may be 119 to 121 are close to a threshold of 120, and 121 on the safe side of it; a half of an area reaches what its
    /// better parts of 30 and 20 % do, a tenth of it the best part's value.
    #[test]
    fn verdicts_and_areas() {
        let value = RuleValue { value: 120.0, low: 119.0, high: 121.0 };
        assert_eq!(
            (value.verdict(120.0), value.verdict(119.0), value.verdict(121.5)),
            (Verdict::Close, Verdict::Met, Verdict::Broken)
        );
        assert_eq!(RuleValue::certain(120.0).verdict(120.0), Verdict::Met);
        assert_eq!(value.uncertain(), 1.0);
        let parts = [(0.5, 10.0), (0.3, 200.0), (0.2, 130.0)].map(|(share, value)| (share, RuleValue::certain(value)));
        let reached = |share| RuleValue::reached_on(share, &parts).value;
        assert_eq!((reached(0.5), reached(0.1), reached(0.51), reached(1.0)), (130.0, 200.0, 10.0, 10.0));
    }
}
