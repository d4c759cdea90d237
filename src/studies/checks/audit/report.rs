//! Report of an audit. In: pairs of results and reference values, the error that the archive
//! states. Out: errors by component, by sky view and by kind of hours, and the verdict.

use std::path::PathBuf;

use serde::Serialize;

use heliotile_builder::accuracy::reference_sample::percent;
use heliotile_builder::reference::comparison::{ConfidenceInterval, Deviation, Pair, deviation, mean_w_m2, off};
use heliotile_builder::reference::groups::by_sky_view;
use heliotile_builder::reference::hours::{HoursFound, mix_of};
use heliotile_builder::reference::{Audited, PARTS};
use heliotile_core::archive::Archive;
use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::observer::Observer;
use heliotile_core::replay::components::Component;
use heliotile_core::weather::conditions::Condition;

/// Factor by which a found error must exceed the stated one to refute it, as the stated error is an
/// estimate.
const STATED_WITHIN: f64 = 1.5;

/// Verdict of an audit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The archive states no error.
    NothingStated,
    /// The error that was found does not contradict the stated one.
    Holds,
    /// The error that was found is larger than the stated one.
    Refuted,
}

/// Report of an audit.
#[derive(Serialize)]
pub struct AuditReport {
    /// Path of the archive.
    pub archive: PathBuf,
    /// File of weather or conditions, or the suns and skies in words.
    pub weather: String,
    /// Number of receivers that were checked.
    pub receivers: usize,
    /// Number of hours that were checked, all receivers together.
    pub hours: usize,
    /// Mean of the reference path tracer's totals, W/m2.
    pub mean_w_m2: f64,
    /// Verdict on the error that the archive states.
    pub verdict: Verdict,
    /// Verdict in words.
    pub sentence: String,
    /// Stated RMSE of the totals in these hours, percent of their mean.
    pub stated_percent: Option<f64>,
    /// Errors of the six components and of the total.
    pub components: Vec<ComponentErrors>,
    /// Errors of groups of receivers with similar sky view.
    pub sky_views: Vec<SkyViewErrors>,
    /// Errors by kind of hours, in which errors of reflected light show.
    pub hour_kinds: Vec<HourKindErrors>,
    #[serde(skip)]
    pub(super) audited: Audited,
    #[serde(skip)]
    pub(super) conditions: Vec<Condition>,
}

/// Errors of a component or of the total, each with its interval of 95 %.
#[derive(Clone, Debug, Serialize)]
pub struct ComponentErrors {
    /// Name of the component's column.
    pub component: &'static str,
    /// Mean difference, W/m2, above 0 if the archive's results are too large.
    pub bias_w_m2: ConfidenceInterval,
    /// Root of the mean squared difference, W/m2.
    pub rmse_w_m2: ConfidenceInterval,
    /// Bias in percent of the mean total.
    pub bias_percent: ConfidenceInterval,
    /// RMSE in percent of the mean total.
    pub rmse_percent: ConfidenceInterval,
    /// Hour of a receiver with the largest difference beyond the reference path tracer's noise.
    pub worst: Option<WorstPair>,
}

/// Hour of a receiver, with its difference.
#[derive(Clone, Debug, Serialize)]
pub struct WorstPair {
    /// Name of the receiver.
    pub receiver: String,
    /// Label of the condition.
    pub condition: String,
    /// Result of the archive minus the reference value, W/m2.
    pub off_w_m2: f64,
    /// Reference value, W/m2.
    pub reference_w_m2: f64,
    /// Standard error of the reference value, W/m2.
    pub standard_error_w_m2: f64,
}

/// Errors of the totals of receivers with similar sky view.
#[derive(Clone, Debug, Serialize)]
pub struct SkyViewErrors {
    /// Smallest, mean and largest share of their hemispheres that is sky.
    pub sky_view: [f64; 3],
    /// Mean of the reference path tracer's totals, W/m2.
    pub mean_w_m2: f64,
    /// RMSE of the totals, W/m2.
    pub rmse_w_m2: ConfidenceInterval,
}

/// Errors of the totals in hours of one kind.
#[derive(Clone, Debug, Serialize)]
pub struct HourKindErrors {
    /// Name of the kind.
    pub kind: &'static str,
    /// Share of all hours of all receivers.
    pub share: f64,
    /// Mean of the reference path tracer's totals, W/m2.
    pub mean_w_m2: f64,
    /// RMSE of the totals, W/m2.
    pub rmse_w_m2: ConfidenceInterval,
    /// Stated RMSE of these hours, percent of their mean.
    pub stated_percent: Option<f64>,
}

impl HourKindErrors {
    fn new(found: &HoursFound, stated: Option<&Accuracy>) -> Self {
        let (kind, mean_w_m2) = (found.kind.name(), found.mean_w_m2);
        let stated = stated.filter(|stated| stated.hours.iter().any(|hours| hours.hours == kind));
        let stated_percent = stated.map(|stated| percent(stated.expected_w_m2(&found.mix, mean_w_m2), mean_w_m2));
        HourKindErrors { kind, share: found.share, mean_w_m2, rmse_w_m2: found.rmse_w_m2, stated_percent }
    }

    /// Returns true if the lower end of the error's interval exceeds the stated error by more than
    /// the factor [`STATED_WITHIN`].
    fn is_refuted(&self) -> bool {
        let low = percent(self.rmse_w_m2.low, self.mean_w_m2);
        self.stated_percent.is_some_and(|stated| low > STATED_WITHIN * stated)
    }
}

impl AuditReport {
    pub(super) fn new(
        archive: &Archive,
        audited: Audited,
        conditions: Vec<Condition>,
        weather: String,
        observer: &dyn Observer,
    ) -> Self {
        let (stated, mean_w_m2) = (archive.manifest().accuracy.as_ref(), mean_w_m2(&audited.pairs));
        let component = |part: Component| {
            let Deviation { bias_w_m2, rmse_w_m2, worst } = deviation(&audited.pairs, &audited.suns, part as usize);
            let of_mean = |known: ConfidenceInterval| in_percent(known, mean_w_m2);
            let worst = worst.map(|pair| WorstPair {
                receiver: audited.receivers[pair.receiver].0.id.clone(),
                condition: conditions[pair.condition].label.clone(),
                off_w_m2: off(&pair, part as usize),
                reference_w_m2: pair.reference.mean[part as usize],
                standard_error_w_m2: pair.reference.error[part as usize],
            });
            let (bias_percent, rmse_percent) = (of_mean(bias_w_m2), of_mean(rmse_w_m2));
            ComponentErrors { component: part.name(), bias_w_m2, rmse_w_m2, bias_percent, rmse_percent, worst }
        };
        let stated_percent =
            stated.map(|stated| percent(stated.expected_w_m2(&mix_of(&audited.pairs), mean_w_m2), mean_w_m2));
        let hour_kinds: Vec<HourKindErrors> =
            audited.hours.found().iter().map(|found| HourKindErrors::new(found, stated)).collect();
        let mut report = AuditReport {
            archive: archive.path().to_path_buf(),
            weather,
            receivers: audited.receivers.len(),
            hours: audited.pairs.len(),
            mean_w_m2,
            verdict: Verdict::Holds,
            sentence: String::new(),
            stated_percent,
            components: Component::ALL[..PARTS].iter().copied().map(component).collect(),
            sky_views: sky_views(&audited),
            hour_kinds,
            audited,
            conditions,
        };
        report.set_verdict(observer);
        report
    }

    /// Returns the errors of the total.
    pub fn total(&self) -> &ComponentErrors {
        &self.components[PARTS - 1]
    }

    /// Sets the verdict, and its sentence in the observer's words.
    fn set_verdict(&mut self, observer: &dyn Observer) {
        let refuted: Vec<&str> = self.hour_kinds.iter().filter(|of| of.is_refuted()).map(|of| of.kind).collect();
        let is_exceeded = |stated: f64| self.total().rmse_percent.low > STATED_WITHIN * stated;
        (self.verdict, self.sentence) = match self.stated_percent {
            None => {
                let sentence =
                    observer.in_words(&"the archive states no error: `build {error} 2%` would state one".into());
                (Verdict::NothingStated, sentence)
            }
            Some(stated) if !is_exceeded(stated) && refuted.is_empty() => {
                (Verdict::Holds, format!("stated: {stated:.2} %: not refuted"))
            }
            Some(stated) => {
                let hours = match refuted.is_empty() {
                    true => String::new(),
                    false => format!(" in hours of: {}", refuted.join(", ")),
                };
                let sentence = format!(
                    "stated: {stated:.2} %: REFUTED, the error is more than {STATED_WITHIN} times as large{hours}"
                );
                (Verdict::Refuted, sentence)
            }
        };
    }
}

/// Returns a number in percent of a mean.
pub(super) fn in_percent(known: ConfidenceInterval, mean_w_m2: f64) -> ConfidenceInterval {
    known.times(if mean_w_m2 > 0.0 { 100.0 / mean_w_m2 } else { 0.0 })
}

fn sky_views(audited: &Audited) -> Vec<SkyViewErrors> {
    let views: Vec<f64> = audited.receivers.iter().map(|receiver| receiver.1).collect();
    let of_group = |group: &Vec<usize>| {
        let [low, high] = [group.first()?, group.last()?].map(|&i| views[i]);
        let middle = group.iter().map(|&i| views[i]).sum::<f64>() / group.len() as f64;
        let inside: Vec<Pair> = audited.pairs.iter().filter(|pair| group.contains(&pair.receiver)).copied().collect();
        let rmse_w_m2 = deviation(&inside, &audited.suns, PARTS - 1).rmse_w_m2;
        Some(SkyViewErrors { sky_view: [low, middle, high], mean_w_m2: mean_w_m2(&inside), rmse_w_m2 })
    };
    by_sky_view(&views).iter().filter_map(of_group).collect()
}
