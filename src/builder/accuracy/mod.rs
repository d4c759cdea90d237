//! Accuracy as one number. In: a scene, its receivers and a target in percent. Out: the cheapest settings that keep within it, what
//! they are expected to be off by, and what they were found to be off by.
//!
//! Half of a spread sample of the receivers is the pilot: it is built with a few settings, and the distances between them give the error of
//! every rung of each ladder ([`estimate`]). The other half is the check: built with the settings that were chosen and with finer ones; where that
//! finds more than was wanted, finer settings are chosen by what it found.
//! Nothing here depends on the machine, so the same site and target give the same settings, and the same archive.

pub mod conditions;
pub mod estimate;
pub mod trial;

use std::time::Instant;

use crate::build::{Build, Workspace};
use crate::observer::Stage;
use crate::receiver_tiles::ReceiverTiles;
use crate::settings::ladder::{self, BOUNCED_RUNGS, PATCH_RUNGS, SEEN_RUNGS, SKY_RUNGS};
use crate::settings::{BuildSettings, Effects, Rungs};
use conditions::ErrorConditions;
use estimate::{Errors, patch_errors, percent, rung};
use heliotile_core::archive::accuracy::{Accuracy, TileError};
use heliotile_core::error::{Error, Result};
use heliotile_core::replay::components::Component;
use heliotile_core::site::receiver::{Receiver, TILE};
use trial::{Bench, ErrorSource, Irradiances, Trial};

/// Receivers of the pilot, and of the check: so many of all, within limits.
const SHARE: usize = 16;
const LEAST: usize = 20;
const MOST: usize = 32;

/// Suns and skies of an estimate.
pub const CONDITIONS: usize = 256;

/// A source is looked at with finer settings if it makes up this share of the target.
const MATTERS: f64 = 0.35;

/// Finer bounces than these cost more than the rest of a build on a large site.
const FINEST_PILOT_BOUNCES: usize = 4;

/// Rounds of choosing and trying.
const ROUNDS: usize = 3;

/// An error to find settings for.
pub struct PilotRequest<'a> {
    /// Largest RMSE of hourly totals, percent of their mean.
    pub target_percent: f64,
    /// What errors are estimated under.
    pub suns: &'a ErrorConditions,
    /// Effects that no build of the pilot traces.
    pub left_out: Effects,
}

/// Settings that were chosen for an error, and what they are known to be off by.
#[derive(Clone, Debug)]
pub struct SettingsChoice {
    /// The cheapest settings that keep within the target, as far as is known.
    pub settings: BuildSettings,
    /// What they were found to be off by, for the manifest.
    pub accuracy: Accuracy,
    /// RMSE of each source that was expected, percent of the mean total: [`ErrorSource::ALL`], then the sky's patches.
    pub sources_percent: [f64; 4],
    /// Seconds that it took to find out.
    pub pilot_s: f64,
}

/// Receivers spread evenly over the site, with the tiles that they will lie in.
pub fn sample(receivers: &mut ReceiverTiles, count: usize) -> Result<Vec<(u32, Receiver)>> {
    let all = receivers.count();
    let count = count.clamp(1, all.max(1));
    let mut sample = Vec::with_capacity(count);
    let mut number = 0;
    for tile in receivers.tiles()? {
        for receiver in tile? {
            if sample.len() * all / count == number {
                sample.push(((number / TILE) as u32, receiver));
            }
            number += 1;
        }
    }
    Ok(sample)
}

/// The cheapest settings that keep within an error, by building samples of the receivers with several.
pub fn choose(build: &mut Build, wish: &PilotRequest) -> Result<SettingsChoice> {
    let started = Instant::now();
    let conditions = wish.suns.some(CONDITIONS);
    let each = (build.receivers.count() / SHARE).clamp(LEAST, MOST).min(build.receivers.count().div_ceil(2));
    let sample = sample(build.receivers, 2 * each)?;
    let half = |odd: usize| -> Vec<Receiver> { sample.iter().skip(odd).step_by(2).map(|s| s.1.clone()).collect() };
    let halves = [half(0), half(1)];
    let Workspace { folder, memory } = build.workspace;
    let trials = tempfile::Builder::new().prefix("heliotile-pilot").tempdir_in(folder);
    let trials = trials.map_err(Error::io(folder, "make a folder in"))?;
    let workspace = Workspace { folder: trials.path().to_path_buf(), memory: *memory };
    let bench = |half: usize| Bench {
        scene: build.scene,
        // With a single receiver there is no other half.
        receivers: if halves[half].is_empty() { &halves[0] } else { &halves[half] },
        conditions: &conditions,
        workspace: &workspace,
        observer: build.observer,
    };
    let settings = |rungs: Rungs| BuildSettings { left_out: wish.left_out, ..rungs.settings() };
    let progress = Stage::begin(build.observer, "pilot", None);
    let try_out = |half: usize, rungs: Rungs| -> Result<(Rungs, Trial)> {
        let trial = bench(half).trial(settings(rungs))?;
        progress.advance(1);
        Ok((rungs, trial))
    };

    let first = [1, 2].map(|rung| Rungs { sky: rung, seen: rung, bounced: rung, patches: 1 });
    let mut trials = vec![try_out(0, first[0])?];
    let mut finest = try_out(0, first[1])?;
    let archive = &finest.1.archive;
    let [fewest, _, most] = ladder::patches();
    let lights = [bench(0).light(archive, fewest)?, finest.1.light.clone(), bench(0).light(archive, most)?];
    let patches = patch_errors(&lights);
    let mut errors = Errors::of(&trials, &finest, patches);
    let mut chosen = errors.cheapest(wish.target_percent);
    let mut finer = finer(chosen, &errors, wish.target_percent);
    for _ in 0..ROUNDS {
        trials.push(std::mem::replace(&mut finest, try_out(0, finer)?));
        errors = Errors::of(&trials, &finest, patches);
        let again = errors.cheapest(wish.target_percent);
        if again == chosen {
            break;
        }
        chosen = again;
        let next = crate::accuracy::finer(chosen, &errors, wish.target_percent);
        if ErrorSource::ALL.iter().all(|&source| rung(next, source) <= rung(finer, source)) {
            break;
        }
        finer = next;
    }

    let judge = |finer: Rungs| try_out(1, Rungs { patches: PATCH_RUNGS - 1, ..finer });
    let tile = |i: usize| sample.get(2 * i + 1).or(sample.first()).map_or(0, |s| s.0);
    let mut truth = judge(finer)?.1.light;
    // What the check finds over what the pilot expects.
    let (mut scale, mut round) = (1.0, 1);
    let (accuracy, expected) = loop {
        let (_, here) = try_out(1, chosen)?;
        let left = ErrorSource::ALL.map(|source| scale * errors.at(finer, source).min(errors.at(chosen, source)));
        let accuracy = found(&here.light, &truth, left, tile);
        let expected = scale * errors.total(chosen);
        let again = errors.cheapest(wish.target_percent * expected / (scale * accuracy.rmse_percent));
        if accuracy.rmse_percent <= wish.target_percent || round == ROUNDS || again == chosen {
            break (accuracy, expected);
        }
        (chosen, scale, round) = (again, scale * accuracy.rmse_percent / expected, round + 1);
        let next = crate::accuracy::finer(chosen, &errors, wish.target_percent / scale);
        if ErrorSource::ALL.iter().any(|&source| rung(next, source) > rung(finer, source)) {
            finer = next;
            truth = judge(finer)?.1.light;
        }
    };
    drop(progress);

    let accuracy = Accuracy {
        target_percent: wish.target_percent,
        predicted_percent: rounded(expected),
        conditions: conditions.len() as u64,
        weather: wish.suns.name().into(),
        ..accuracy
    };
    let [sky, seen, bounced] = ErrorSource::ALL.map(|source| scale * errors.at(chosen, source));
    let sources_percent = [sky, seen, bounced, scale * patches[chosen.patches]];
    let pilot_s = started.elapsed().as_secs_f64();
    Ok(SettingsChoice { settings: settings(chosen), accuracy, sources_percent, pilot_s })
}

/// Settings to judge some rungs by: one rung up where that source's error matters.
fn finer(rungs: Rungs, errors: &Errors, target_percent: f64) -> Rungs {
    let up = |source: ErrorSource, length: usize| {
        let at = rung(rungs, source);
        if errors.at(rungs, source) > MATTERS * target_percent { (at + 1).min(length - 1) } else { at }
    };
    let fine = |sky: usize| Rungs { sky, ..rungs }.settings().sky_fine;
    Rungs {
        // Skies cost little.
        sky: (2..SKY_RUNGS).find(|&sky| fine(sky) > fine(rungs.sky)).unwrap_or(SKY_RUNGS - 1),
        seen: up(ErrorSource::Seen, SEEN_RUNGS).max(2),
        bounced: up(ErrorSource::Bounced, BOUNCED_RUNGS).min(FINEST_PILOT_BOUNCES.max(rungs.bounced)).max(2),
        patches: rungs.patches,
    }
}

/// How far a light lies from a finer one that is itself off by `left` percent, source by source.
fn found(light: &Irradiances, truth: &Irradiances, left: [f64; 3], tile: impl Fn(usize) -> u32) -> Accuracy {
    let mean = truth.mean();
    let [sky, seen, bounced] = left;
    let in_percent = |difference: f64| rounded(percent(difference, mean));
    let names = Component::ALL.into_iter().map(|component| component.name().to_string());
    // What is left is the sun's for the most part.
    let left_of = |component| match component {
        Component::SunDirect => sky,
        Component::SunDiffuse => seen.hypot(bounced),
        _ => 0.0,
    };
    let errors = Component::ALL.into_iter().zip(light.component_errors(truth));
    let components = errors.map(|(component, error)| rounded(percent(error.rmse, mean).hypot(left_of(component))));
    let receivers = truth.rows.len() / truth.conditions.max(1);
    let mut tiles: Vec<TileError> = Vec::new();
    for receiver in 0..receivers {
        let (here, right) = (light.some(|r| r == receiver), truth.some(|r| r == receiver));
        let mut squares = [0.0; 7];
        for (slot, error) in squares.iter_mut().zip(here.component_errors(&right)) {
            *slot = error.rmse * error.rmse;
        }
        squares[6] = here.total_error(&right).rmse.powi(2);
        match tiles.last_mut().filter(|last| last.tile == tile(receiver)) {
            Some(last) => {
                last.receivers += 1;
                last.rmse_w_m2.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square);
            }
            None => tiles.push(TileError { tile: tile(receiver), receivers: 1, rmse_w_m2: squares }),
        }
    }
    for tile in &mut tiles {
        let count = f64::from(tile.receivers);
        tile.rmse_w_m2.iter_mut().for_each(|sum| *sum = rounded((*sum / count).sqrt()));
    }
    Accuracy {
        rmse_percent: rounded(percent(light.total_error(truth).rmse, mean).hypot(sky).hypot(seen).hypot(bounced)),
        bias_percent: in_percent(light.total_error(truth).bias),
        yearly_percent: in_percent(light.yearly_error(truth).rmse),
        components_percent: names.zip(components).collect(),
        sample: receivers as u64,
        mean_w_m2: rounded(mean),
        tiles,
        ..Accuracy::default()
    }
}

/// Four digits are more than an estimate has.
fn rounded(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// 10 of 100 receivers are every tenth, in order, and tiles are those of 64: the first 7 lie in tile 0; all of 3 are asked for with 10.
    #[test]
    fn samples_are_spread() {
        let receiver = |i: usize| Receiver::new(format!("{i}"), DVec3::new(i as f64, 0.0, 0.0), DVec3::Z);
        let of = |count: usize| {
            let all: Vec<Receiver> = (0..count).map(receiver).collect();
            let mut tiles =
                ReceiverTiles::from_receivers(&all, DVec3::ZERO, &std::env::temp_dir(), 1 << 20).expect("in memory");
            sample(&mut tiles, 10).expect("a sample")
        };
        let some = of(100);
        assert_eq!(some.iter().map(|s| s.1.id.as_str()).collect::<Vec<_>>()[..3], ["0", "10", "20"]);
        assert_eq!((some.len(), some.iter().filter(|s| s.0 == 0).count()), (10, 7));
        assert_eq!(of(3).len(), 3);
    }

    /// Rounding keeps four digits of 0.0123456 and leaves 0 alone: 2 of 2.
    #[test]
    fn four_digits() {
        assert_eq!((rounded(0.012_345_6), rounded(0.0)), (0.01235, 0.0));
    }
}
