//! Planning: what a build is to trace, before it does. In: a build's scene and receivers, what is wished. Out: a plan, with the forecast and
//! the choice of settings that it rests on.

pub mod losses;
mod request;
pub mod tables;

use crate::accuracy::conditions::ErrorConditions;
use crate::accuracy::judged::rounded;
use crate::accuracy::{PilotRequest, SettingsChoice, choose};
use crate::pipeline::{Build, Forecast, Plan};
use crate::settings::{BuildSettings, Effect, EffectChoice};
use heliotile_core::archive::negligible::Negligible;
use heliotile_core::error::Result;
use losses::YearLosses;

pub use request::{AccuracyRequest, BuildDone, BuildRequest, PREVIEWS, check_preview};

/// What is wished of a build.
pub struct PlanRequest<'a> {
    /// Settings to begin with; what they leave out is decided anew.
    pub settings: BuildSettings,
    /// Which light paths to trace.
    pub effects: EffectChoice,
    /// Weather that effects are weighed under.
    pub under: Option<EffectsUnder<'a>>,
    /// An error to keep within; settings are then chosen by a pilot.
    pub target: Option<ErrorTarget<'a>>,
}

/// Weather that effects are weighed under.
#[derive(Clone, Copy)]
pub struct EffectsUnder<'a> {
    /// The weather.
    pub weather: &'a ErrorConditions,
    /// What may be left out where the scene decides, percent of the sum of each group of receivers; `None` decides nothing.
    pub negligible_percent: Option<f64>,
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
    /// Only where effects were weighed under some weather.
    pub losses: Option<YearLosses>,
    /// Only where settings were chosen for an error.
    pub choice: Option<SettingsChoice>,
}

impl Build<'_> {
    /// Decides on what is left out and, where an error is given, on settings.
    pub fn plan(&mut self, request: &PlanRequest) -> Result<PlanReport> {
        let losses = request.under.map(|under| YearLosses::of(self, under.weather)).transpose()?;
        let percent = request.under.and_then(|under| under.negligible_percent);
        let allowed = percent.filter(|_| request.effects == EffectChoice::Auto).zip(losses.as_ref());
        let known = allowed.map(|(percent, losses)| negligible(losses, percent));
        let mut forecast = self.forecast(&request.settings, request.effects, known.as_ref())?;
        let mut plan = Plan::of(BuildSettings { left_out: forecast.left_out, ..request.settings });
        let mut choice = None;
        if let Some(target) = request.target {
            let left_out = forecast.left_out;
            let pilot = PilotRequest { target_percent: target.percent, suns: target.suns, left_out };
            let chosen = choose(self, &pilot)?;
            forecast = self.forecast(&chosen.settings, request.effects, known.as_ref())?;
            plan.settings = BuildSettings { left_out: forecast.left_out, ..chosen.settings };
            plan.accuracy = Some(chosen.accuracy.clone());
            choice = Some(chosen);
        }
        // What the scene has none of is not left out.
        let left_out = plan.settings.left_out.names();
        plan.negligible = known.and_then(|mut known| {
            known.bound_percent.retain(|name, _| left_out.contains(name));
            (!known.bound_percent.is_empty()).then_some(known)
        });
        Ok(PlanReport { plan, forecast, losses, choice })
    }
}

/// What may be left out under some weather.
fn negligible(losses: &YearLosses, percent: f64) -> Negligible {
    let without = losses.negligible(percent);
    let left_out = Effect::ALL.into_iter().filter(|effect| without.contains(*effect));
    let bound = |effect: Effect| (effect.name().to_string(), rounded(losses.worst_percent(effect)));
    Negligible {
        percent,
        weather: losses.weather.clone(),
        bound_percent: left_out.map(bound).collect(),
        ..Negligible::default()
    }
}
