//! Values of rules. In: a rule with its days, the sun that is seen on them. Out: a value, its
//! uncertainty, a verdict.

use super::days::PlannedRule;
use super::rule::{DaysTogether, Rule, RuleMeasure, Threshold};
use heliotile_results::outputs::quantities::Verdict;
use heliotile_sunlight::{Spells, SunSeen};

/// Value of a rule, with its bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RuleValue {
    /// Value: minutes, or percent.
    pub value: f64,
    /// Lower bound, from spells that are sure.
    pub low: f64,
    /// Upper bound, from spells that are possible.
    pub high: f64,
}

/// Largest distance from a threshold that counts as equal: minutes are sums of rounded numbers.
const ON_IT: f64 = 1e-6;

impl RuleValue {
    /// Returns a value without uncertainty.
    pub fn certain(value: f64) -> Self {
        RuleValue { value, low: value, high: value }
    }

    /// Returns the uncertainty of the value.
    pub fn uncertain(&self) -> f64 {
        (self.value - self.low).max(self.high - self.value).max(0.0)
    }

    /// Returns the verdict of a rule on the value, given the value before a change.
    pub fn judged(&self, rule: &Rule, before: Option<&RuleValue>) -> Verdict {
        let verdict = self.verdict(rule.threshold);
        match (rule.former_share, before) {
            // A value below the threshold may be enough if the value before was low, too.
            (Some(share), Some(before)) if verdict != Verdict::Met => {
                let of_former = RuleValue {
                    value: self.value - share * before.value,
                    low: self.low - share * before.high,
                    high: self.high - share * before.low,
                };
                match of_former.verdict(Threshold::AtLeast(0.0)) {
                    Verdict::Broken => verdict,
                    enough => enough,
                }
            }
            _ => verdict,
        }
    }

    /// Returns the verdict of a threshold on the value.
    pub fn verdict(&self, threshold: Threshold) -> Verdict {
        // True for the worst and for the best possible value if it meets the threshold.
        let (worst, best) = match threshold {
            Threshold::AtLeast(least) => (self.low >= least - ON_IT, self.high >= least - ON_IT),
            Threshold::AtMost(most) => (self.high <= most + ON_IT, self.low <= most + ON_IT),
        };
        match (worst, best) {
            (true, _) => Verdict::Met,
            (_, false) => Verdict::Broken,
            _ => Verdict::Close,
        }
    }

    /// Returns the value that is reached, or not exceeded, on a share of an area. `parts` have
    /// shares that add up to 1, and values.
    pub fn reached_on(share: f64, threshold: Threshold, parts: &[(f64, RuleValue)]) -> Self {
        let reached = |of: fn(&RuleValue) -> f64| {
            let mut sorted: Vec<(f64, f64)> = parts.iter().map(|(share, value)| (of(value), *share)).collect();
            // The best parts come first.
            sorted.sort_by(|a, b| match threshold {
                Threshold::AtLeast(_) => b.0.total_cmp(&a.0),
                Threshold::AtMost(_) => a.0.total_cmp(&b.0),
            });
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
    /// Returns the value of the sun that is seen while it counts, `[day of the rule]`.
    pub fn value(&self, seen: &[SunSeen]) -> RuleValue {
        let of = |set: fn(&SunSeen) -> &Spells| {
            let minutes: Vec<f64> = seen.iter().map(|day| self.minutes(set(day))).collect();
            self.together(&minutes)
        };
        RuleValue { value: of(|day| &day.seen), low: of(|day| &day.sure), high: of(|day| &day.possible) }
    }

    /// Returns the minutes of a day that the rule counts.
    fn minutes(&self, spells: &Spells) -> f64 {
        match (self.rule.measure, self.rule.least_spell_min) {
            (RuleMeasure::LongestSpell, _) => spells.longest_min(),
            (_, least) if least > 0.0 => spells.lasting(least).minutes(),
            _ => spells.minutes(),
        }
    }

    fn together(&self, minutes: &[f64]) -> f64 {
        let (sum, count) = (minutes.iter().sum::<f64>(), minutes.len().max(1) as f64);
        let least = || minutes.iter().copied().reduce(f64::min).unwrap_or_default();
        let most = || minutes.iter().copied().fold(0.0, f64::max);
        let joined = match (self.rule.days, self.rule.threshold) {
            (DaysTogether::Each, Threshold::AtLeast(_)) | (DaysTogether::Any, Threshold::AtMost(_)) => least(),
            (DaysTogether::Any, Threshold::AtLeast(_)) | (DaysTogether::Each, Threshold::AtMost(_)) => most(),
            (DaysTogether::Mean, _) => sum / count,
            (DaysTogether::Sum, _) => sum,
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

    /// 120 minutes that may be 119 to 121 are close to a threshold of 120, meet one of 119 and
    /// break one of 121.5; they are close to at most 119, meet at most 121 and break at most 118.
    /// Half of an area reaches the lower value of its better parts of 30 and 20 %, a tenth of it
    /// the value of the best part; six tenths of it do not exceed the middle value.
    #[test]
    fn values_within_their_uncertainty_are_close() {
        let value = RuleValue { value: 120.0, low: 119.0, high: 121.0 };
        assert_eq!(
            (
                value.verdict(Threshold::AtLeast(120.0)),
                value.verdict(Threshold::AtLeast(119.0)),
                value.verdict(Threshold::AtLeast(121.5))
            ),
            (Verdict::Close, Verdict::Met, Verdict::Broken)
        );
        assert_eq!(RuleValue::certain(120.0).verdict(Threshold::AtLeast(120.0)), Verdict::Met);
        let most = [119.0, 121.0, 118.0].map(|most| value.verdict(Threshold::AtMost(most)));
        assert_eq!(most, [Verdict::Close, Verdict::Met, Verdict::Broken]);
        assert_eq!(value.uncertain(), 1.0);
        let parts = [(0.5, 10.0), (0.3, 200.0), (0.2, 130.0)].map(|(share, value)| (share, RuleValue::certain(value)));
        let reached = |share| RuleValue::reached_on(share, Threshold::AtLeast(0.0), &parts).value;
        assert_eq!((reached(0.5), reached(0.1), reached(0.51), reached(1.0)), (130.0, 200.0, 10.0, 10.0));
        assert_eq!(RuleValue::reached_on(0.6, Threshold::AtMost(0.0), &parts).value, 130.0);
    }
}
