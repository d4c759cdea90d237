//! Planning: what a build is to trace, before it does. In: a build's scene and receivers, what is wished. Out: a plan, with the forecast and
//! the choice of settings that it rests on.

use crate::accuracy::conditions::ErrorConditions;
use crate::accuracy::{PilotRequest, SettingsChoice, choose};
use crate::build::{Build, Forecast, Plan};
use crate::settings::{BuildSettings, EffectChoice};
use heliotile_core::error::Result;

/// What is wished of a build.
pub struct PlanRequest<'a> {
    /// Settings to begin with; what they leave out is decided anew.
    pub settings: BuildSettings,
    /// Which light paths to trace.
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

/// A plan and what it rests on.
#[derive(Clone, Debug)]
pub struct PlanReport {
    /// What to build.
    pub plan: Plan,
    /// What that would trace, effect by effect.
    pub forecast: Forecast,
    /// Only where settings were chosen for an error.
    pub choice: Option<SettingsChoice>,
}

impl Build<'_> {
    /// Decides on what is left out and, where an error is given, on settings.
    pub fn plan(&mut self, request: &PlanRequest) -> Result<PlanReport> {
        let first = self.forecast(&request.settings, request.effects)?;
        let Some(target) = request.target else {
            let settings = BuildSettings { left_out: first.left_out, ..request.settings };
            return Ok(PlanReport { plan: Plan::of(settings), forecast: first, choice: None });
        };
        let pilot = PilotRequest { target_percent: target.percent, suns: target.suns, left_out: first.left_out };
        let choice = choose(self, &pilot)?;
        let forecast = self.forecast(&choice.settings, request.effects)?;
        let settings = BuildSettings { left_out: forecast.left_out, ..choice.settings };
        Ok(PlanReport {
            plan: Plan { settings, accuracy: Some(choice.accuracy.clone()) },
            forecast,
            choice: Some(choice),
        })
    }
}
