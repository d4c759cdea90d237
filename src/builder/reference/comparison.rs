//! Comparison of results with the reference path tracer. In: both, for random receivers and hours.
//! Out: bias, RMSE and the worst pair, with intervals.
//!
//! Where a shadow's edge passes, light of the sun is off by a hundred times as much as in other
//! hours, and few pairs cannot tell how often that is. Rays to the sun's disc alone tell it for far
//! more hours ([`SunErrors`]). The sun's difference S is a control variate of the total's T
//! (Hammersley and Handscomb 1964, "Monte Carlo Methods", section 5.5): the mean square of T is
//! mean(T^2 - S^2) over pairs plus mean(S^2) over all of these hours. T^2 - S^2 holds twice S times
//! the other differences, so the two may depend on each other.

use serde::Serialize;

use super::estimate::{PARTS, ReferenceLight};
use super::random::Random;
use heliotile_core::replay::components::Component;

/// Components of light that comes from the sun without a matt surface.
const OF_SUN: [Component; 2] = [Component::SunDirect, Component::SunMirrored];

/// Number of resamplings of the receivers behind an interval (Efron 1979, "Bootstrap methods").
const RESAMPLINGS: usize = 1000;

/// Share of resamplings on either side of an interval of 95 %.
const TAIL: f64 = 0.025;

/// Receiver under one condition.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// Number of the receiver in the sample.
    pub receiver: usize,
    /// Number of the condition.
    pub condition: usize,
    /// Results, W/m2: the six components and the total.
    pub result: [f64; PARTS],
    /// Irradiance from the reference path tracer.
    pub reference: ReferenceLight,
}

/// Estimate with an interval of 95 %.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ConfidenceInterval {
    /// Best estimate.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl ConfidenceInterval {
    /// Returns the estimate in another unit.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        ConfidenceInterval { value: self.value * factor, low: self.low * factor, high: self.high * factor }
    }
}

/// Deviation of a component or the total.
#[derive(Clone, Copy, Debug, Default)]
pub struct Deviation {
    /// Mean difference, W/m2: above 0 if results are too large.
    pub bias_w_m2: ConfidenceInterval,
    /// RMSE, W/m2. The noise of the path tracer is subtracted, so that the number of paths does not
    /// matter.
    pub rmse_w_m2: ConfidenceInterval,
    /// Pair with the largest difference beyond noise.
    pub worst: Option<Pair>,
}

/// Sums over hours of one receiver.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: f64,
    difference: f64,
    /// Sum of squared differences, less the squared standard errors.
    square: f64,
}

impl Sums {
    /// Returns the sums of one hour, from a difference and the standard error of the path tracer.
    fn new(difference: f64, error: f64) -> Self {
        Sums { count: 1.0, difference, square: difference * difference - error * error }
    }

    fn plus(self, other: Sums) -> Self {
        Sums {
            count: self.count + other.count,
            difference: self.difference + other.difference,
            square: self.square + other.square,
        }
    }

    fn means(self) -> [f64; 2] {
        [self.difference, self.square].map(|sum| sum / self.count.max(1.0))
    }
}

/// Errors of a receiver's light of the sun under all conditions, or far more of them than its pairs
/// hold.
#[derive(Clone, Copy, Debug)]
pub struct SunErrors {
    receiver: usize,
    /// Sums in the order of [`OF_SUN`].
    sums: [Sums; OF_SUN.len()],
}

impl SunErrors {
    /// Creates the errors from a receiver's number (as [`Pair::receiver`]), its results and the
    /// irradiance of the sun from the path tracer.
    pub fn new(receiver: usize, hours: impl Iterator<Item = ([f64; PARTS], ReferenceLight)>) -> Self {
        let mut sums = [Sums::default(); OF_SUN.len()];
        for (result, reference) in hours {
            let here = sun_sums(&result, &reference);
            sums = std::array::from_fn(|i| sums[i].plus(here[i]));
        }
        SunErrors { receiver, sums }
    }
}

fn sun_sums(result: &[f64; PARTS], reference: &ReferenceLight) -> [Sums; OF_SUN.len()] {
    OF_SUN
        .map(|component| component as usize)
        .map(|part| Sums::new(result[part] - reference.mean[part], reference.error[part]))
}

/// Returns the deviation of one part of pairs, which are in the order of their receivers. `suns`
/// are those of all receivers in the same order, or empty; then only pairs tell of the sun.
pub fn deviation(pairs: &[Pair], suns: &[SunErrors], part: usize) -> Deviation {
    let held = OF_SUN.map(|component| [component, Component::Total].map(|of| of as usize).contains(&part));
    let difference = |pair: &Pair| (off(pair, part), pair.reference.error[part]);
    let [bias_w_m2, rmse_w_m2] = bias_and_rmse(pairs, suns, held, difference, part as u64);
    let beyond_noise = |pair: &Pair| off(pair, part).abs() - 2.0 * pair.reference.error[part];
    let worst = pairs.iter().max_by(|a, b| beyond_noise(a).total_cmp(&beyond_noise(b))).copied();
    Deviation { bias_w_m2, rmse_w_m2, worst }
}

/// Returns the RMSE of any difference of pairs, W/m2, from each pair's difference and the standard
/// error of the path tracer. With `suns`, as for [`deviation`], the difference must hold all of
/// `OF_SUN`.
pub fn rmse_interval(
    pairs: &[Pair],
    suns: &[SunErrors],
    difference: impl Fn(&Pair) -> (f64, f64),
) -> ConfidenceInterval {
    bias_and_rmse(pairs, suns, [true; OF_SUN.len()], difference, PARTS as u64)[1]
}

/// Returns mean and RMSE of differences with standard errors that hold those of some of [`OF_SUN`].
/// The seed draws the resamplings.
fn bias_and_rmse(
    pairs: &[Pair],
    suns: &[SunErrors],
    held: [bool; OF_SUN.len()],
    difference: impl Fn(&Pair) -> (f64, f64),
    seed: u64,
) -> [ConfidenceInterval; 2] {
    let sun_of = |sums: [Sums; OF_SUN.len()]| {
        let held = sums.into_iter().zip(held).filter(|(_, held)| *held).map(|(sums, _)| sums);
        Sums { count: sums[0].count, ..held.fold(Sums::default(), Sums::plus) }
    };
    // Sums over the pairs of a receiver, without the sun, and over all hours that tell of its sun.
    let of_receiver = |pairs: &[Pair]| {
        let sun = suns.binary_search_by_key(&pairs[0].receiver, |sun| sun.receiver).ok().map(|at| suns[at]);
        let mut rest = Sums::default();
        for pair in pairs {
            let (difference, error) = difference(pair);
            rest = rest.plus(Sums::new(difference, error));
            if sun.is_some() {
                let sun = sun_of(sun_sums(&pair.result, &pair.reference));
                rest.difference -= sun.difference;
                rest.square -= sun.square;
            }
        }
        [rest, sun.map_or(Sums::default(), |sun| sun_of(sun.sums))]
    };
    let receivers: Vec<[Sums; 2]> = pairs.chunk_by(|a, b| a.receiver == b.receiver).map(of_receiver).collect();
    let figures = |sums: &mut dyn Iterator<Item = [Sums; 2]>| {
        let add = |a: [Sums; 2], b: [Sums; 2]| [a[0].plus(b[0]), a[1].plus(b[1])];
        let [rest, sun] = sums.fold([Sums::default(); 2], add).map(Sums::means);
        [rest[0] + sun[0], (rest[1] + sun[1]).max(0.0).sqrt()]
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
        ConfidenceInterval { value: values[figure], low: at(TAIL), high: at(1.0 - TAIL) }
    };
    [known(0), known(1)]
}

/// Returns the difference between a result and the path tracer.
pub fn off(pair: &Pair, part: usize) -> f64 {
    pair.result[part] - pair.reference.mean[part]
}

/// Returns the mean total from the path tracer, W/m2.
pub fn mean_w_m2(pairs: &[Pair]) -> f64 {
    pairs.iter().map(|pair| pair.reference.mean[PARTS - 1]).sum::<f64>() / pairs.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 200 receivers with 4 hours each have results with a bias of 1 and a scatter of 2 W/m2, seen
    /// through noise of 3. The intervals hold bias 1 and RMSE sqrt(5) and are narrower than 1, and
    /// the one result that is 50 off is the worst.
    #[test]
    fn noise_is_taken_off() {
        let mut random = Random::new(9);
        // Sums of twelve even numbers are nearly normal (variance 1).
        let mut normal = || (0..12).map(|_| random.next()).sum::<f64>() - 6.0;
        let mut pairs = Vec::new();
        for receiver in 0..200 {
            for condition in 0..4 {
                let mut reference = ReferenceLight { error: [3.0; PARTS], ..ReferenceLight::default() };
                reference.mean = [300.0 + 3.0 * normal(); PARTS];
                pairs.push(Pair { receiver, condition, result: [301.0 + 2.0 * normal(); PARTS], reference });
            }
        }
        let found = deviation(&pairs, &[], 6);
        let holds = |known: ConfidenceInterval, value: f64| {
            known.low < value && value < known.high && known.high - known.low < 1.0
        };
        assert!(holds(found.bias_w_m2, 1.0) && holds(found.rmse_w_m2, 5.0_f64.sqrt()), "{found:?}");
        assert!((mean_w_m2(&pairs) - 300.0).abs() < 0.5);
        pairs[77].result[6] += 50.0;
        assert_eq!(deviation(&pairs, &[], 6).worst.map(|worst| (worst.receiver, worst.condition)), Some((19, 1)));
        assert_eq!(deviation(&[], &[], 6).rmse_w_m2, ConfidenceInterval::default());
    }

    /// The sun of 32 receivers is off by 96 W/m2 in one of 256 hours, and all of their other light
    /// by 2 W/m2, seen through noise of 3 W/m2 in pairs and of 5 in all hours: bias 2.375, mean
    /// square 4 + (2 * 2 * 96 + 96^2) / 256 = 41.5. Pairs are every 16th hour, from each of the
    /// first 16. They alone give an RMSE that is 3 times too small, or in one of 16 cases too
    /// large. With the suns of all hours it is right within a factor of 1.25, the bias is right
    /// within 1e-9 in all 16 cases, and so is the mean square in the mean of the cases.
    #[test]
    fn the_sun_of_all_hours_shows_rare_errors() {
        const RARE: usize = 7;
        let (direct, total) = (Component::SunDirect as usize, Component::Total as usize);
        let hour = |receiver: usize, condition: usize, noise: f64| {
            let sun = if condition == RARE { 96.0 } else { 0.0 };
            let noise = if receiver.is_multiple_of(2) { noise } else { -noise };
            let (mut result, mut reference) = ([0.0; PARTS], ReferenceLight::default());
            (result[direct], result[total]) = (500.0 + sun, 702.0 + sun);
            for (part, mean) in [(direct, 500.0), (total, 700.0)] {
                (reference.mean[part], reference.error[part]) = (mean + noise, noise.abs());
            }
            (result, reference)
        };
        let suns: Vec<SunErrors> =
            (0..32).map(|receiver| SunErrors::new(receiver, (0..256).map(|i| hour(receiver, i, 5.0)))).collect();
        let mut squares = 0.0;
        for first in 0..16 {
            let pair = |i: usize| {
                let (receiver, condition) = (i / 16, first + i % 16 * 16);
                let (result, reference) = hour(receiver, condition, 3.0);
                Pair { receiver, condition, result, reference }
            };
            let pairs: Vec<Pair> = (0..32 * 16).map(pair).collect();
            let (alone, with_suns) = (deviation(&pairs, &[], total), deviation(&pairs, &suns, total));
            let truth = 41.5_f64.sqrt();
            let factor = |found: Deviation| (found.rmse_w_m2.value / truth).max(truth / found.rmse_w_m2.value);
            assert!(factor(alone) > 3.0 && factor(with_suns) < 1.25, "{alone:?} {with_suns:?}");
            assert!((with_suns.bias_w_m2.value - 2.375).abs() < 1e-9);
            assert!((deviation(&pairs, &suns, direct).rmse_w_m2.value - 6.0).abs() < 1e-9);
            assert_eq!(deviation(&pairs, &suns, 1).rmse_w_m2.value, 0.0);
            squares += with_suns.rmse_w_m2.value.powi(2) / 16.0;
        }
        assert!((squares - 41.5).abs() < 1e-9, "{squares}");
    }
}
