//! What is to be built. In: a scene's receivers and what is wished. Out: settings, with the forecast that they rest on.

use super::Build;
use super::forecast::Forecast;
use crate::accuracy::conditions::ErrorConditions;
use crate::accuracy::{PilotRequest, SettingsChoice, choose};
use crate::settings::{BuildSettings, EffectChoice};
use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::error::Result;

/// What is wished of a build.
pub struct PlanRequest<'a> {
    /// Settings to begin with; what they leave out is decided anew.
    pub settings: BuildSettings,
    /// Effects that are traced: what the scene calls for, or those of a list.
    pub effects: EffectChoice,
    /// An error to keep within; settings are then chosen by a pilot.
    pub target: Option<ErrorTarget<'a>>,
}

/// An error to keep within.
#[derive(Clone, Copy)]
pub struct ErrorTarget<'a> {
    /// Largest RMSE of hourly totals, percent of their mean.
    pub percent: f64,
    /// What it is estimated under.
    pub suns: &'a ErrorConditions,
}

/// What will be built.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What the build will use.
    pub settings: BuildSettings,
    /// What the settings are known to be off by, for the manifest.
    pub accuracy: Option<Accuracy>,
    /// Only where it was asked for.
    pub forecast: Option<Forecast>,
    /// Only where settings were chosen for an error.
    pub choice: Option<SettingsChoice>,
}

impl Plan {
    /// Settings that are taken as they are.
    pub fn of(settings: BuildSettings) -> Self {
        Plan { settings, accuracy: None, forecast: None, choice: None }
    }
}

impl Build<'_> {
    /// Decides on what is left out and, where an error is given, on settings.
    pub fn plan(&mut self, request: &PlanRequest) -> Result<Plan> {
        let first = self.forecast(&request.settings, request.effects)?;
        let Some(target) = request.target else {
            let settings = BuildSettings { left_out: first.left_out, ..request.settings };
            return Ok(Plan { forecast: Some(first), ..Plan::of(settings) });
        };
        let choice = choose(
            self,
            &PilotRequest { target_percent: target.percent, suns: target.suns, left_out: first.left_out },
        )?;
        let forecast = self.forecast(&choice.settings, request.effects)?;
        Ok(Plan {
            settings: BuildSettings { left_out: forecast.left_out, ..choice.settings },
            accuracy: Some(choice.accuracy.clone()),
            forecast: Some(forecast),
            choice: Some(choice),
        })
    }
}
