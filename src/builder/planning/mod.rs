//! Planning: decides what a build traces before it starts. In: the scene and receivers of a build,
//! a request. Out: a plan, with the forecast and the choice of settings behind it.

pub mod losses;
mod request;
pub mod tables;

use crate::accuracy::conditions::ErrorConditions;
use crate::accuracy::reference_sample::rounded;
use crate::accuracy::{PilotRequest, SettingsChoice, choose};
use crate::pipeline::{Build, Forecast, Plan};
use crate::settings::{BuildSettings, Effect, EffectChoice};
use heliotile_core::archive::negligible::Negligible;
use heliotile_core::error::Result;
use losses::YearLosses;

pub use request::{AccuracyRequest, BuildDone, BuildRequest, parse_negligible};

/// Request for a plan.
pub struct PlanRequest<'a> {
    /// Settings to begin with. Their left-out effects are decided anew.
    pub settings: BuildSettings,
    /// Light paths to trace.
    pub effects: EffectChoice,
    /// Weather under which losses by effect are estimated; `None` skips the estimate.
    pub under: Option<EffectsUnder<'a>>,
    /// Error target; a pilot then chooses the settings.
    pub target: Option<ErrorTarget<'a>>,
}

/// Weather under which losses by effect are estimated.
#[derive(Clone, Copy)]
pub struct EffectsUnder<'a> {
    /// The weather.
    pub weather: &'a ErrorConditions,
    /// Largest loss in any group of receivers, percent of its sum, for which [`EffectChoice::Auto`]
    /// leaves effects out; `None` only reports the losses.
    pub negligible_percent: Option<f64>,
}

/// Error target of a build.
#[derive(Clone, Copy)]
pub struct ErrorTarget<'a> {
    /// Largest RMSE of hourly totals, percent of their mean.
    pub percent: f64,
    /// Weather or suns under which the error is estimated.
    pub suns: &'a ErrorConditions,
}

/// Plan and the estimates behind it.
#[derive(Clone, Debug)]
pub struct PlanReport {
    /// Settings and left-out effects of the build.
    pub plan: Plan,
    /// Forecast of the plan's work, effect by effect.
    pub forecast: Forecast,
    /// Losses by effect; `None` if no weather was given for them.
    pub losses: Option<YearLosses>,
    /// Choice of settings; `None` if no error target was given.
    pub choice: Option<SettingsChoice>,
}

impl Build<'_> {
    /// Decides which effects are left out and, if an error target is given, which settings are
    /// used.
    pub fn plan(&mut self, request: &PlanRequest) -> Result<PlanReport> {
        let losses = request.under.map(|under| YearLosses::new(self, under.weather)).transpose()?;
        let percent = request.under.and_then(|under| under.negligible_percent);
        let allowed = percent.filter(|_| request.effects == EffectChoice::Auto).zip(losses.as_ref());
        let known = allowed.map(|(percent, losses)| negligible(losses, percent));
        let mut forecast = self.forecast(&request.settings, request.effects, known.as_ref())?;
        let mut plan = Plan::new(BuildSettings { left_out: forecast.left_out, ..request.settings });
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
        // Effects that the scene does not have are not left out.
        let left_out = plan.settings.left_out.names();
        plan.negligible = known.and_then(|mut known| {
            known.bound_percent.retain(|name, _| left_out.contains(name));
            (!known.bound_percent.is_empty()).then_some(known)
        });
        Ok(PlanReport { plan, forecast, losses, choice })
    }
}

/// Returns the effects that may be left out under some weather, with their bounds.
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
