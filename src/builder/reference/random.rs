//! Random numbers of paths and samples. In: a seed. Out: numbers in [0, 1), numbers spread below a
//! limit.

use heliotile_core::hemisphere::{mix, unit};

/// Number of low-discrepancy numbers of a path, spread evenly over all paths of a batch: two for
/// its first direction, three for the sun that its receiver sees.
pub(super) const EVEN: usize = 5;

/// Sequence of independent numbers.
pub(super) struct Random {
    seed: u64,
    drawn: u64,
}

impl Random {
    pub fn new(seed: u64) -> Self {
        Random { seed, drawn: 0 }
    }

    pub fn next(&mut self) -> f64 {
        self.drawn += 1;
        unit(mix(self.seed, self.drawn))
    }

    pub fn many<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.next())
    }
}

/// Returns point i of the sequence of Roberts (2018, "The unreasonable effectiveness of quasirandom
/// sequences"), shifted.
pub(super) fn even(i: usize, shift: &[f64; EVEN]) -> [f64; EVEN] {
    // The real root of x^6 = x + 1.
    const ROOT: f64 = 1.134_724_138_401_519_4;
    let mut step = 1.0;
    shift.map(|shift| {
        step /= ROOT;
        (shift + i as f64 * step).fract()
    })
}

/// Returns `count` numbers below `limit`, one at random from each of as many equal parts; all
/// numbers if there are fewer.
pub fn spread(limit: usize, count: usize, seed: u64) -> Vec<usize> {
    let count = count.min(limit);
    let mut random = Random::new(mix(seed, 0));
    let number = |i: usize| ((i as f64 + random.next()) * limit as f64 / count as f64) as usize;
    (0..count).map(number).map(|number| number.min(limit - 1)).collect()
}
