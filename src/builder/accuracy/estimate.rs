//! Estimates of the error of every rung from a few trials. In: distances of trials from the finest
//! one, source by source. Out: an error for each rung, and the cheapest rungs that keep within a
//! target.
//!
//! Errors of two rungs are independent if their rays are, so the squared distance of rung k to the
//! finest one c is e_k^2 + e_c^2. The ratio e_c / e_k is taken from typical sites. It gives the
//! error of the finest trial from the next coarser one, then the errors of all others. Rungs that
//! were not tried get errors in proportion to typical ones.

use crate::accuracy::reference_sample::{SourcesFound, percent};
use crate::accuracy::trial::{ErrorSource, Irradiances, Trial};
use crate::settings::ladder::{BOUNCED_RUNGS, PATCH_RUNGS, Rungs, SEEN_RUNGS, SKY_RUNGS};

/// Typical RMSE of the hourly total by rungs of one ladder, percent of its mean, and CPU
/// milliseconds per receiver.
struct Typical {
    percent: &'static [f64],
    cost: &'static [f64],
}

/// Returns the typical curve of a source, rounded from trials on the sites of `tools/accuracy/run`
/// and a block of The Hague. Only ratios of its numbers count.
const fn typical(source: ErrorSource) -> Typical {
    match source {
        ErrorSource::Sky => {
            Typical { percent: &[4.2, 2.0, 0.58, 0.35, 0.33, 0.18], cost: &[1.0, 1.3, 1.9, 2.6, 2.9, 4.8] }
        }
        ErrorSource::Seen => Typical {
            percent: &[2.9, 1.3, 0.81, 0.56, 0.39, 0.33, 0.24, 0.17],
            cost: &[0.3, 1.1, 2.4, 4.7, 8.3, 12.5, 34.0, 130.0],
        },
        ErrorSource::Bounced => {
            Typical { percent: &[0.55, 0.42, 0.3, 0.17, 0.11, 0.08], cost: &[0.3, 0.5, 1.2, 4.0, 9.0, 25.0] }
        }
    }
}

/// Error by rung of one source, percent of the mean total.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// `[rung]`, from coarse to fine.
    pub percent: Vec<f64>,
}

impl Curve {
    /// Creates the curve from distances between trials and the finest one, as (rung, percent), and
    /// the finest trial's rung.
    pub fn through(source: ErrorSource, distances: &[(usize, f64)], finest: usize) -> Self {
        let typical = typical(source).percent;
        let others: Vec<(usize, f64)> = distances.iter().copied().filter(|d| d.0 != finest).collect();
        // Rungs with equal hit textures cast the same rays, so their distance does not show the
        // error of these rays.
        let mut known: Vec<(usize, f64)> = others.iter().copied().filter(|d| !same_rays(source, d.0, finest)).collect();
        if known.is_empty() {
            known = others;
        }
        known.sort_by_key(|d| d.0);
        // The next coarser trial shows how this site compares with a typical one.
        let next = known.iter().rev().find(|d| d.0 < finest).or(known.first());
        let scale = next.map_or(0.0, |&(rung, distance)| distance / typical[rung].hypot(typical[finest]));
        let of_finest = scale * typical[finest];
        let mut anchors: Vec<(usize, f64)> = known
            .into_iter()
            .map(|(rung, distance)| {
                let left = (distance * distance - of_finest * of_finest).max(0.0).sqrt();
                (rung, left.max(0.5 * scale * typical[rung]))
            })
            .collect();
        anchors.push((finest, of_finest));
        let percent = (0..typical.len())
            .map(|rung| {
                let nearest = anchors.iter().min_by_key(|a| (a.0.abs_diff(rung), usize::MAX - a.0));
                nearest.map_or(0.0, |&(at, error)| error * typical[rung] / typical[at])
            })
            .collect();
        Curve { percent }
    }

    /// Scales the curve to pass through a value at a rung. The scale is at least half, because
    /// noise may make the value found too small.
    fn pass_through(&mut self, source: ErrorSource, rung: usize, found: f64) {
        let here = self.percent[rung];
        if here > 0.0 {
            let scale = (found / here).max(0.5);
            self.percent.iter_mut().for_each(|percent| *percent *= scale);
        } else {
            // Trials that did not differ predicted no error.
            let typical = typical(source).percent;
            self.percent = typical.iter().map(|percent| found * percent / typical[rung]).collect();
        }
    }
}

/// Returns true if a receiver's rays are the same at two rungs of a source. Hit rays go through a
/// jittered point of each texel, which depends on the receiver and the side of the texture.
fn same_rays(source: ErrorSource, one: usize, other: usize) -> bool {
    let hit = |seen: usize| Rungs { seen, ..Rungs::FINEST }.settings().hit;
    source == ErrorSource::Seen && hit(one) == hit(other)
}

/// Errors of all ladders on one site, percent of the mean total.
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    /// Curves in the order of [`ErrorSource::ALL`].
    pub curves: [Curve; 3],
    /// `[rung]` of the sky patches: 145, 577, 2305.
    pub patches: [f64; PATCH_RUNGS],
    /// Error of reflected light in hours when the sun lights what receivers see, divided by that in
    /// all hours, both in W/m2.
    pub lit: f64,
}

impl Errors {
    /// Creates the errors from trials with their rungs, taking the finest one as the truth, and the
    /// errors of the sky patches.
    pub fn new(trials: &[(Rungs, Trial)], finest: Rungs, truth: &Trial, patches: [f64; PATCH_RUNGS]) -> Self {
        let mean = truth.light.mean();
        let curves = ErrorSource::ALL.map(|source| {
            let distance = |(rungs, trial): &(Rungs, Trial)| {
                (rung(*rungs, source), percent(trial.light.source_error(&truth.light, source).rmse, mean))
            };
            Curve::through(source, &trials.iter().map(distance).collect::<Vec<_>>(), rung(finest, source))
        });
        Errors { curves, patches, lit: 1.0 }
    }

    /// Replaces the predictions at some rungs by the errors that the reference path tracer found;
    /// other rungs follow in proportion.
    pub fn learn(&mut self, rungs: Rungs, found: &SourcesFound) {
        for source in ErrorSource::ALL {
            let patches = if source == ErrorSource::Sky { self.patches[rungs.patches] } else { 0.0 };
            let found = (found.percent[source as usize].powi(2) - patches * patches).max(0.0).sqrt();
            self.curves[source as usize].pass_through(source, rung(rungs, source), found);
        }
        let all = found.percent[ErrorSource::Seen as usize].hypot(found.percent[ErrorSource::Bounced as usize]);
        self.lit = if all > 0.0 { (found.lit_percent / all).max(1.0) } else { 1.0 };
    }

    /// Returns the error of a source at some rungs.
    pub fn at(&self, rungs: Rungs, source: ErrorSource) -> f64 {
        self.curves[source as usize].percent[rung(rungs, source)]
    }

    /// Returns the error of the total at some rungs: sources are independent.
    pub fn total(&self, rungs: Rungs) -> f64 {
        let squares = ErrorSource::ALL.map(|source| self.at(rungs, source).powi(2));
        (squares.iter().sum::<f64>() + self.patches[rungs.patches].powi(2)).sqrt()
    }

    /// Returns the error of reflected light in hours when the sun lights what receivers see,
    /// percent of the mean total of all hours.
    pub fn lit(&self, rungs: Rungs) -> f64 {
        self.lit * self.at(rungs, ErrorSource::Seen).hypot(self.at(rungs, ErrorSource::Bounced))
    }

    /// Returns the cheapest rungs that keep the total and reflected light within a target; if there
    /// are none, those that keep the total; if there are none, the finest ones. With `after`, rungs
    /// that missed the target, the result is nowhere coarser and somewhere finer.
    pub fn cheapest(&self, target_percent: f64, after: Option<Rungs>) -> Rungs {
        let of_total = |rungs: Rungs| self.total(rungs) <= target_percent;
        let both = self.cheapest_that(|rungs| of_total(rungs) && self.lit(rungs) <= target_percent, after);
        both.or_else(|| self.cheapest_that(of_total, after)).unwrap_or(Rungs::FINEST)
    }

    fn cheapest_that(&self, keeps: impl Fn(Rungs) -> bool, after: Option<Rungs>) -> Option<Rungs> {
        let mut best: Option<(f64, Rungs)> = None;
        for sky in 0..SKY_RUNGS {
            for seen in 0..SEEN_RUNGS {
                for bounced in 0..BOUNCED_RUNGS {
                    for patches in 0..PATCH_RUNGS {
                        let rungs = Rungs { sky, seen, bounced, patches };
                        let cost = cost(rungs);
                        let is_finer = after.is_none_or(|after| after != rungs && after.is_nowhere_finer(rungs));
                        if is_finer && keeps(rungs) && best.is_none_or(|b| cost < b.0) {
                            best = Some((cost, rungs));
                        }
                    }
                }
            }
        }
        best.map(|b| b.1)
    }
}

/// Returns the rung on the ladder of a source.
pub fn rung(rungs: Rungs, source: ErrorSource) -> usize {
    match source {
        ErrorSource::Sky => rungs.sky,
        ErrorSource::Seen => rungs.seen,
        ErrorSource::Bounced => rungs.bounced,
    }
}

/// Returns the typical CPU milliseconds of a receiver; sky patches cost little.
fn cost(rungs: Rungs) -> f64 {
    let traced = ErrorSource::ALL.map(|source| typical(source).cost[rung(rungs, source)]);
    traced.iter().sum::<f64>() + 0.05 * rungs.patches as f64
}

/// Returns the error of each number of sky patches, from irradiances of one archive; the last
/// number is the finest.
pub fn patch_errors(lights: &[Irradiances; PATCH_RUNGS]) -> [f64; PATCH_RUNGS] {
    let truth = &lights[PATCH_RUNGS - 1];
    let mut errors = lights.each_ref().map(|light| percent(light.total_error(truth).rmse, truth.mean()));
    // Four times as many patches are a quarter as large, and the error falls about as fast.
    errors[PATCH_RUNGS - 1] = errors[PATCH_RUNGS - 2] / 4.0;
    errors
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A site with twice the typical errors, tried at rungs 1, 2 and 4 of the sky, gets twice the
    /// typical error at all 6 rungs within 1e-9. Trials without any distance give no error.
    #[test]
    fn twice_the_typical_trials_give_twice_the_error() {
        let typical = typical(ErrorSource::Sky).percent;
        let distance = |rung: usize| (rung, 2.0 * typical[rung].hypot(typical[4]));
        let curve = Curve::through(ErrorSource::Sky, &[distance(1), distance(2)], 4);
        for (found, typical) in curve.percent.iter().zip(typical) {
            assert!((found - 2.0 * typical).abs() < 1e-9, "{found} {typical}");
        }
        let none = Curve::through(ErrorSource::Bounced, &[(1, 0.0), (2, 0.0)], 3);
        assert_eq!(none.percent.iter().sum::<f64>(), 0.0);
    }

    /// All 3 ladders have as many typical errors and costs as rungs, errors fall and costs rise. A
    /// typical site gets coarser rungs for 5 % than for 1 %, and the finest ones for 0.01 %.
    #[test]
    fn a_larger_error_allows_cheaper_rungs() {
        for (source, rungs) in ErrorSource::ALL.into_iter().zip([SKY_RUNGS, SEEN_RUNGS, BOUNCED_RUNGS]) {
            let typical = typical(source);
            assert_eq!((typical.percent.len(), typical.cost.len()), (rungs, rungs));
            assert!(typical.percent.is_sorted_by(|a, b| a > b) && typical.cost.is_sorted_by(|a, b| a < b));
        }
        let curves = ErrorSource::ALL.map(|s| Curve { percent: typical(s).percent.to_vec() });
        let errors = Errors { curves, patches: [0.27, 0.06, 0.01], lit: 1.0 };
        let (five, one) = (errors.cheapest(5.0, None), errors.cheapest(1.0, None));
        assert!(cost(five) < cost(one) && errors.total(one) <= 1.0 && errors.total(five) <= 5.0);
        assert!(errors.total(five) > 1.0);
        assert_eq!(errors.cheapest(0.01, None), Rungs::FINEST);
    }

    /// Rungs 5 and 6 of the seen cells cast the same 64 x 64 rays, so a distance of 0 between them
    /// is ignored. The error of rung 6 follows from rung 4, which casts other rays and lies 1 %
    /// apart.
    #[test]
    fn the_same_rays_say_nothing_of_each_other() {
        let typical = typical(ErrorSource::Seen).percent;
        let curve = Curve::through(ErrorSource::Seen, &[(4, 1.0), (5, 0.0)], 6);
        assert!((curve.percent[6] - typical[6] / typical[4].hypot(typical[6])).abs() < 1e-9, "{curve:?}");
        assert!(same_rays(ErrorSource::Seen, 5, 6) && !same_rays(ErrorSource::Seen, 4, 5));
        assert!(!same_rays(ErrorSource::Bounced, 3, 4));
    }

    /// The reference path tracer finds 1.2 % of one reflection where trials predicted nothing, and
    /// twice that in hours when the sun lights what is seen. The curve goes through 1.2 %, other
    /// sources keep at least half of their prediction, and a target of 2 % takes finer cells and
    /// nothing coarser.
    #[test]
    fn an_error_that_is_found_refines_its_source_only() {
        let mut curves = ErrorSource::ALL.map(|s| Curve { percent: typical(s).percent.to_vec() });
        curves[ErrorSource::Seen as usize].percent.fill(0.0);
        let mut errors = Errors { curves, patches: [0.27, 0.06, 0.01], lit: 1.0 };
        let tried = errors.cheapest(3.0, None);
        assert_eq!(tried.seen, 0);
        let sky = errors.at(tried, ErrorSource::Sky);
        errors.learn(tried, &SourcesFound { percent: [0.0, 1.2, 0.0], lit_percent: 2.4 });
        assert!((errors.at(tried, ErrorSource::Seen) - 1.2).abs() < 1e-12);
        assert!((errors.at(tried, ErrorSource::Sky) - sky / 2.0).abs() < 1e-12 && (errors.lit - 2.0).abs() < 1e-12);
        let again = errors.cheapest(2.0, Some(tried));
        assert!(again.seen > 0 && errors.lit(again) <= 2.0, "{again:?}");
        assert!(tried.is_nowhere_finer(again), "{tried:?} {again:?}");
    }
}
