//! Ladder of settings. In: a bench for trials. Out: errors, seconds and bytes of every step of the
//! ladder.

use std::collections::BTreeMap;

use cpu_time::ProcessTime;
use serde::{Serialize, Serializer};

use heliotile_archives::pack::COMPRESSION;
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::accuracy::reference_sample::ReferenceSample;
use heliotile_builder::accuracy::trial::{Bench, Trial};
use heliotile_builder::settings::BuildSettings;
use heliotile_builder::settings::ladder::Rungs;
use heliotile_builder::settings::{Effects, Quality};
use heliotile_core::archive::encode;
use heliotile_core::archive::{Access, Archive};
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::Stage;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::weather::time::bins::Bins;
use heliotile_files::spill::TempFiles;

/// Step of the ladder: settings with their cost and accuracy.
#[derive(Clone, Debug, Serialize)]
pub struct LadderStep {
    /// Name of the quality, or a list of the levels it is made of.
    pub name: String,
    /// Settings of the step; serialised by their names.
    #[serde(serialize_with = "by_name")]
    pub settings: BuildSettings,
    /// RMSE of hourly totals, percent of their mean.
    pub error_percent: f64,
    /// Mean difference of hourly totals, percent of their mean.
    pub bias_percent: f64,
    /// RMSE of means over all conditions, percent of the mean.
    pub yearly_percent: f64,
    /// RMSE of each component and of the total, by column, percent of the mean total.
    pub components_percent: BTreeMap<String, f64>,
    /// CPU seconds to trace.
    pub trace_s: f64,
    /// CPU seconds to compress.
    pub compress_s: f64,
    /// CPU seconds to replay a year of hours into sums.
    pub replay_s: f64,
    /// Number of rays that were traced.
    pub rays: u64,
    /// Length of the archive, bytes.
    pub bytes: u64,
    /// True if no other step is both faster and better.
    pub frontier: bool,
}

fn by_name<S: Serializer>(settings: &BuildSettings, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_map(settings.stated().numbers().map(|(setting, number)| (setting.name, number)))
}

impl LadderStep {
    fn new(name: String, trial: &Trial, reference: &ReferenceSample, compress_s: f64, replay_s: f64) -> Self {
        let found = reference.accuracy(&trial.light, |_| 0);
        LadderStep {
            name,
            settings: trial.settings,
            error_percent: found.rmse_percent,
            bias_percent: found.bias_percent,
            yearly_percent: found.yearly_percent,
            components_percent: found.components_percent,
            trace_s: (trial.build_s - compress_s).max(0.0),
            compress_s,
            replay_s,
            rays: trial.rays.total(),
            bytes: trial.bytes,
            frontier: false,
        }
    }

    /// Returns the CPU seconds of tracing, compressing and replaying.
    pub fn seconds(&self) -> f64 {
        self.trace_s + self.compress_s + self.replay_s
    }
}

/// Ladder of settings, measured on a site.
#[derive(Clone, Debug, Serialize)]
pub struct LadderTable {
    /// Steps from coarse to fine.
    pub steps: Vec<LadderStep>,
    /// Number of receivers that they were tried on.
    pub receivers: usize,
    /// Mean of hourly totals, W/m2.
    pub mean_w_m2: f64,
}

/// Target error, percent, for which the number of paths of the reference path tracer is chosen.
const REFERENCE_PERCENT: f64 = 0.5;

/// Returns the named qualities and some steps between them.
fn rungs() -> Vec<(String, Rungs)> {
    let named = |quality: Quality| (quality.name().to_string(), Rungs::new(quality));
    let between = |sky, seen, bounced, patches| {
        (format!("sky {sky}, seen {seen}, bounced {bounced}"), Rungs { sky, seen, bounced, patches })
    };
    vec![
        between(0, 0, 0, 0),
        named(Quality::Draft),
        between(2, 1, 1, 0),
        named(Quality::Standard),
        between(2, 3, 2, 1),
        named(Quality::Fine),
        between(4, 4, 3, 2),
        named(Quality::Reference),
    ]
}

impl LadderTable {
    /// Tries all steps on a bench.
    pub(super) fn climb(bench: &Bench, left_out: Effects, suns: &ErrorConditions) -> Result<Self> {
        let rungs = rungs();
        let progress = Stage::begin(bench.observer, "ladder", Some(rungs.len() as u64 + 1));
        let settings = |rungs: Rungs| BuildSettings { left_out, ..rungs.settings() };
        let reference = ReferenceSample::new(bench, left_out, REFERENCE_PERCENT)?;
        progress.advance(1);
        let mut steps = Vec::with_capacity(rungs.len());
        for (name, rungs) in rungs {
            let trial = bench.trial(settings(rungs))?;
            progress.advance(1);
            let (compress_s, replay_s) = (compression_s(&trial)?, replay_s(bench, &trial, suns)?);
            std::fs::remove_file(&trial.archive).map_err(Error::io(&trial.archive, "remove"))?;
            steps.push(LadderStep::new(name, &trial, &reference, compress_s, replay_s));
        }
        drop(progress);
        for i in 0..steps.len() {
            let here = (steps[i].seconds(), steps[i].error_percent);
            steps[i].frontier = !steps.iter().any(|other| other.seconds() < here.0 && other.error_percent < here.1);
        }
        Ok(LadderTable { steps, receivers: bench.receivers.len(), mean_w_m2: reference.mean_w_m2() })
    }

    /// Returns the step of the frontier that lies farthest below the line from its first to its
    /// last one, both axes logarithmic. Beyond it, another second gains less.
    pub fn knee(&self) -> Option<&LadderStep> {
        let frontier: Vec<&LadderStep> =
            self.steps.iter().filter(|s| s.frontier && s.error_percent > 0.0 && s.seconds() > 0.0).collect();
        let at = |step: &LadderStep| (step.seconds().ln(), step.error_percent.ln());
        let ((x0, y0), (x1, y1)) = (at(frontier.first()?), at(frontier.last()?));
        let below = |step: &&LadderStep| {
            let (x, y) = at(step);
            (x1 - x0) * (y0 - y) - (y0 - y1) * (x - x0)
        };
        frontier.iter().copied().max_by(|a, b| below(a).total_cmp(&below(b)))
    }

    /// Returns the ladder as a table for the terminal.
    pub fn table(&self) -> String {
        let mut out = format!(
            "{:<28}{:>8}{:>8}{:>8}{:>10}{:>10}{:>9}{:>11}{:>10}\n",
            "rung", "error %", "bias %", "year %", "trace s", "compress", "replay", "kB/receiver", "Mray"
        );
        for step in &self.steps {
            let name = format!("{}{}", step.name, if step.frontier { " *" } else { "" });
            out += &format!(
                "{name:<28}{:>8.2}{:>8.2}{:>8.2}{:>10.2}{:>10.2}{:>9.2}{:>11.2}{:>10.1}\n",
                step.error_percent,
                step.bias_percent,
                step.yearly_percent,
                step.trace_s,
                step.compress_s,
                step.replay_s,
                step.bytes as f64 / 1e3 / self.receivers as f64,
                step.rays as f64 / 1e6,
            );
        }
        out += &format!(
            "* no other rung is faster and better. {} receivers, CPU seconds, replay of a year of hours into sums; errors of hourly \
             totals in percent of their mean, {:.1} W/m2, against a reference path tracer\n",
            self.receivers, self.mean_w_m2
        );
        out
    }
}

/// Returns the CPU seconds to compress the blocks of an archive again.
fn compression_s(trial: &Trial) -> Result<f64> {
    let archive = Archive::open_with(&trial.archive, Access::Read)?;
    let mut seconds = 0.0;
    for entry in archive.entries() {
        let block = archive.block(entry.kind, entry.tile)?;
        let started = ProcessTime::now();
        encode(entry.kind, entry.tile, entry.schema, entry.items, block.bytes(), COMPRESSION)?;
        seconds += started.elapsed().as_secs_f64();
    }
    Ok(seconds)
}

/// Returns the CPU seconds to replay a year of hours into sums, with the sun positions and patches
/// of the step.
fn replay_s(bench: &Bench, trial: &Trial, suns: &ErrorConditions) -> Result<f64> {
    let conditions = suns.year(usize::from(trial.settings.steps));
    let started = ProcessTime::now();
    let archive = Archive::open_with(&trial.archive, Access::Read)?;
    let bins = Bins { count: 1, of_condition: vec![(0, 1e-3); conditions.len()] };
    let storage = TempFiles::new(&bench.workspace.folder);
    let settings = ReplaySettings {
        patches: trial.settings.patches,
        memory: bench.workspace.memory,
        storage: &storage,
        ..ReplaySettings::default()
    };
    let replay = Replay::builder(&OpenSite::open(&archive)?, &conditions, settings).summed(&bins).build()?;
    for tile in replay.results(0..replay.tiles()) {
        tile?;
    }
    Ok(started.elapsed().as_secs_f64())
}
