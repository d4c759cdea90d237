//! Accuracy as one number. In: a scene, its receivers and a target in percent. Out: the cheapest
//! settings that keep within it, their expected error and their measured error.
//!
//! A spread sample of the receivers is divided in two. The pilot is built with a few settings, and
//! the distances between the results give the error of every rung of each ladder ([`estimate`]).
//! The check is built with the chosen settings and compared with the independent [reference path
//! tracer](crate::reference), in all hours and in those when the sun lights what receivers see but
//! not the receivers. If the total or reflected light alone exceeds the target there, finer
//! settings are chosen by the errors found for each source. Nothing depends on the machine, so the
//! same site and target give the same settings and the same archive.

pub mod conditions;
pub mod estimate;
pub mod reference_sample;
pub mod trial;

#[cfg(test)]
mod well_tests;

use std::time::Instant;

use crate::pipeline::Build;
use crate::receiver_tiles::ReceiverTiles;
use crate::settings::ladder::{BOUNCED_RUNGS, SEEN_RUNGS, SKY_RUNGS};
use crate::settings::{BuildSettings, Effects, Rungs, patches};
use conditions::ErrorConditions;
use estimate::{Errors, patch_errors, rung};
use heliotile_archives::Workspace;
use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::Stage;
use heliotile_core::site::receiver::{Receiver, TILE};
use reference_sample::{ReferenceSample, rounded};
use trial::{Bench, ErrorSource, Trial};

/// Receivers of the site per receiver of the pilot; [`CHECKED_SHARE`] is that number for the check.
/// The other constants limit both. The check is larger because it is built only once or a few
/// times, and shows errors that few receivers of a site have.
const SHARE: usize = 16;
const CHECKED_SHARE: usize = 4;
const MIN: usize = 20;
const MAX: usize = 32;
const MIN_CHECKED: usize = 64;
const MAX_CHECKED: usize = 128;

/// Number of suns and skies of an estimate.
pub const CONDITIONS: usize = 256;

/// Number of receivers times conditions of the check; [`MAX_CONDITIONS`] limits the conditions.
/// With few conditions hardly any of few receivers would have a shadow's edge.
const CHECKED_PAIRS: usize = 32_768;
const MAX_CONDITIONS: usize = 1024;

/// Share of the target from which on a source is tried with finer settings.
const MATTERS: f64 = 0.35;

/// Finest rung of bounces in the pilot. Finer bounces cost more than the rest of a build on a large
/// site.
const FINEST_PILOT_BOUNCES: usize = 4;

/// Largest number of rounds of choosing and trying.
const ROUNDS: usize = 3;

/// Request for settings that keep within an error.
pub struct PilotRequest<'a> {
    /// Largest RMSE of hourly totals, percent of their mean.
    pub target_percent: f64,
    /// Conditions under which errors are estimated.
    pub suns: &'a ErrorConditions,
    /// Effects that no build of the pilot traces.
    pub left_out: Effects,
}

/// Settings chosen for an error, and their estimated and measured errors.
#[derive(Clone, Debug)]
pub struct SettingsChoice {
    /// Cheapest settings that keep within the target, as far as is known.
    pub settings: BuildSettings,
    /// Measured error, for the manifest.
    pub accuracy: Accuracy,
    /// Expected RMSE of each source, percent of the mean total: [`ErrorSource::ALL`], then the sky
    /// patches.
    pub sources_percent: [f64; 4],
    /// Seconds that the pilot took.
    pub pilot_s: f64,
}

/// Returns receivers spread evenly over the site, with the tiles that they will lie in.
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

/// Returns the cheapest settings that keep within an error, by building samples of the receivers
/// with several settings.
pub fn choose(build: &mut Build, wish: &PilotRequest) -> Result<SettingsChoice> {
    let started = Instant::now();
    let count = build.receivers.count();
    let pilots = (count / SHARE).clamp(MIN, MAX).min(count.div_ceil(2));
    let checked = (count / CHECKED_SHARE).clamp(MIN_CHECKED, MAX_CHECKED).min(count - pilots);
    // All receivers of a small site are checked, including the pilot.
    let whole = count <= MIN_CHECKED;
    let sample = sample(build.receivers, pilots + checked)?;
    let is_pilot = |i: usize| (i + 1) * pilots / sample.len() > i * pilots / sample.len();
    let (mut piloted, mut checked) = (Vec::new(), Vec::new());
    for (i, (tile, receiver)) in sample.iter().enumerate() {
        if is_pilot(i) {
            piloted.push(receiver.clone());
        }
        if whole || !is_pilot(i) {
            checked.push((*tile, receiver.clone()));
        }
    }
    let many = (CHECKED_PAIRS / checked.len().max(1)).clamp(CONDITIONS, MAX_CONDITIONS);
    // Powers of two, because altitudes of the suns are then even.
    let conditions = [CONDITIONS, 1 << many.ilog2()].map(|count| wish.suns.some(count));
    let parts: [Vec<Receiver>; 2] = [piloted, checked.iter().map(|s| s.1.clone()).collect()];
    let Workspace { folder, memory } = build.workspace;
    let trials = tempfile::Builder::new().prefix("heliotile-pilot").tempdir_in(folder);
    let trials = trials.map_err(Error::io(folder, "make a folder in"))?;
    let workspace = Workspace { folder: trials.path().to_path_buf(), memory: *memory };
    let bench = |part: usize| Bench {
        scene: build.scene,
        receivers: &parts[part],
        conditions: &conditions[part],
        workspace: &workspace,
        observer: build.observer,
    };
    let settings = |rungs: Rungs| BuildSettings { left_out: wish.left_out, ..rungs.settings() };
    let progress = Stage::begin(build.observer, "pilot", None);
    let try_out = |part: usize, rungs: Rungs| -> Result<(Rungs, Trial)> {
        let trial = bench(part).trial(settings(rungs))?;
        progress.advance(1);
        Ok((rungs, trial))
    };

    let first = [1, 2].map(|rung| Rungs { sky: rung, seen: rung, bounced: rung, patches: 1 });
    let mut trials = vec![try_out(0, first[0])?];
    let (mut finest, mut truth) = try_out(0, first[1])?;
    let archive = &truth.archive;
    let [fewest, _, most] = patches();
    let lights = [bench(0).light(archive, fewest)?, truth.light.clone(), bench(0).light(archive, most)?];
    let patches = patch_errors(&lights);
    let mut errors = Errors::new(&trials, finest, &truth, patches);
    let mut chosen = errors.cheapest(wish.target_percent, None);
    let mut finer = finer(chosen, &errors, wish.target_percent);
    for _ in 0..ROUNDS {
        let (rungs, trial) = try_out(0, finer)?;
        trials.push((std::mem::replace(&mut finest, rungs), std::mem::replace(&mut truth, trial)));
        errors = Errors::new(&trials, finest, &truth, patches);
        let again = errors.cheapest(wish.target_percent, None);
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

    let of_checked: Vec<u32> = checked.iter().map(|s| s.0).collect();
    let tile = |i: usize| of_checked.get(i).copied().unwrap_or_default();
    let (_, mut here) = try_out(1, chosen)?;
    let reference = ReferenceSample::new(&bench(1), wish.left_out, wish.target_percent)?.with_hours(&here.light);
    let mut round = 0;
    let accuracy = loop {
        let (accuracy, found) = (reference.accuracy(&here.light, tile), reference.sources(&here.light));
        let keeps = accuracy.rmse_percent <= wish.target_percent && found.lit_percent <= wish.target_percent;
        round += 1;
        if keeps || round == ROUNDS {
            break accuracy;
        }
        let mut learned = errors.clone();
        learned.learn(chosen, &found);
        let again = learned.cheapest(wish.target_percent, Some(chosen));
        if again == chosen {
            break accuracy;
        }
        (chosen, errors) = (again, learned);
        here = try_out(1, chosen)?.1;
    };
    drop(progress);

    let accuracy = Accuracy {
        target_percent: wish.target_percent,
        predicted_percent: rounded(errors.total(chosen)),
        conditions: conditions[1].len() as u64,
        weather: wish.suns.name().into(),
        ..accuracy
    };
    let [sky, seen, bounced] = ErrorSource::ALL.map(|source| errors.at(chosen, source));
    let sources_percent = [sky, seen, bounced, patches[chosen.patches]];
    let pilot_s = started.elapsed().as_secs_f64();
    Ok(SettingsChoice { settings: settings(chosen), accuracy, sources_percent, pilot_s })
}

/// Returns the rungs to compare some rungs with: one rung finer for each source whose error
/// matters.
fn finer(rungs: Rungs, errors: &Errors, target_percent: f64) -> Rungs {
    let up = |source: ErrorSource, length: usize| {
        let at = rung(rungs, source);
        if errors.at(rungs, source) > MATTERS * target_percent { (at + 1).min(length - 1) } else { at }
    };
    let fine = |sky: usize| Rungs { sky, ..rungs }.settings().sky_fine;
    Rungs {
        // Skies cost little.
        sky: (2..SKY_RUNGS).find(|&sky| fine(sky) > fine(rungs.sky)).unwrap_or(SKY_RUNGS - 1),
        // From this rung on hit rays differ from those of the first trial.
        seen: up(ErrorSource::Seen, SEEN_RUNGS).max(3),
        bounced: up(ErrorSource::Bounced, BOUNCED_RUNGS).min(FINEST_PILOT_BOUNCES.max(rungs.bounced)).max(2),
        patches: rungs.patches,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// 10 of 100 receivers are every tenth, in order. Tiles hold 64, so the first 7 lie in tile 0.
    /// A sample of 10 out of 3 is all 3.
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
    fn rounding_keeps_four_digits() {
        assert_eq!((rounded(0.012_345_6), rounded(0.0)), (0.01235, 0.0));
    }
}
