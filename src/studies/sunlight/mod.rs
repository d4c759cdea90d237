//! Hours of possible sun, and rules about them. In: archives, dates, rules. Out: tables, maps and
//! pictures of minutes by day or period, or of the verdict of each rule on each place.
//!
//! Nothing is replayed: the path of the sun is followed through the sky textures
//! ([`heliotile_sunlight`]). Clouds count only for rules of probable hours and, with weather, for
//! irradiance of glare. Leaves and screens hide the sun only if the request says so.

mod calendar;
mod columns;
pub(crate) mod days;
pub(crate) mod exact;
mod former;
mod glare;
mod groups;
mod measure;
mod panes;
mod pass;
pub(crate) mod places;
mod request;
mod rule;
pub(crate) mod rule_files;
mod trees;

pub use calendar::DaySpan;
pub use glare::GlareChoice;
pub use heliotile_core::weather::time::clock_zone::ClockZone;
pub use request::{RuleCount, SunlightDone, SunlightRequest, SunlightSite};
pub use rule::{ClockHours, DaysTogether, LitPart, Rule, RuleClock, RuleMeasure, Threshold};
pub use rule_files::{ShippedRules, own_rules, shipped_rules, shipped_with};
pub use trees::TreeShade;
