//! Axis of a chart. In: the values along it. Out: a range that holds them all, round ticks, and the
//! position of a value.

/// Largest absolute value on an axis: differences of larger numbers overflow. Below `SMALLEST`
/// fractions vanish.
const LARGEST: f64 = 1e300;
const SMALLEST: f64 = 1e-300;

/// Logarithmic ticks within a decade, the densest first.
const WITHIN: [&[f64]; 3] = [&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0], &[1.0, 2.0, 5.0], &[1.0]];

/// Returns round steps from 0 to a round number that is at least `length`: at most `most` steps,
/// each 1, 2, 2.5 or 5 times a power of ten. A length that is no positive number counts as 1.
pub fn round_steps(length: f64, most: usize) -> Vec<f64> {
    let length = if (SMALLEST..=LARGEST).contains(&length) { length } else { 1.0 };
    let step = round_step(length, most);
    let count = (length / step - 1e-9).ceil().max(1.0) as usize;
    (0..=count).map(|i| tidy(step * i as f64)).collect()
}

/// Returns about `most` round steps from a number at or below `low` to one at or above `high`.
/// Equal numbers lie in the middle of steps.
pub fn round_range(low: f64, high: f64, most: usize) -> Vec<f64> {
    let is_range = high - low > SMALLEST && low.abs().max(high.abs()) <= LARGEST;
    let (low, high) =
        if is_range { (low, high) } else { (high.clamp(-LARGEST, LARGEST) - 0.5, high.clamp(-LARGEST, LARGEST) + 0.5) };
    let step = round_step(high - low, most);
    let (first, last) = ((low / step + 1e-9).floor(), (high / step - 1e-9).ceil());
    (0..=(last - first) as usize).map(|i| tidy(step * (first + i as f64))).collect()
}

/// Returns the smallest round number that fits into `length` at most `most` times.
fn round_step(length: f64, most: usize) -> f64 {
    let least = length / most.max(1) as f64;
    let power = 10_f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 2.5, 5.0].map(|step| step * power);
    steps.into_iter().find(|step| *step >= least * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

/// Removes rounding noise: 3 times 0.1 becomes 0.3, not 0.30000000000000004.
fn tidy(value: f64) -> f64 {
    format!("{value:.8e}").parse().unwrap_or(value)
}

/// Returns a tick as plain digits, such as 0.1, 1 or 10; in powers of ten only if plain digits were
/// long.
pub fn words(tick: f64) -> String {
    if tick == 0.0 || (1e-6..1e9).contains(&tick.abs()) { tick.to_string() } else { format!("{tick:e}") }
}

/// Returns a unit as pictures write it; numbers without a unit have an empty one.
pub fn printed(unit: &str) -> String {
    if unit == "1" {
        return String::new();
    }
    unit.replace("m2", "m\u{b2}").replace("deg", "\u{b0}").replace("umol", "\u{b5}mol")
}

/// Returns a title with its unit, if it has one.
pub fn titled(title: &str, unit: &str) -> String {
    match printed(unit) {
        unit if unit.is_empty() => title.to_owned(),
        unit => format!("{title}, {unit}"),
    }
}

/// Axis from `low` to `high`: values, or their decimal logarithms.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    low: f64,
    high: f64,
    log: bool,
}

impl Scale {
    /// Returns true if an axis can hold a value.
    pub fn holds(value: f64, log: bool) -> bool {
        value.abs() <= LARGEST && (value >= SMALLEST || !log)
    }

    /// Returns the axis of values that it [holds](Scale::holds); without values, 0 to 1 or 1 to 10.
    pub fn new(values: impl Iterator<Item = f64>, log: bool) -> Self {
        let along = values.map(|v| if log { v.log10() } else { v });
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let (spread, size) = (high - low, low.abs().max(high.abs()));
        let (low, high) = if low > high {
            (0.0, 1.0)
        } else if spread <= (1e-7 * size).max(SMALLEST) {
            // A single value is placed in the middle.
            let around = if log { 0.3 } else { size * 0.1 };
            let around = if around > SMALLEST { around } else { 1.0 };
            (low - around, high + around)
        } else if !log && low >= 0.0 && low <= spread {
            // An axis that begins close to 0 begins at 0.
            (0.0, high + 0.05 * spread)
        } else {
            (low - 0.05 * spread, high + 0.05 * spread)
        };
        Scale { low, high, log }
    }

    /// Returns the share of the axis below a value.
    pub fn share(&self, value: f64) -> f64 {
        let along = if self.log { value.log10() } else { value };
        (along - self.low) / (self.high - self.low)
    }

    /// Returns at most `most` round values, rising: their positions on the axis, and their words.
    pub fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        let sets = WITHIN.into_iter().map(|within| self.decades(1, within));
        let sparse = (2..).map(|step| self.decades(step, WITHIN[2]));
        let found = if self.log { sets.chain(sparse).find(|ticks| ticks.len() <= most.max(1)) } else { None };
        // An axis of less than a decade has linear steps.
        let ticks = found.filter(|ticks| ticks.len() > 1).unwrap_or_else(|| self.steps(most));
        ticks.into_iter().map(|tick| (self.share(tick), words(tick))).collect()
    }

    /// Returns the positions of lines without words, within decades.
    pub fn minor_ticks(&self) -> Vec<f64> {
        let few = self.log && self.high - self.low < 7.0;
        let ticks = if few { self.decades(1, WITHIN[0]) } else { Vec::new() };
        ticks.into_iter().map(|tick| self.share(tick)).collect()
    }

    /// Returns the multiples `within` of every power of ten whose exponent is divisible by `step`.
    fn decades(&self, step: i32, within: &[f64]) -> Vec<f64> {
        let powers = (self.low.floor() as i32..=self.high.ceil() as i32).filter(|power| power % step == 0);
        let all = powers.flat_map(|power| within.iter().map(move |m| tidy(m * 10_f64.powi(power))));
        all.filter(|tick| (self.low..=self.high).contains(&tick.log10())).collect()
    }

    fn steps(&self, most: usize) -> Vec<f64> {
        let [low, high] = [self.low, self.high].map(|end| if self.log { 10_f64.powf(end) } else { end });
        let step = round_step(high - low, most.saturating_sub(1));
        let (first, last) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
        (first..=last).map(|i| tidy(step * i as f64)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(values: &[f64], log: bool, most: usize) -> Vec<String> {
        Scale::new(values.iter().copied(), log).ticks(most).into_iter().map(|(_, words)| words).collect()
    }

    /// Ticks of 7 ranges are plain and round: decades of a logarithmic axis, 1-2-5 of a short one,
    /// linear steps within a decade, 9 digits of a narrow one.
    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(words(&[0.02, 150.0], true, 6), ["0.1", "1", "10", "100"]);
        assert_eq!(words(&[256.0, 4096.0], true, 6), ["500", "1000", "2000"]);
        assert_eq!(words(&[3.1, 3.9], true, 6), ["3.2", "3.4", "3.6", "3.8"]);
        assert_eq!(words(&[1e-5, 1e7], true, 5), ["0.001", "1", "1000", "1000000"]);
        assert_eq!(words(&[-0.3, 0.3], false, 8), ["-0.3", "-0.2", "-0.1", "0", "0.1", "0.2", "0.3"]);
        assert_eq!(words(&[1e8, 1e8 + 20.0], false, 4), ["100000000", "100000010", "100000020"]);
        assert_eq!(words(&[7.0, 7.0], false, 4), ["6.5", "7", "7.5"]);
    }

    /// Steps to 5 lengths end at or above them; 0, a negative number, NaN, infinity and 5e-324
    /// count as 1.
    #[test]
    fn axes_end_at_or_above_the_largest_value() {
        assert_eq!(round_steps(1876.0, 5), [0.0, 500.0, 1000.0, 1500.0, 2000.0]);
        assert_eq!(round_steps(0.28, 5), [0.0, 0.1, 0.2, 0.3]);
        assert_eq!(round_steps(10.0, 4), [0.0, 2.5, 5.0, 7.5, 10.0]);
        assert_eq!(round_steps(1.0, 1), [0.0, 1.0]);
        assert_eq!(round_steps(3e-9, 3), [0.0, 1e-9, 2e-9, 3e-9]);
        assert_eq!(round_range(21.7, 34.2, 5), [20.0, 22.5, 25.0, 27.5, 30.0, 32.5, 35.0]);
        assert_eq!(round_range(-3.2, 4.0, 5), [-4.0, -2.0, 0.0, 2.0, 4.0]);
        assert_eq!(round_range(20.0, 20.0, 5), [19.4, 19.6, 19.8, 20.0, 20.2, 20.4, 20.6]);
        for odd in [0.0, -5.0, f64::NAN, f64::INFINITY, 5e-324] {
            assert_eq!(round_steps(odd, 2), [0.0, 0.5, 1.0]);
        }
    }

    /// Axes without values, with one value, and with ranges from 5e-324 to 1e300 have 1 to 8 ticks,
    /// and each value and tick lies between 0 and 1.
    #[test]
    fn any_range_has_1_to_8_ticks() {
        let sets: [&[f64]; 8] = [
            &[],
            &[5.0],
            &[1e-300, 1e300],
            &[-1e300, 1e300],
            &[1e15, 1e15 + 1.0],
            &[5e-324, 2e-300],
            &[0.0, 5e-324],
            &[7e300],
        ];
        for (values, log) in sets.into_iter().flat_map(|values| [(values, false), (values, true)]) {
            let values: Vec<f64> = values.iter().copied().filter(|v| Scale::holds(*v, log)).collect();
            let scale = Scale::new(values.iter().copied(), log);
            let ticks = scale.ticks(8);
            assert!((1..=8).contains(&ticks.len()), "{values:?}: {ticks:?}");
            let shares = values.iter().map(|value| scale.share(*value)).chain(ticks.iter().map(|tick| tick.0));
            assert!(shares.into_iter().all(|share| (-1e-6..1.000001).contains(&share)), "{values:?}: {scale:?}");
        }
    }
}
