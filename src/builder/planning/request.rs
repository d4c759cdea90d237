//! Request of a user for a build. In: the accuracy wanted, light paths, weather. Out: a plan, an
//! archive, and reports of both to an observer.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{EffectsUnder, ErrorTarget, PlanReport, PlanRequest, tables};
use crate::accuracy::conditions::ErrorConditions;
use crate::pipeline::{Build, BuildReport, Output, Plan, ReusedArchives};
use crate::settings::{BuildSettings, EffectChoice, Quality, Rungs, Share};
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::{Observer, Tone};
use heliotile_core::replay::schedule_csv::ReadFile;
use heliotile_core::units::parse_percent;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_files::writing::claim::same_place;
use heliotile_requests::Request;
use heliotile_scene::Scene;

/// Accuracy that a user wants of a build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Request)]
#[serde(deny_unknown_fields)]
pub struct AccuracyRequest {
    /// Accuracy level: a named set of settings, from fast to accurate.
    #[serde(default)]
    #[field(default = "standard", conflicts("error"))]
    pub quality: Quality,
    /// Change one setting of the accuracy level, such as hit=16 or sky_fine=512; `info`
    /// of an archive lists the settings; may be repeated.
    #[serde(default)]
    #[field(metavar = "NAME=VALUE", python = "settings")]
    pub set: Vec<String>,
    /// Largest error to accept, the RMSE of hourly totals in percent of their mean, such as 2%:
    /// settings are tried on some of the receivers, and the cheapest that keep it are used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "PERCENT", conflicts("set"), parse = parse_error)]
    pub error_percent: Option<f64>,
    /// Weather file under which the errors of --error are estimated [default: suns from all sides].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "FILE", requires("error"), input = Weather)]
    pub error_weather: Option<PathBuf>,
    /// Options for reading the weather file.
    #[serde(default, skip_serializing_if = "says_nothing")]
    #[field(skip)]
    pub weather_options: WeatherOptions,
}

fn says_nothing(options: &WeatherOptions) -> bool {
    *options == WeatherOptions::default()
}

impl AccuracyRequest {
    /// Error targets that a user can ask for, percent. Below the lowest one, 32-bit textures and
    /// the sun's disc matter more than the weather.
    pub const ERRORS: RangeInclusive<f64> = 0.1..=50.0;

    /// Returns the settings of the rung with those that are set by name. Fails for a name or number
    /// that is not valid.
    pub fn settings(&self) -> Result<BuildSettings> {
        if self.error_percent.is_some_and(|percent| !Self::ERRORS.contains(&percent)) {
            let hint = format!("give {} to {} percent", Self::ERRORS.start(), Self::ERRORS.end());
            return Err(Error::argument("error", "is not a possible target", hint));
        }
        let mut settings = Rungs::new(self.quality).settings();
        self.set.iter().try_for_each(|text| settings.set(text))?;
        settings.check()?;
        Ok(settings)
    }
}

impl AccuracyRequest {
    /// Returns the request of a command that reads `weather` too, with statements about it. They
    /// describe the weather file for errors only if that is the same file, or if the command reads
    /// no other.
    #[must_use]
    pub fn beside(&self, weather: Option<&Path>, about: &WeatherOptions) -> AccuracyRequest {
        let of_errors = self.error_weather.as_deref();
        let is_same = |weather: &Path| of_errors.is_some_and(|of_errors| same_place(of_errors, weather));
        let is_stated = self.weather_options != WeatherOptions::default();
        let weather_options = match is_stated || !weather.is_none_or(is_same) {
            true => self.weather_options,
            false => WeatherOptions { with_air: false, ..*about },
        };
        AccuracyRequest { weather_options, ..self.clone() }
    }
}

/// Request for a build.
pub struct BuildRequest<'a> {
    /// Accuracy wanted.
    pub accuracy: &'a AccuracyRequest,
    /// Sharing of probes among receivers.
    pub share: Share,
    /// Light paths to trace.
    pub effects: EffectChoice,
    /// Weather under which losses by effect are estimated; `None` skips the estimate.
    pub under: Option<EffectsUnder<'a>>,
    /// True if the archive holds the scene's triangles.
    pub with_scene: bool,
    /// Archive of the scene before it was changed. Layers that the change does not alter are copied
    /// from it.
    pub from: Option<&'a Archive>,
    /// Function that reads the weather of an error target.
    pub files: ReadFile<'a>,
}

/// Plan and report of a finished build.
#[derive(Clone, Debug)]
pub struct BuildDone {
    /// Settings and their estimated error.
    pub plan: Plan,
    /// Counts, seconds, bytes.
    pub report: BuildReport,
}

impl Build<'_> {
    /// Decides what is traced. If an error target is given, the observer gets the chosen settings.
    pub fn decide(&mut self, request: &BuildRequest) -> Result<PlanReport> {
        let accuracy = request.accuracy;
        let read = |percent| {
            let (file, place) = (accuracy.error_weather.as_deref(), self.scene.scene.place);
            let suns = ErrorConditions::read(file, &accuracy.weather_options, place, request.files, self.observer)?;
            Ok((percent, suns))
        };
        let target = accuracy.error_percent.map(read).transpose()?;
        let target = target.as_ref().map(|(percent, suns)| ErrorTarget { percent: *percent, suns });
        let settings = BuildSettings { share: request.share, ..accuracy.settings()? };
        let plan = PlanRequest { settings, effects: request.effects, under: request.under, target };
        let plan = self.plan(&plan).map_err(|error| match error {
            // The files of the trial are removed, so the message names no file.
            Error::Stopped { .. } => Error::Stopped { what: "while settings were tried".into() },
            error => error,
        })?;
        if let Some(choice) = &plan.choice {
            self.observer.detail(tables::choice(choice));
        }
        Ok(plan)
    }

    /// Plans and builds. The observer gets the plan and the error that was found; the report waits
    /// for [`BuildReport::tell`].
    pub fn plan_and_write(mut self, request: &BuildRequest, output: &Output) -> Result<BuildDone> {
        let planned = self.decide(request)?;
        let observer = self.observer;
        observer.detail(tables::forecast(&planned.forecast));
        planned.losses.iter().for_each(|losses| observer.detail(tables::losses(losses)));
        let plan = &Plan { with_scene: request.with_scene, ..planned.plan.clone() };
        let sources = ReusedArchives { earlier: None, before: request.from };
        let report = self.write(plan, output, &sources)?;
        if let Some(choice) = &planned.choice {
            observer.report(tables::outcome(choice));
            observer.detail(tables::time(choice, planned.forecast.seconds(), &report));
        }
        Ok(BuildDone { plan: planned.plan, report })
    }
}

impl BuildReport {
    /// Hands on the warnings and notes, the summary of the archive as `tone` says, and its details.
    pub fn tell(&self, scene: &Scene, output: &Path, tone: Tone, observer: &dyn Observer) {
        self.warnings.iter().for_each(|warning| observer.warn(warning));
        tables::lost_in_mirrors(self).iter().for_each(|lost| observer.note(lost));
        observer.tell(tone, tables::summary(self, output).into());
        observer.detail(tables::work(self, scene));
    }
}

/// Smallest share that may be left out, percent: below, noise of the reference path tracer exceeds
/// the light.
const MIN_NEGLIGIBLE: f64 = 0.001;

fn parse_error(text: &str) -> std::result::Result<f64, String> {
    let (least, most) = (AccuracyRequest::ERRORS.start(), AccuracyRequest::ERRORS.end());
    parse_percent(text, *least..=*most)
        .ok_or_else(|| format!("`{text}` is not a possible largest error: give {least} to {most} percent, as in 2%"))
}

/// Reads the share of light that may be left out, percent: `0.5%`.
pub fn parse_negligible(text: &str) -> std::result::Result<f64, String> {
    let most = AccuracyRequest::ERRORS.end();
    parse_percent(text, MIN_NEGLIGIBLE..=*most).ok_or_else(|| {
        format!("`{text}` is not a share that can be left out: give {MIN_NEGLIGIBLE} to {most} percent, as in 0.5%")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::weather::time::clock_zone::ClockZone;

    /// `weather_options` are in the JSON only if they differ from the default: 1 of 2 requests.
    #[test]
    fn only_stated_weather_options_are_kept() {
        let plain = AccuracyRequest { error_percent: Some(2.0), ..AccuracyRequest::default() };
        let weather_options = WeatherOptions { zone: Some(ClockZone::Hours(1.0)), ..WeatherOptions::default() };
        let clocked = AccuracyRequest { weather_options, ..plain.clone() };
        for (request, says) in [(plain, false), (clocked, true)] {
            let text = serde_json::to_string(&request).expect("JSON");
            assert_eq!(text.contains("weather_options"), says, "{text}");
            assert_eq!(serde_json::from_str::<AccuracyRequest>(&text).expect("a request"), request);
        }
    }
}
