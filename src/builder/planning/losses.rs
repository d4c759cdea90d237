//! Light that effects contribute over a year, to decide which effects a build may leave out. In: a
//! scene, receivers, weather. Out: by groups of receivers, an upper bound of the light that is lost
//! without an effect.
//!
//! The [reference path tracer](crate::reference) follows light paths of a sample of receivers under
//! all suns and skies of the year at once. It counts the light that came by surfaces, by several of
//! them and by mirrors, and the light that canopies took away. A bound is 1.05 times the mean
//! found, since a build may overestimate an effect, plus three standard errors: of the path tracer
//! and, if not all receivers were sampled, of the sample. The bound holds for the mean of a group;
//! a few receivers outside the sample may lose more.

use std::time::Instant;

use rayon::prelude::*;

use crate::accuracy::conditions::{ErrorConditions, is_lit};
use crate::accuracy::reference_sample::percent;
use crate::accuracy::sample;
use crate::pipeline::Build;
use crate::reference::groups::by_sky_view;
use crate::reference::{PathTracer, ReferenceLight, ReferenceSky};
use crate::settings::{BuildSettings, Effect, Effects};
use heliotile_core::error::Result;
use heliotile_core::hemisphere::mix;
use heliotile_core::observer::Stage;
use heliotile_core::replay::components::Component;
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::in_axes;

/// Largest number of receivers in the sample; [`PATHS`] is the number of paths of each.
const SAMPLE: usize = 512;
const PATHS: usize = 1024;

/// Least sum that percentages refer to, as a share of the mean of all receivers. Groups below it,
/// such as receivers inside solids, get hardly any light, so percentages of their own sum would say
/// nothing.
const MIN: f64 = 0.01;

/// Standard errors between the estimate and its bound: exceeded once in 700 times.
const SURE: f64 = 3.0;

/// Factor by which a build may overestimate the light of an effect.
const BUILDER: f64 = 1.05;

/// Light that effects contribute over a year of weather.
#[derive(Clone, Debug)]
pub struct YearLosses {
    /// Name of the weather file.
    pub weather: String,
    /// Number of all receivers.
    pub receivers: usize,
    /// Number of receivers in the sample.
    pub sample: usize,
    /// All receivers first, then groups by sky view.
    pub groups: Vec<GroupLosses>,
    /// Time that the estimate took, seconds.
    pub seconds: f64,
}

/// Means of a group of receivers.
#[derive(Clone, Copy, Debug)]
pub struct GroupLosses {
    /// Smallest and largest sky view of the group, as shares of the hemisphere.
    pub sky_view: [f64; 2],
    /// Mean yearly irradiation, kWh/m2.
    pub total_kwh_m2: f64,
    /// Sum that percentages refer to, kWh/m2: the group's own, but at least a small share of the
    /// mean of all receivers.
    pub whole_kwh_m2: f64,
    /// Loss for each of [`Effect::ALL`].
    pub losses: [Loss; Effect::ALL.len()],
}

/// Light that is lost when an effect is left out. For canopies it is light that is gained.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loss {
    /// Estimate, kWh/m2.
    pub found_kwh_m2: f64,
    /// Upper bound, kWh/m2.
    pub bound_kwh_m2: f64,
}

impl GroupLosses {
    /// Returns the bound of an effect in percent of the group's sum.
    pub fn percent(&self, effect: Effect) -> f64 {
        percent(self.losses[effect as usize].bound_kwh_m2, self.whole_kwh_m2)
    }

    /// Returns the losses of a group from `some`, its sampled receivers out of `all`. Percentages
    /// refer to at least `least` kWh/m2.
    fn new(some: &[Asked], all: f64, least: f64) -> Self {
        let count = some.len().max(1) as f64;
        let mean = |value: &dyn Fn(&Asked) -> f64| some.iter().map(value).sum::<f64>() / count;
        let loss = |effect: Effect| {
            let number = effect as usize;
            let found = mean(&|asked| asked.year.by_effect[number]);
            let chance = mean(&|asked| asked.year.by_effect_error[number].powi(2)) / count;
            // Variance of a mean sampled without replacement (Cochran 1977, "Sampling Techniques",
            // eq. 2.20).
            let spread = mean(&|asked| (asked.year.by_effect[number] - found).powi(2)) / (count - 1.0).max(1.0);
            let left = (1.0 - count / all).max(0.0);
            let bound = BUILDER * found + SURE * (chance + left * spread).sqrt();
            Loss { found_kwh_m2: found, bound_kwh_m2: bound }
        };
        let view = |pick: fn(f64, f64) -> f64| some.iter().map(|asked| asked.sky_view).reduce(pick).unwrap_or(0.0);
        let total = mean(&|asked| asked.year.mean[Component::Total as usize]);
        GroupLosses {
            sky_view: [view(f64::min), view(f64::max)],
            total_kwh_m2: total,
            whole_kwh_m2: total.max(least),
            losses: Effect::ALL.map(loss),
        }
    }
}

/// Sampled receiver and what the reference path tracer found for it.
#[derive(Clone, Copy)]
struct Asked {
    sky_view: f64,
    /// Sums of the year, kWh/m2.
    year: ReferenceLight,
}

impl YearLosses {
    /// Estimates the losses for a sample of a build's receivers with the reference path tracer.
    /// Fails if the suns need true north and the scene has no place.
    pub fn new(build: &mut Build, suns: &ErrorConditions) -> Result<Self> {
        let started = Instant::now();
        let scene = build.scene.scene;
        let mut all = suns.year(BuildSettings::default().steps.into());
        all.retain(is_lit);
        let year = ReferenceSky::sum(&in_axes(&all, North::new(scene.place.as_ref())), SkyModel::default())?;
        // The open sky gives the sky view by which receivers are grouped.
        let open = ReferenceSky::open();
        let receivers = build.receivers.count();
        let sampled: Vec<Receiver> = sample(build.receivers, SAMPLE)?.into_iter().map(|s| s.1).collect();
        let tracer = PathTracer::new(build.scene, Effects::NONE);
        let progress = Stage::begin(build.observer, "year", Some(sampled.len() as u64));
        let ask = |(number, of): (usize, &Receiver)| {
            let seed = mix(0x7965_6172, number as u64);
            let found = tracer.irradiance(of.position, of.normal, &[&year, &open], PATHS, seed);
            progress.advance(1);
            Asked { sky_view: found[1].mean[Component::SkyDirect as usize], year: found[0] }
        };
        let asked: Vec<Asked> = sampled.par_iter().enumerate().map(ask).collect();
        drop(progress);
        let (count, of_each) = (asked.len(), receivers as f64 / asked.len().max(1) as f64);
        let group = |some: &[Asked], least: f64| GroupLosses::new(some, some.len() as f64 * of_each, least);
        let mut groups = vec![group(&asked, 0.0)];
        let least = MIN * groups[0].total_kwh_m2;
        let parts = by_sky_view(&asked.iter().map(|asked| asked.sky_view).collect::<Vec<_>>());
        if parts.len() > 1 {
            let of = |part: &Vec<usize>| part.iter().map(|&i| asked[i]).collect::<Vec<Asked>>();
            groups.extend(parts.iter().map(|part| group(&of(part), least)));
        }
        let seconds = started.elapsed().as_secs_f64();
        Ok(YearLosses { weather: suns.name().into(), receivers, sample: count, groups, seconds })
    }

    /// Returns the largest loss of any group without an effect, percent of the group's sum.
    pub fn worst_percent(&self, effect: Effect) -> f64 {
        self.groups.iter().map(|group| group.percent(effect)).fold(0.0, f64::max)
    }

    /// Returns the effects that can be left out together so that no group loses more than `percent`
    /// of its sum. Effects that contribute least are tried first.
    pub fn negligible(&self, percent: f64) -> Effects {
        let mut effects = Effect::ALL;
        effects.sort_by(|a, b| self.worst_percent(*a).total_cmp(&self.worst_percent(*b)));
        let mut without: Vec<Effect> = Vec::new();
        for effect in effects {
            let tried = [&without[..], &[effect]].concat();
            if self.groups.iter().all(|group| lost_percent(group, &tried) <= percent) {
                without = tried;
            }
        }
        Effects::of_names(&without.iter().map(|effect| effect.name().to_string()).collect::<Vec<_>>())
    }
}

/// Returns the loss of a group without some effects, percent of its sum. Bounces and light
/// scattered by leaves are parts of diffuse light and do not count again without it.
fn lost_percent(group: &GroupLosses, without: &[Effect]) -> f64 {
    let is_diffuse = |effect: &Effect| matches!(effect, Effect::Bounces | Effect::Leaves);
    let counts = |effect: &&Effect| !(is_diffuse(effect) && without.contains(&Effect::Diffuse));
    without.iter().filter(counts).map(|effect| group.percent(*effect)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn losses(groups: &[[f64; 5]]) -> YearLosses {
        let loss = |bound: f64| Loss { found_kwh_m2: 0.9 * bound, bound_kwh_m2: bound };
        let group = |bounds: &[f64; 5]| GroupLosses {
            sky_view: [0.0, 1.0],
            total_kwh_m2: 1000.0,
            whole_kwh_m2: 1000.0,
            losses: bounds.map(loss),
        };
        let groups = groups.iter().map(group).collect();
        YearLosses { weather: "w".into(), receivers: 8, sample: 8, groups, seconds: 0.0 }
    }

    /// Groups of 1,000 kWh/m2 lose 9 and 3 kWh/m2 without diffuse light, 2 and 4 of these without
    /// bounces, 3 and 0 without mirrors. A limit of 0.4 % leaves out mirrors only, whose worst
    /// group loses less than that of bounces, 0.7 % leaves out both, 1.3 % all three and with them
    /// scattering leaves. Where nothing is lost, a limit of 0 leaves out all five.
    #[test]
    fn the_effect_that_loses_least_is_left_out_first() {
        let some = losses(&[[9.0, 2.0, 3.0, 50.0, 50.0], [3.0, 4.0, 0.0, 50.0, 50.0]]);
        for (percent, names) in [
            (0.2, vec![]),
            (0.4, vec!["mirrors"]),
            (0.7, vec!["bounces", "mirrors"]),
            (1.3, vec!["diffuse", "bounces", "mirrors", "leaves"]),
        ] {
            assert_eq!(some.negligible(percent).names(), names, "{percent}");
        }
        assert_eq!(losses(&[[0.0; 5]]).negligible(0.0), Effects::ALL);
    }

    /// Four receivers out of 8 lose 1, 2, 3, 4 with errors of 0.2: the mean is 2.5 and the bound
    /// 1.05 x 2.5 + 3 sqrt(0.04 / 4 + 0.5 x 1.25 / 3). If the group has only these 4, the second
    /// part of the root is 0.
    #[test]
    fn bounds_hold_the_spread_of_the_sample() {
        let asked = |i: usize| {
            let mut year = ReferenceLight::default();
            (year.by_effect[1], year.by_effect_error[1]) = (1.0 + i as f64, 0.2);
            Asked { sky_view: 0.1 * i as f64, year }
        };
        let some: Vec<Asked> = (0..4).map(asked).collect();
        let bound = |all: f64| GroupLosses::new(&some, all, 0.0).losses[1].bound_kwh_m2;
        assert!((bound(8.0) - (2.625 + 3.0 * (0.01_f64 + 0.5 * 1.25 / 3.0).sqrt())).abs() < 1e-12);
        assert!((bound(4.0) - (2.625 + 0.3)).abs() < 1e-12);
    }
}
