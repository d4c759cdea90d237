//! Hours by the source of a receiver's light. In: results of receivers under conditions. Out: hours
//! of a kind, evenly chosen, and the errors of results in them.
//!
//! An error of reflected light is a small share of a mean that holds direct sun. It is a large
//! share in hours when the sun lights what a receiver sees but not the receiver itself. Errors are
//! therefore stated for such hours, too.

use std::collections::BTreeMap;

use super::comparison::{ConfidenceInterval, Pair, deviation, mean_w_m2, rmse_interval};
use super::estimate::PARTS;
use super::random::spread;
use crate::settings::Effect;
use heliotile_core::archive::accuracy::HoursMix;
use heliotile_core::replay::components::Component;

/// Number of pairs of a kind that are chosen; [`OF_RECEIVER`] limits their number for each
/// receiver, on average.
const PAIRS: usize = 1024;
const OF_RECEIVER: (usize, usize) = (8, 32);

/// Smallest share of all hours for which a kind is stated; [`MIN_RECEIVERS`] is the smallest
/// number of receivers that have such hours.
const MIN_SHARE: f64 = 0.01;
const MIN_RECEIVERS: usize = 4;

/// Share of the total below which light of the sun, direct or reflected, does not count.
const NO_SUN: f64 = 0.01;

/// Kind of hours in which errors of reflected light show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HourKind {
    /// Hours in which reflected sun makes up more than 1 % of the receiver's total, and the sun
    /// seen directly and by mirrors less than 1 %.
    NoDirectSun,
    /// Hours of the first kind in which more than half of the total comes from matt surfaces.
    MostlyReflected,
}

impl HourKind {
    /// All kinds, in the order of their numbers.
    pub const ALL: [HourKind; 2] = [HourKind::NoDirectSun, HourKind::MostlyReflected];

    /// Returns the name of the kind in the manifest and in tables.
    pub fn name(self) -> &'static str {
        match self {
            HourKind::NoDirectSun => "no direct sun",
            HourKind::MostlyReflected => "mostly reflected",
        }
    }

    /// Returns true if an hour with these components and their total (W/m2) is of this kind.
    pub fn holds(self, light: &[f64; PARTS]) -> bool {
        let of = |component: Component| light[component as usize];
        let total = of(Component::Total);
        let sun = of(Component::SunDirect) + of(Component::SunMirrored);
        let is_lit = of(Component::SunReflected) > NO_SUN * total && sun < NO_SUN * total;
        is_lit && (self == HourKind::NoDirectSun || reflected(light) > 0.5 * total)
    }
}

/// Returns the light that matt surfaces reflect, W/m2.
fn reflected(light: &[f64; PARTS]) -> f64 {
    light[Component::SunReflected as usize] + light[Component::SkyReflected as usize]
}

/// Receivers in hours of each kind.
#[derive(Clone, Debug, Default)]
pub struct HourSample {
    /// Number of receivers times conditions that hours were chosen from.
    looked_at: usize,
    /// Number of such hours of each kind.
    members: [usize; HourKind::ALL.len()],
    /// Chosen receivers and conditions, in this order, without results of the path tracer.
    pub pairs: Vec<Pair>,
    /// `[pair]`: the kinds that it was chosen for.
    of: Vec<[bool; HourKind::ALL.len()]>,
}

/// Error in hours of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct HoursFound {
    /// Kind of hours.
    pub kind: HourKind,
    /// Share of all hours of all receivers.
    pub share: f64,
    /// Number of receivers that have such hours.
    pub receivers: usize,
    /// Mean total, W/m2.
    pub mean_w_m2: f64,
    /// RMSE of the totals, W/m2.
    pub rmse_w_m2: ConfidenceInterval,
    /// Mean of the light that matt surfaces reflect, W/m2.
    pub reflected_mean_w_m2: f64,
    /// RMSE of the light that matt surfaces reflect, W/m2.
    pub reflected_w_m2: ConfidenceInterval,
    /// Shares of these hours by kind.
    pub mix: Vec<HoursMix<'static>>,
}

impl HourSample {
    /// Chooses hours of each kind for some receivers, by results under `conditions` conditions.
    pub fn choose(
        &mut self,
        receivers: std::ops::Range<usize>,
        conditions: usize,
        result: impl Fn(usize, usize) -> [f64; PARTS],
        seed: u64,
    ) {
        self.looked_at += receivers.len() * conditions;
        let each = (PAIRS / receivers.len().max(1)).clamp(OF_RECEIVER.0, OF_RECEIVER.1);
        // One pair may be chosen for both kinds.
        let mut chosen = BTreeMap::<(usize, usize), [bool; HourKind::ALL.len()]>::new();
        for kind in HourKind::ALL {
            let all = receivers.clone().flat_map(|receiver| (0..conditions).map(move |hour| (receiver, hour)));
            let members: Vec<(usize, usize)> =
                all.filter(|&(receiver, condition)| kind.holds(&result(receiver, condition))).collect();
            self.members[kind as usize] += members.len();
            for number in spread(members.len(), each * receivers.len(), seed) {
                chosen.entry(members[number]).or_default()[kind as usize] = true;
            }
        }
        for ((receiver, condition), of) in chosen {
            let result = result(receiver, condition);
            self.pairs.push(Pair { receiver, condition, result, reference: Default::default() });
            self.of.push(of);
        }
    }

    /// Returns the chosen hours with other results.
    #[must_use]
    pub fn with_results(&self, result: impl Fn(usize, usize) -> [f64; PARTS]) -> Self {
        let mut other = self.clone();
        other.pairs.iter_mut().for_each(|pair| pair.result = result(pair.receiver, pair.condition));
        other
    }

    /// Returns the errors of results in each kind of hours that is frequent enough.
    pub fn found(&self) -> Vec<HoursFound> {
        HourKind::ALL.into_iter().filter_map(|kind| self.of_kind(kind)).collect()
    }

    fn of_kind(&self, kind: HourKind) -> Option<HoursFound> {
        let chosen = self.pairs.iter().zip(&self.of).filter(|(_, of)| of[kind as usize]).map(|(pair, _)| *pair);
        let (chosen, mut pairs) = (chosen.clone().count(), chosen.collect::<Vec<Pair>>());
        // Drop hours that are not of the kind: coarse results spread light over neighbouring
        // directions, and so chose them.
        pairs.retain(|pair| kind.holds(&pair.reference.mean));
        let holding = pairs.len() as f64 / chosen.max(1) as f64;
        let receivers = pairs.chunk_by(|a, b| a.receiver == b.receiver).count();
        let share = holding * self.members[kind as usize] as f64 / self.looked_at.max(1) as f64;
        let matt = Effect::Diffuse as usize;
        let off = |pair: &Pair| {
            (reflected(&pair.result) - pair.reference.by_effect[matt], pair.reference.by_effect_error[matt])
        };
        (share >= MIN_SHARE && receivers >= MIN_RECEIVERS).then(|| HoursFound {
            kind,
            share,
            receivers,
            mean_w_m2: mean_w_m2(&pairs),
            rmse_w_m2: deviation(&pairs, &[], Component::Total as usize).rmse_w_m2,
            reflected_mean_w_m2: mean_of(&pairs, |pair| pair.reference.by_effect[matt]),
            reflected_w_m2: rmse_interval(&pairs, &[], off),
            mix: mix_of(&pairs),
        })
    }
}

fn mean_of(pairs: &[Pair], value: impl Fn(&Pair) -> f64) -> f64 {
    pairs.iter().map(value).sum::<f64>() / pairs.len().max(1) as f64
}

/// Returns the share of each kind of hours among pairs, as the manifest states it.
pub fn mix_of(pairs: &[Pair]) -> Vec<HoursMix<'static>> {
    let of_kind = |kind: HourKind| {
        let inside: Vec<Pair> = pairs.iter().filter(|pair| kind.holds(&pair.reference.mean)).copied().collect();
        let share = inside.len() as f64 / pairs.len().max(1) as f64;
        let reflected_mean_w_m2 = mean_of(&inside, |pair| pair.reference.by_effect[Effect::Diffuse as usize]);
        HoursMix { hours: kind.name(), share, mean_w_m2: mean_w_m2(&inside), reflected_mean_w_m2 }
    };
    HourKind::ALL.into_iter().map(of_kind).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(sun: f64, sky: f64, sun_reflected: f64, sky_reflected: f64) -> [f64; PARTS] {
        [sun, sky, sun_reflected, sky_reflected, 0.0, 0.0, sun + sky + sun_reflected + sky_reflected]
    }

    /// 60 W/m2 of reflected light and 40 of sky are both kinds, 40 and 60 only the first. With 2
    /// W/m2 of direct sun the hour is neither, and neither is an overcast hour.
    #[test]
    fn hours_are_of_the_kind_that_decides_their_light() {
        let kinds = |light: [f64; PARTS]| HourKind::ALL.map(|kind| kind.holds(&light));
        assert_eq!(kinds(light(0.0, 40.0, 55.0, 5.0)), [true, true]);
        assert_eq!(kinds(light(0.5, 60.0, 35.0, 5.0)), [true, false]);
        assert_eq!(kinds(light(2.0, 40.0, 55.0, 5.0)), [false, false]);
        assert_eq!(kinds(light(0.0, 40.0, 0.0, 60.0)), [false, false]);
    }

    /// 160 receivers have 64 hours, every fourth without direct sun and off by 2 W/m2; 1,280 are
    /// chosen, 8 per receiver. The path tracer finds direct sun for every second receiver. An
    /// eighth of the hours has an RMSE of 2 W/m2 of 50, all of it in the 20 W/m2 of reflected
    /// light. Mostly reflected hours do not occur and are not stated.
    #[test]
    fn only_hours_that_occur_state_an_error() {
        let result = |_: usize, condition: usize| match condition % 4 {
            0 => light(0.0, 30.0, 22.0, 0.0),
            _ => light(400.0, 100.0, 20.0, 5.0),
        };
        let mut sample = HourSample::default();
        sample.choose(0..160, 64, result, 1);
        assert_eq!(sample.pairs.len(), 1280);
        for pair in &mut sample.pairs {
            pair.reference.mean = light(if pair.receiver % 2 == 0 { 0.0 } else { 300.0 }, 30.0, 20.0, 0.0);
            pair.reference.by_effect[Effect::Diffuse as usize] = 20.0;
        }
        let found = sample.found();
        assert_eq!((found.len(), found[0].kind, found[0].receivers), (1, HourKind::NoDirectSun, 80));
        assert_eq!((found[0].share, found[0].mean_w_m2, found[0].reflected_mean_w_m2), (0.125, 50.0, 20.0));
        assert!((found[0].rmse_w_m2.value - 2.0).abs() < 1e-12 && (found[0].reflected_w_m2.value - 2.0).abs() < 1e-12);
    }
}
