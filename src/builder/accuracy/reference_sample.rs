//! Errors of a sample against the reference path tracer. In: a scene, some receivers, conditions.
//! Out: the errors of irradiances of these receivers.

use rayon::prelude::*;

use crate::accuracy::trial::{Bench, ErrorSource, Irradiances};
use crate::reference::comparison::{Pair, SunErrors, deviation, mean_w_m2, rmse_interval};
use crate::reference::groups::by_sky_view;
use crate::reference::hours::{HourKind, HourSample, HoursFound};
use crate::reference::{PARTS, PathTracer, ReferenceLight, ReferenceSky, reference_pairs, spread};
use crate::settings::Effects;
use heliotile_core::archive::accuracy::{Accuracy, GroupError, HoursError, TileError};
use heliotile_core::error::Result;
use heliotile_core::hemisphere::mix;
use heliotile_core::replay::components::Component;
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::in_axes;

/// Smallest number of receivers times conditions that are evaluated. [`OF_RECEIVER`] limits the
/// conditions of each receiver, besides the mean of all. Fewer receivers with more conditions tell
/// as much.
const PAIRS: usize = 2048;
const OF_RECEIVER: (usize, usize) = (16, 64);

/// Number of paths of a receiver for a target of 1 %; [`MIN_PATHS`] and [`MAX_PATHS`] limit it.
/// The noise of the path tracer is subtracted, but must not be many times the error in question.
const PATHS: f64 = 4096.0;
const MIN_PATHS: f64 = 2048.0;
const MAX_PATHS: f64 = 32768.0;

/// Seed of points of the sun.
const SUN_SEED: u64 = 0x73_756e;

/// Seed of the chosen hours and of their paths.
const SEED: u64 = 0x0068_6f75_7273;

/// Place of the total, after the six components.
pub const TOTAL: usize = PARTS - 1;

/// Returns a row of results with its total, W/m2.
pub fn with_total(row: &[f32; 8]) -> [f64; PARTS] {
    let sum = row.iter().take(TOTAL).map(|v| f64::from(*v)).sum();
    std::array::from_fn(|part| if part < TOTAL { f64::from(row[part]) } else { sum })
}

/// Receivers of a sample with irradiances from the reference path tracer.
pub struct ReferenceSample<'a> {
    tracer: PathTracer<'a>,
    receivers: &'a [Receiver],
    /// All conditions.
    skies: Vec<ReferenceSky>,
    /// Number of paths of a receiver.
    paths: usize,
    /// Hours when the sun lights what receivers see, without results.
    hours: HourSample,
    /// Pairs of receiver and condition in the order of the receivers, without results.
    pairs: Vec<Pair>,
    /// `[receiver][condition]`, for all conditions: the sun, direct and by way of mirrors. Single
    /// hours at a shadow's edge make up most of its error.
    suns: Vec<Vec<ReferenceLight>>,
    /// `[receiver]`: the mean of all conditions.
    means: Vec<ReferenceLight>,
    /// `[receiver]`: its sky view.
    views: Vec<f64>,
}

/// Errors by source that the reference path tracer found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SourcesFound {
    /// RMSE of each of [`ErrorSource::ALL`], percent of the mean total. That of the sky includes
    /// the sky patches.
    pub percent: [f64; 3],
    /// RMSE of all reflected light in hours when the sun lights what receivers see but not the
    /// receivers, percent of the mean total of all hours.
    pub lit_percent: f64,
}

impl<'a> ReferenceSample<'a> {
    /// Evaluates the receivers of a bench with the reference path tracer, for a target error in
    /// percent.
    pub fn new(bench: &Bench<'a>, left_out: Effects, target_percent: f64) -> Result<Self> {
        let scene = bench.scene.scene;
        let conditions = in_axes(bench.conditions, North::new(scene.place.as_ref()));
        let skies: Vec<ReferenceSky> =
            conditions.par_iter().map(|c| ReferenceSky::new(c, SkyModel::default())).collect::<Result<_>>()?;
        let (mean, open) = (ReferenceSky::mean(&skies), ReferenceSky::open());
        let tracer = PathTracer::new(bench.scene, left_out);
        let paths = (PATHS / (target_percent * target_percent).max(1e-9)).clamp(MIN_PATHS, MAX_PATHS) as usize;
        let each = (PAIRS / bench.receivers.len().max(1)).clamp(OF_RECEIVER.0, OF_RECEIVER.1);
        let reference = |(receiver, of): (usize, &Receiver)| {
            // Each receiver gets conditions of its own, so that many take part.
            let chosen = spread(skies.len(), each, mix(SEED, receiver as u64));
            let mut under: Vec<&ReferenceSky> = chosen.iter().map(|&condition| &skies[condition]).collect();
            under.extend([&mean, &open]);
            let seed = mix(0x0070_696c_6f74, receiver as u64);
            let mut found = tracer.irradiance(of.position, of.normal, &under, paths, seed);
            let view = found.pop().unwrap_or_default().mean[Component::SkyDirect as usize];
            let mean = found.pop().unwrap_or_default();
            let pair = |(condition, reference)| Pair { receiver, condition, result: [0.0; PARTS], reference };
            (chosen.into_iter().zip(found).map(pair).collect::<Vec<Pair>>(), (mean, view))
        };
        let all: Vec<(Vec<Pair>, (ReferenceLight, f64))> =
            bench.receivers.par_iter().enumerate().map(reference).collect();
        let (pairs, of_receivers): (Vec<Vec<Pair>>, Vec<(ReferenceLight, f64)>) = all.into_iter().unzip();
        let (means, views) = of_receivers.into_iter().unzip();
        let all: Vec<&ReferenceSky> = skies.iter().collect();
        let sun = |(receiver, of): (usize, &Receiver)| {
            tracer.sun(of.position, of.normal, &all, paths, mix(SUN_SEED, receiver as u64))
        };
        let suns = bench.receivers.par_iter().enumerate().map(sun).collect();
        let (receivers, hours, pairs) = (bench.receivers, HourSample::default(), pairs.concat());
        Ok(ReferenceSample { tracer, receivers, skies, paths, hours, pairs, suns, means, views })
    }

    /// Adds hours when the sun lights what receivers see; irradiances of a build tell which hours
    /// these are.
    #[must_use]
    pub fn with_hours(mut self, light: &Irradiances) -> Self {
        let mut hours = HourSample::default();
        let result = |receiver, condition| with_total(self.row(light, receiver, condition));
        hours.choose(0..self.receivers.len(), self.skies.len(), result, SEED);
        reference_pairs(&mut hours.pairs, &self.skies, |number, under| {
            let of = &self.receivers[number];
            self.tracer.irradiance(of.position, of.normal, under, self.paths, mix(SEED, number as u64))
        });
        self.hours = hours;
        self
    }

    fn row<'l>(&self, light: &'l Irradiances, receiver: usize, condition: usize) -> &'l [f32; 8] {
        &light.rows[receiver * self.skies.len() + condition]
    }

    /// Returns the mean of the totals, W/m2.
    pub fn mean_w_m2(&self) -> f64 {
        mean_w_m2(&self.pairs)
    }

    /// Returns the errors of irradiances of the same receivers and conditions. `tile` gives the
    /// tile of a receiver.
    pub fn accuracy(&self, light: &Irradiances, tile: impl Fn(usize) -> u32) -> Accuracy {
        let row = |receiver: usize, condition: usize| self.row(light, receiver, condition);
        let (pairs, suns) = (self.pairs_with(light), self.sun_errors(light));
        let mean = mean_w_m2(&pairs);
        let in_percent = |difference: f64| rounded(percent(difference, mean));
        let found: [_; PARTS] = std::array::from_fn(|part| deviation(&pairs, &suns, part));
        let names = Component::ALL.into_iter().map(|component| component.name().to_string());
        let components = found.iter().take(TOTAL).map(|found| in_percent(found.rmse_w_m2.value));
        // Error of each receiver's mean over all conditions.
        let yearly = |(receiver, reference): (usize, &ReferenceLight)| {
            let all = (0..self.skies.len()).map(|condition| with_total(row(receiver, condition))[TOTAL]);
            let difference = all.sum::<f64>() / self.skies.len().max(1) as f64 - reference.mean[TOTAL];
            difference * difference - reference.error[TOTAL].powi(2)
        };
        let squares: f64 = self.means.iter().enumerate().map(yearly).sum();
        // Subtracting the noise may hide the error. It is at least the bias, which has less noise.
        let yearly = (squares / self.means.len().max(1) as f64).max(0.0).sqrt().max(found[TOTAL].bias_w_m2.value.abs());
        Accuracy {
            rmse_percent: in_percent(found[TOTAL].rmse_w_m2.value),
            bias_percent: in_percent(found[TOTAL].bias_w_m2.value),
            yearly_percent: in_percent(yearly),
            components_percent: names.zip(components).collect(),
            sample: self.means.len() as u64,
            mean_w_m2: rounded(mean),
            groups: by_sky_view(&self.views).iter().filter_map(|group| self.group(group, &pairs, &suns)).collect(),
            hours: self.hours_of(light).found().iter().map(stated).collect(),
            tiles: tiles(&pairs, &suns, tile),
            ..Accuracy::default()
        }
    }

    /// Returns the errors of irradiances of the same receivers and conditions, source by source.
    pub fn sources(&self, light: &Irradiances) -> SourcesFound {
        let mean = self.mean_w_m2();
        let pairs = self.pairs_with(light);
        let suns = self.sun_errors(light);
        let rmse = |source: ErrorSource| {
            let difference = |pair: &Pair| {
                let reference = pair.reference.by_reflections[source as usize];
                let result = source.of(self.row(light, pair.receiver, pair.condition));
                (result - reference, pair.reference.by_reflections_error[source as usize])
            };
            let suns = if source == ErrorSource::Sky { &suns[..] } else { &[] };
            percent(rmse_interval(&pairs, suns, difference).value, mean)
        };
        let hours = self.hours_of(light).found();
        let shaded = hours.iter().find(|found| found.kind == HourKind::NoDirectSun);
        let lit = shaded.map_or(0.0, |found| found.reflected_w_m2.value);
        SourcesFound { percent: ErrorSource::ALL.map(rmse), lit_percent: percent(lit, mean) }
    }

    fn pairs_with(&self, light: &Irradiances) -> Vec<Pair> {
        let result = |pair: &Pair| with_total(self.row(light, pair.receiver, pair.condition));
        self.pairs.iter().map(|pair| Pair { result: result(pair), ..*pair }).collect()
    }

    fn sun_errors(&self, light: &Irradiances) -> Vec<SunErrors> {
        let of_receiver = |(receiver, reference): (usize, &Vec<ReferenceLight>)| {
            let result = |(condition, reference): (usize, &ReferenceLight)| {
                (with_total(self.row(light, receiver, condition)), *reference)
            };
            SunErrors::new(receiver, reference.iter().enumerate().map(result))
        };
        self.suns.iter().enumerate().map(of_receiver).collect()
    }

    fn hours_of(&self, light: &Irradiances) -> HourSample {
        self.hours.with_results(|receiver, condition| with_total(self.row(light, receiver, condition)))
    }

    /// Returns the error of a group of receivers.
    fn group(&self, group: &[usize], pairs: &[Pair], suns: &[SunErrors]) -> Option<GroupError> {
        let inside: Vec<Pair> = pairs.iter().filter(|pair| group.contains(&pair.receiver)).copied().collect();
        let end = |receiver: Option<&usize>| receiver.map(|&receiver| rounded(self.views[receiver]));
        Some(GroupError {
            sky_view: [end(group.first())?, end(group.last())?],
            receivers: group.len() as u32,
            mean_w_m2: rounded(mean_w_m2(&inside)),
            rmse_w_m2: rounded(deviation(&inside, suns, TOTAL).rmse_w_m2.value),
        })
    }
}

/// Returns the error in hours of one kind as the manifest states it.
fn stated(found: &HoursFound) -> HoursError {
    HoursError {
        hours: found.kind.name().into(),
        share_percent: rounded(100.0 * found.share),
        receivers: found.receivers as u32,
        mean_w_m2: rounded(found.mean_w_m2),
        rmse_w_m2: rounded(found.rmse_w_m2.value),
        reflected_mean_w_m2: rounded(found.reflected_mean_w_m2),
        reflected_w_m2: rounded(found.reflected_w_m2.value),
    }
}

/// Returns the RMSE of the receivers of each tile. Pairs are in the order of their tiles.
fn tiles(pairs: &[Pair], suns: &[SunErrors], tile: impl Fn(usize) -> u32) -> Vec<TileError> {
    let of_tile = |pairs: &[Pair]| TileError {
        tile: pairs.first().map_or(0, |pair| tile(pair.receiver)),
        receivers: pairs.chunk_by(|a, b| a.receiver == b.receiver).count() as u32,
        rmse_w_m2: std::array::from_fn(|part| rounded(deviation(pairs, suns, part).rmse_w_m2.value)),
    };
    pairs.chunk_by(|a, b| tile(a.receiver) == tile(b.receiver)).map(of_tile).collect()
}

/// Returns a difference in percent of a mean; 0 if the mean is 0.
pub fn percent(difference: f64, mean: f64) -> f64 {
    if mean > 0.0 { difference / mean * 100.0 } else { 0.0 }
}

/// Rounds to four digits, which are more than an estimate has.
pub fn rounded(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}
