//! How results differ from what the judge finds. In: both, for random receivers and hours. Out: bias, RMSE and the worst of them, with what is
//! known of each.

use super::estimate::{Judged, PARTS};
use super::random::Random;

/// Resamplings of the receivers that an interval rests on (Efron 1979, "Bootstrap methods").
const RESAMPLINGS: usize = 1000;

/// Share of resamplings on either side of an interval of 95 %.
const TAIL: f64 = 0.025;

/// A receiver under one condition.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// Number of the receiver among those that were looked at.
    pub receiver: usize,
    /// Number of the condition.
    pub condition: usize,
    /// W/m2: the six components and the total.
    pub result: [f64; PARTS],
    /// What the judge says.
    pub judged: Judged,
}

/// A number that is known so well: an interval of 95 %.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// The best guess.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Known {
    /// In another unit.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Known { value: self.value * factor, low: self.low * factor, high: self.high * factor }
    }
}

/// What was found of a component or the total.
#[derive(Clone, Copy, Debug, Default)]
pub struct Deviation {
    /// Mean difference, W/m2: above 0 if results are too large.
    pub bias_w_m2: Known,
    /// RMSE, W/m2. The judge's own noise is taken off, so that it comes out right whatever the number of paths.
    pub rmse_w_m2: Known,
    /// The pair that is farthest off, noise aside.
    pub worst: Option<Pair>,
}

/// Sums over the pairs of one receiver.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: f64,
    difference: f64,
    /// Of squared differences, less the squared standard errors.
    square: f64,
}

/// Finds out about one part of pairs, which are in the order of their receivers.
pub fn deviation(pairs: &[Pair], part: usize) -> Deviation {
    let [bias_w_m2, rmse_w_m2] = bias_and_rmse(pairs, |pair| (off(pair, part), pair.judged.error[part]), part as u64);
    let beyond_noise = |pair: &Pair| off(pair, part).abs() - 2.0 * pair.judged.error[part];
    let worst = pairs.iter().max_by(|a, b| beyond_noise(a).total_cmp(&beyond_noise(b))).copied();
    Deviation { bias_w_m2, rmse_w_m2, worst }
}

/// RMSE of any difference of pairs, W/m2, from each pair's difference and the standard error of what the judge found.
pub fn rmse_known(pairs: &[Pair], difference: impl Fn(&Pair) -> (f64, f64)) -> Known {
    bias_and_rmse(pairs, difference, PARTS as u64)[1]
}

/// Mean and RMSE of differences that are known with standard errors; the seed draws the resamplings.
fn bias_and_rmse(pairs: &[Pair], difference: impl Fn(&Pair) -> (f64, f64), seed: u64) -> [Known; 2] {
    let of_receiver = |pairs: &[Pair]| {
        let mut sums = Sums::default();
        for pair in pairs {
            let (difference, error) = difference(pair);
            sums.count += 1.0;
            sums.difference += difference;
            sums.square += difference * difference - error.powi(2);
        }
        sums
    };
    let receivers: Vec<Sums> = pairs.chunk_by(|a, b| a.receiver == b.receiver).map(of_receiver).collect();
    let figures = |sums: &mut dyn Iterator<Item = Sums>| {
        let add = |a: Sums, b: Sums| Sums {
            count: a.count + b.count,
            difference: a.difference + b.difference,
            square: a.square + b.square,
        };
        let all = sums.fold(Sums::default(), add);
        let count = all.count.max(1.0);
        [all.difference / count, (all.square / count).max(0.0).sqrt()]
    };
    let values = figures(&mut receivers.iter().copied());
    let mut random = Random::new(seed);
    let mut draw = || receivers[((random.next() * receivers.len() as f64) as usize).min(receivers.len() - 1)];
    let drawn: Vec<[f64; 2]> = match receivers.is_empty() {
        true => Vec::new(),
        false => (0..RESAMPLINGS).map(|_| figures(&mut (0..receivers.len()).map(|_| draw()))).collect(),
    };
    let known = |figure: usize| {
        let mut sorted: Vec<f64> = drawn.iter().map(|figures| figures[figure]).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(values[figure]);
        Known { value: values[figure], low: at(TAIL), high: at(1.0 - TAIL) }
    };
    [known(0), known(1)]
}

/// How far a result is off.
pub fn off(pair: &Pair, part: usize) -> f64 {
    pair.result[part] - pair.judged.mean[part]
}

/// Mean of the totals that the judge found, W/m2.
pub fn mean_w_m2(pairs: &[Pair]) -> f64 {
    pairs.iter().map(|pair| pair.judged.mean[PARTS - 1]).sum::<f64>() / pairs.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 200 receivers with 4 hours each whose results have a bias of 1 and scatter by 2 W/m2, seen through noise of 3, the intervals
    /// hold bias 1 and RMSE sqrt(5), are narrower than 1, and the one result that is 50 off is the worst.
    #[test]
    fn noise_is_taken_off() {
        let mut random = Random::new(9);
        // Sums of twelve even numbers are near normal (variance 1).
        let mut normal = || (0..12).map(|_| random.next()).sum::<f64>() - 6.0;
        let mut pairs = Vec::new();
        for receiver in 0..200 {
            for condition in 0..4 {
                let mut judged = Judged { error: [3.0; PARTS], ..Judged::default() };
                judged.mean = [300.0 + 3.0 * normal(); PARTS];
                pairs.push(Pair { receiver, condition, result: [301.0 + 2.0 * normal(); PARTS], judged });
            }
        }
        let found = deviation(&pairs, 6);
        let holds = |known: Known, value: f64| known.low < value && value < known.high && known.high - known.low < 1.0;
        assert!(holds(found.bias_w_m2, 1.0) && holds(found.rmse_w_m2, 5.0_f64.sqrt()), "{found:?}");
        assert!((mean_w_m2(&pairs) - 300.0).abs() < 0.5);
        pairs[77].result[6] += 50.0;
        assert_eq!(deviation(&pairs, 6).worst.map(|worst| (worst.receiver, worst.condition)), Some((19, 1)));
        assert_eq!(deviation(&[], 6).rmse_w_m2, Known::default());
    }
}
