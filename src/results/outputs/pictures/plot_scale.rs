//! An axis of a picture. In: the values along it. Out: a range that holds them all, round ticks, and where a value stands.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, KeyPointWeight, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;

/// Differences of larger numbers overflow.
const LARGEST: f64 = 1e300;

/// Logarithmic ticks within a decade, the most first.
const WITHIN: [&[f64]; 3] = [&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0], &[1.0, 2.0, 5.0], &[1.0]];

/// Round steps from 0 to a round number that is not below a length: at most `most` of them, each 1, 2, 2.5 or 5 times a power of ten. A length
/// that is no positive number counts as 1.
pub fn round_steps(length: f64, most: usize) -> Vec<f64> {
    let length = if length > 0.0 && length <= LARGEST { length } else { 1.0 };
    let least = length / most.max(1) as f64;
    let power = 10_f64.powf(least.log10().floor());
    let step =
        [1.0, 2.0, 2.5, 5.0].into_iter().find(|step| step * power >= least * (1.0 - 1e-9)).unwrap_or(10.0) * power;
    let count = (length / step - 1e-9).ceil().max(1.0) as usize;
    // Told by few figures: 3 times 0.1 is not 0.30000000000000004.
    let tidy = |value: f64| format!("{value:.6e}").parse().unwrap_or(value);
    (0..=count).map(|i| tidy(step * i as f64)).collect()
}

/// An axis from `low` to `high`: values, or their decimal logarithms.
#[derive(Clone, Debug)]
pub struct Scale {
    low: f64,
    high: f64,
    log: bool,
}

impl Scale {
    /// Whether an axis can hold a value.
    pub fn holds(value: f64, log: bool) -> bool {
        value.abs() <= LARGEST && (value > 0.0 || !log)
    }

    /// The axis of values that it [holds](Scale::holds); of none, 0 to 1 or 1 to 10.
    pub fn of(values: impl Iterator<Item = f64>, log: bool) -> Self {
        let along = values.map(|v| if log { v.log10() } else { v });
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let (spread, size) = (high - low, low.abs().max(high.abs()));
        let (low, high) = if low > high {
            (0.0, 1.0)
        } else if spread <= 1e-9 * size || spread == 0.0 {
            // One value stands in the middle.
            let around = if log { 0.3 } else { size * 0.1 };
            let around = if around > 0.0 { around } else { 1.0 };
            (low - around, high + around)
        } else if !log && low >= 0.0 && low <= spread {
            // An axis that nearly begins at 0 does.
            (0.0, high + 0.05 * spread)
        } else {
            (low - 0.05 * spread, high + 0.05 * spread)
        };
        Scale { low, high, log }
    }

    /// Share of the axis below a value.
    pub fn share(&self, value: f64) -> f64 {
        let along = if self.log { value.log10() } else { value };
        (along - self.low) / (self.high - self.low)
    }

    /// At most so many round values, rising.
    pub fn ticks(&self, most: usize) -> Vec<f64> {
        if !self.log {
            return RangedCoordf64::from(self.low..self.high).key_points(most);
        }
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        let decades = |step: usize, within: &'static [f64]| -> Vec<f64> {
            let all = (first..=last).filter(|d| d.rem_euclid(step as i32) == 0);
            let all = all.flat_map(|d| within.iter().map(move |m| m * 10_f64.powi(d)));
            all.filter(|v| (self.low..=self.high).contains(&v.log10())).collect()
        };
        let sets = WITHIN.into_iter().map(|within| decades(1, within));
        let sparse = (2..).map(|step| decades(step, WITHIN[2]));
        let ticks = sets.chain(sparse).find(|ticks| ticks.len() <= most.max(1)).unwrap_or_default();
        if ticks.len() < 2 {
            let Range { start, end } = self.range();
            return RangedCoordf64::from(start..end).key_points(most);
        }
        ticks
    }

    /// A tick in plain figures: 0.1, 1, 10; powers of ten only where these would be long.
    pub fn plain(&self, tick: f64) -> String {
        let digits = format!("{tick:.8e}").parse::<f64>().unwrap_or(tick);
        match digits.abs() {
            // What is left of a difference that should be zero.
            _ if !self.log && digits.abs() < 1e-9 * (self.high - self.low) => "0".into(),
            1e-6..1e9 => digits.to_string(),
            _ => format!("{digits:e}"),
        }
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        first + (self.share(*value) * f64::from(last - first)).round() as i32
    }

    /// Lines without words only stand within decades.
    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match hint.weight() {
            KeyPointWeight::Bold => self.ticks(hint.max_num_points()),
            KeyPointWeight::Any if self.log && self.high - self.low < 7.0 => self.ticks(70),
            KeyPointWeight::Any => Vec::new(),
        }
    }

    fn range(&self) -> Range<f64> {
        let value = |along: f64| if self.log { 10_f64.powf(along) } else { along };
        value(self.low)..value(self.high)
    }
}

impl ValueFormatter<f64> for Scale {
    fn format_ext(&self, value: &f64) -> String {
        self.plain(*value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(values: &[f64], log: bool, most: usize) -> Vec<String> {
        let scale = Scale::of(values.iter().copied(), log);
        scale.ticks(most).into_iter().map(|tick| scale.plain(tick)).collect()
    }

    /// Ticks of 5 ranges are plain and round: decades of a logarithmic axis, 1-2-5 of a short one, linear steps within a decade.
    #[test]
    fn round_ticks() {
        assert_eq!(words(&[0.02, 150.0], true, 6), ["0.1", "1", "10", "100"]);
        assert_eq!(words(&[256.0, 4096.0], true, 6), ["500", "1000", "2000"]);
        assert_eq!(words(&[3.1, 3.9], true, 5), ["3.2", "3.4", "3.6", "3.8"]);
        assert_eq!(words(&[1e-5, 1e7], true, 5), ["0.001", "1", "1000", "1000000"]);
        assert_eq!(words(&[-0.3, 0.3], false, 7), ["-0.3", "-0.2", "-0.1", "0", "0.1", "0.2", "0.3"]);
    }

    /// Steps to 5 lengths end at or above them, and 0, NaN and infinity count as 1.
    #[test]
    fn round_tops() {
        assert_eq!(round_steps(1876.0, 5), [0.0, 500.0, 1000.0, 1500.0, 2000.0]);
        assert_eq!(round_steps(0.28, 5), [0.0, 0.1, 0.2, 0.3]);
        assert_eq!(round_steps(10.0, 4), [0.0, 2.5, 5.0, 7.5, 10.0]);
        assert_eq!(round_steps(1.0, 1), [0.0, 1.0]);
        assert_eq!(round_steps(3e-9, 3), [0.0, 1e-9, 2e-9, 3e-9]);
        for odd in [0.0, -5.0, f64::NAN, f64::INFINITY] {
            assert_eq!(round_steps(odd, 2), [0.0, 0.5, 1.0]);
        }
    }

    /// No values, one, and ranges from 1e-300 to 1e300 give 1 to 8 ticks, and each value stands between 0 and 1.
    #[test]
    fn any_values() {
        let sets: [&[f64]; 6] = [&[], &[5.0], &[1e-300, 1e300], &[1e15, 1e15 + 1.0], &[1e-300, 2e-300], &[7e300]];
        for (values, log) in sets.into_iter().flat_map(|values| [(values, false), (values, true)]) {
            let values: Vec<f64> = values.iter().copied().filter(|v| Scale::holds(*v, log)).collect();
            let scale = Scale::of(values.iter().copied(), log);
            let ticks = scale.ticks(8);
            assert!((1..=8).contains(&ticks.len()), "{values:?}: {ticks:?}");
            assert!(values.iter().all(|v| (0.0..=1.0).contains(&scale.share(*v))), "{values:?}: {scale:?}");
        }
    }
}
