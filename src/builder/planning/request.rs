//! A build as a user asks for it. In: how exact it is to be, which light paths, under which weather. Out: a plan, an archive, and what an observer
//! is told about both.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{EffectsUnder, ErrorTarget, PlanReport, PlanRequest, tables};
use crate::accuracy::conditions::ErrorConditions;
use crate::pipeline::{Build, BuildReport, Output, Plan, ReusedArchives};
use crate::settings::{BuildSettings, EffectChoice, Quality, Rungs, Share};
use crate::store::{Folder, Store, StoreKey, open_all};
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::weather::options::WeatherOptions;

/// How exact a build is to be.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AccuracyRequest {
    /// Rung of the accuracy ladder.
    #[serde(default)]
    pub quality: Quality,
    /// Settings by name that differ from those of the rung, `hit=16`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Largest RMSE of hourly totals, percent of their mean. A pilot chooses the settings then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_percent: Option<f64>,
    /// Weather file that errors are estimated under; none: suns from all sides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_weather: Option<PathBuf>,
    /// How that file is read.
    #[serde(default, skip_serializing_if = "says_nothing")]
    pub weather_options: WeatherOptions,
}

fn says_nothing(options: &WeatherOptions) -> bool {
    *options == WeatherOptions::default()
}

impl AccuracyRequest {
    /// Errors that can be asked for, percent: below, 32-bit textures and the sun's disc say more than the weather does.
    pub const ERRORS: RangeInclusive<f64> = 0.1..=50.0;

    /// The settings of the rung with those that are set by name. An error: a name or a number that is not valid.
    pub fn settings(&self) -> Result<BuildSettings> {
        if self.error_percent.is_some_and(|percent| !Self::ERRORS.contains(&percent)) {
            let hint = format!("give {} to {} percent", Self::ERRORS.start(), Self::ERRORS.end());
            return Err(Error::argument("error", "is no error to aim at", hint));
        }
        let mut settings = Rungs::of(self.quality).settings();
        self.set.iter().try_for_each(|text| settings.set(text))?;
        settings.check()?;
        Ok(settings)
    }
}

/// What is asked of a build.
pub struct BuildRequest<'a> {
    /// How exact it is to be.
    pub accuracy: &'a AccuracyRequest,
    /// Which receivers share a probe.
    pub share: Share,
    /// Light paths to trace.
    pub effects: EffectChoice,
    /// Weather that effects are weighed under, where the scene decides.
    pub under: Option<EffectsUnder<'a>>,
    /// Whether the archive holds the scene's triangles.
    pub with_scene: bool,
    /// What earlier builds traced; the new archive is added.
    pub store: Option<Folder>,
    /// Archive of the scene before it was changed: what the change does not alter is taken from there.
    pub from: Option<&'a Archive>,
    /// Keep what the change can alter by less than so many percent; the archive is a preview then.
    pub preview_percent: Option<f64>,
}

/// Refuses a bound that no preview can have.
pub fn check_preview(percent: Option<f64>) -> Result<()> {
    if percent.is_none_or(|percent| PREVIEWS.contains(&percent)) {
        return Ok(());
    }
    let hint = format!("give {} to {} percent", PREVIEWS.start(), PREVIEWS.end());
    Err(Error::argument("preview", "is no bound for a preview", hint))
}

/// Bounds of previews, percent of the light on open ground.
pub const PREVIEWS: RangeInclusive<f64> = 0.01..=20.0;

/// What was planned and what was built.
#[derive(Clone, Debug)]
pub struct BuildDone {
    /// Settings, and the error that they were estimated to have.
    pub plan: Plan,
    /// Counts, seconds, bytes.
    pub report: BuildReport,
}

impl Build<'_> {
    /// Decides what is traced. The observer is told which settings were chosen, if an error is to be kept within.
    pub fn decide(&mut self, request: &BuildRequest) -> Result<PlanReport> {
        let accuracy = request.accuracy;
        let read = |percent| {
            let (file, place) = (accuracy.error_weather.as_deref(), self.scene.scene.place);
            let suns = ErrorConditions::read(file, &accuracy.weather_options, place, self.observer)?;
            Ok((percent, suns))
        };
        let target = accuracy.error_percent.map(read).transpose()?;
        let target = target.as_ref().map(|(percent, suns)| ErrorTarget { percent: *percent, suns });
        let settings = BuildSettings { share: request.share, ..accuracy.settings()? };
        let plan = PlanRequest { settings, effects: request.effects, under: request.under, target };
        let plan = self.plan(&plan).map_err(|error| match error {
            // What a trial had written is gone.
            Error::Stopped { .. } => Error::Stopped { what: "while settings were tried".into() },
            error => error,
        })?;
        if let Some(choice) = &plan.choice {
            self.observer.report(&tables::choice(choice));
        }
        Ok(plan)
    }

    /// Plans, builds, and tells the observer what is done.
    pub fn plan_and_write(mut self, request: &BuildRequest, output: &Output) -> Result<BuildDone> {
        check_preview(request.preview_percent)?;
        if request.preview_percent.is_some() && request.from.is_none() {
            return Err(Error::argument("preview", "asks for an archive of the scene before it was changed", "{from}"));
        }
        let planned = self.decide(request)?;
        let observer = self.observer;
        observer.report(&tables::forecast(&planned.forecast));
        planned.losses.iter().for_each(|losses| observer.report(&tables::losses(losses)));
        let (with_scene, preview_percent) = (request.with_scene, request.preview_percent);
        let plan = &Plan { with_scene, preview_percent, ..planned.plan.clone() };
        let scene = self.scene.scene;
        let key = StoreKey { scene: scene.content_hash(), settings: plan.settings.hash()? };
        let earlier = request.store.as_ref().map_or(Ok(Vec::new()), |store| open_all(store, &key, observer))?;
        let sources = ReusedArchives { earlier: &earlier, before: request.from };
        let report = self.write(plan, output, &sources)?;
        if let Some(store) = request.store.as_ref().filter(|_| report.preview.is_none()) {
            store.add(&key, &output.path, &report.root)?;
        }
        report.warnings.iter().for_each(|warning| observer.warn(warning));
        observer.report(&tables::summary(&report, scene, &output.path));
        if let Some(choice) = &planned.choice {
            let taken = report.seconds.iter().map(|stage| stage.1).sum();
            observer.report(&tables::outcome(choice, planned.forecast.seconds(), taken));
        }
        Ok(BuildDone { plan: planned.plan, report })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How weather is read stands in JSON where something is said of it, and not otherwise: 1 of 2.
    #[test]
    fn what_is_said_of_weather_is_kept() {
        let plain = AccuracyRequest { error_percent: Some(2.0), ..AccuracyRequest::default() };
        let weather_options = WeatherOptions { zone_hours: Some(1.0), ..WeatherOptions::default() };
        let clocked = AccuracyRequest { weather_options, ..plain.clone() };
        for (request, says) in [(plain, false), (clocked, true)] {
            let text = serde_json::to_string(&request).expect("JSON");
            assert_eq!(text.contains("weather_options"), says, "{text}");
            assert_eq!(serde_json::from_str::<AccuracyRequest>(&text).expect("a request"), request);
        }
    }
}
