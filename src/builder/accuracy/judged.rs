//! What the judge finds for a sample. In: a scene, some receivers, conditions. Out: how far a light of these receivers is off.

use rayon::prelude::*;

use crate::accuracy::estimate::percent;
use crate::accuracy::trial::{Bench, Irradiances};
use crate::judge::comparison::{Pair, deviation, mean_w_m2, off};
use crate::judge::groups::by_sky_view;
use crate::judge::{Judge, Judged, JudgedSky, PARTS};
use crate::settings::Effects;
use heliotile_core::archive::accuracy::{Accuracy, GroupError, TileError};
use heliotile_core::error::Result;
use heliotile_core::hemisphere::mix;
use heliotile_core::replay::components::Component;
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::in_axes;

/// Conditions that a receiver is judged under, besides the mean of all.
const CONDITIONS: usize = 16;

/// Paths of a receiver where the error wanted is 1 %, and the limits of their number: the judge's noise is taken off, but must not be many times
/// what it looks for.
const PATHS: f64 = 4096.0;
const LEAST_PATHS: f64 = 2048.0;
const MOST_PATHS: f64 = 32768.0;

/// The total, after the six components.
pub const TOTAL: usize = PARTS - 1;

/// A row of results with its total, W/m2.
pub fn with_total(row: &[f32; 8]) -> [f64; PARTS] {
    let sum = row.iter().take(TOTAL).map(|v| f64::from(*v)).sum();
    std::array::from_fn(|part| if part < TOTAL { f64::from(row[part]) } else { sum })
}

/// Receivers of a sample as the judge sees them.
pub struct JudgedSample {
    /// Conditions of all.
    conditions: usize,
    /// In the order of the receivers; without results.
    pairs: Vec<Pair>,
    /// `[receiver]`: the mean of all conditions.
    means: Vec<Judged>,
    /// `[receiver]`: the share of its hemisphere that is sky.
    views: Vec<f64>,
}

impl JudgedSample {
    /// Asks the judge about the receivers of a bench, for an error of so many percent.
    pub fn of(bench: &Bench, left_out: Effects, target_percent: f64) -> Result<Self> {
        let scene = bench.scene.scene;
        let conditions = in_axes(bench.conditions, North::of(scene.place.as_ref()));
        let skies: Vec<JudgedSky> =
            conditions.par_iter().map(|c| JudgedSky::new(c, SkyModel::default())).collect::<Result<_>>()?;
        let (mean, open) = (JudgedSky::mean(&skies), JudgedSky::open());
        let judge = Judge::new(bench.scene, left_out);
        let paths = (PATHS / (target_percent * target_percent).max(1e-9)).clamp(LEAST_PATHS, MOST_PATHS) as usize;
        let stride = skies.len().div_ceil(CONDITIONS).max(1);
        let judged = |(receiver, of): (usize, &Receiver)| {
            // Others for each receiver, so that many take part.
            let chosen: Vec<usize> = (receiver % stride..skies.len()).step_by(stride).collect();
            let mut under: Vec<&JudgedSky> = chosen.iter().map(|&condition| &skies[condition]).collect();
            under.extend([&mean, &open]);
            let seed = mix(0x0070_696c_6f74, receiver as u64);
            let mut found = judge.irradiance(of.position, of.normal, &under, paths, seed);
            let view = found.pop().unwrap_or_default().mean[Component::SkyDirect as usize];
            let mean = found.pop().unwrap_or_default();
            let pair = |(condition, judged)| Pair { receiver, condition, result: [0.0; PARTS], judged };
            (chosen.into_iter().zip(found).map(pair).collect::<Vec<Pair>>(), (mean, view))
        };
        let all: Vec<(Vec<Pair>, (Judged, f64))> = bench.receivers.par_iter().enumerate().map(judged).collect();
        let (pairs, of_receivers): (Vec<Vec<Pair>>, Vec<(Judged, f64)>) = all.into_iter().unzip();
        let (means, views) = of_receivers.into_iter().unzip();
        Ok(JudgedSample { conditions: skies.len(), pairs: pairs.concat(), means, views })
    }

    /// Mean of the totals, W/m2.
    pub fn mean_w_m2(&self) -> f64 {
        mean_w_m2(&self.pairs)
    }

    /// How far a light of the same receivers and conditions is off; `tile` of a receiver.
    pub fn accuracy(&self, light: &Irradiances, tile: impl Fn(usize) -> u32) -> Accuracy {
        let row = |receiver: usize, condition: usize| &light.rows[receiver * self.conditions + condition];
        let with_result = |pair: &Pair| Pair { result: with_total(row(pair.receiver, pair.condition)), ..*pair };
        let pairs: Vec<Pair> = self.pairs.iter().map(with_result).collect();
        let mean = mean_w_m2(&pairs);
        let in_percent = |difference: f64| rounded(percent(difference, mean));
        let found: [_; PARTS] = std::array::from_fn(|part| deviation(&pairs, part));
        let names = Component::ALL.into_iter().map(|component| component.name().to_string());
        let components = found.iter().take(TOTAL).map(|found| in_percent(found.rmse_w_m2.value));
        // Of each receiver's mean over all conditions.
        let yearly = |(receiver, judged): (usize, &Judged)| {
            let all = (0..self.conditions).map(|condition| with_total(row(receiver, condition))[TOTAL]);
            let difference = all.sum::<f64>() / self.conditions.max(1) as f64 - judged.mean[TOTAL];
            difference * difference - judged.error[TOTAL].powi(2)
        };
        let squares: f64 = self.means.iter().enumerate().map(yearly).sum();
        let yearly = (squares / self.means.len().max(1) as f64).max(0.0).sqrt();
        Accuracy {
            rmse_percent: in_percent(found[TOTAL].rmse_w_m2.value),
            bias_percent: in_percent(found[TOTAL].bias_w_m2.value),
            yearly_percent: in_percent(yearly),
            components_percent: names.zip(components).collect(),
            sample: self.means.len() as u64,
            mean_w_m2: rounded(mean),
            groups: by_sky_view(&self.views).iter().filter_map(|group| self.group(group, &pairs)).collect(),
            tiles: tiles(&pairs, tile),
            ..Accuracy::default()
        }
    }
}

impl JudgedSample {
    /// The error of some receivers.
    fn group(&self, group: &[usize], pairs: &[Pair]) -> Option<GroupError> {
        let inside: Vec<Pair> = pairs.iter().filter(|pair| group.contains(&pair.receiver)).copied().collect();
        let end = |receiver: Option<&usize>| receiver.map(|&receiver| rounded(self.views[receiver]));
        Some(GroupError {
            sky_view: [end(group.first())?, end(group.last())?],
            receivers: group.len() as u32,
            mean_w_m2: rounded(mean_w_m2(&inside)),
            rmse_w_m2: rounded(deviation(&inside, TOTAL).rmse_w_m2.value),
        })
    }
}

/// RMSE of the receivers of each tile, which are in the order of their tiles.
fn tiles(pairs: &[Pair], tile: impl Fn(usize) -> u32) -> Vec<TileError> {
    let of_tile = |pairs: &[Pair]| {
        let count = pairs.len().max(1) as f64;
        let rmse = |part: usize| {
            let squares = pairs.iter().map(|pair| off(pair, part).powi(2) - pair.judged.error[part].powi(2));
            rounded((squares.sum::<f64>() / count).max(0.0).sqrt())
        };
        TileError {
            tile: pairs.first().map_or(0, |pair| tile(pair.receiver)),
            receivers: pairs.chunk_by(|a, b| a.receiver == b.receiver).count() as u32,
            rmse_w_m2: std::array::from_fn(rmse),
        }
    };
    pairs.chunk_by(|a, b| tile(a.receiver) == tile(b.receiver)).map(of_tile).collect()
}

/// Four digits are more than an estimate has.
pub fn rounded(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}
