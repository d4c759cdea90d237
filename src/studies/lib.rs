//! Studies of a site: requests that read a scene or trace rays, and their results. In: scenes,
//! weather, archives. Out: archives, folders of results, reports.
//!
//! | room | what it holds |
//! | --- | --- |
//! | [`covering`] | receivers on a scene's surfaces, and the table of these receivers |
//! | [`on_ground`] | receivers along lines, such as roads, and within areas, such as gardens |
//! | [`site_build`] | archive of a scene's receivers: planned, built, or kept in a folder |
//! | [`run`] | from scene files to a folder of a year's results in one go |
//! | [`pv`] | light on solar modules, and their best orientation |
//! | `people` | [`ComfortSiteRequest`]: the archive of people at points of a scene |
//! | `sunlight` | [`SunlightRequest`]: hours of possible sun, glare, and rules about either |
//! | `envelope` | [`EnvelopeRequest`]: the largest building that leaves places their sun |
//! | `checks` | [`AuditRequest`]: accuracy of an archive; [`RepairRequest`]: repair of an archive |
//! | `tradeoff` | [`TradeoffRequest`]: cost of accuracy on a site |
//! | `update` | [`UpdateRequest`]: an archive after edits of its scene |
//!
//! No code here prints or knows a command line. Messages go to an
//! [`Observer`](heliotile_core::observer::Observer); errors name fields of requests.

mod checks;
pub mod covering;
mod envelope;
pub mod on_ground;
mod people;
pub mod pv;
pub mod run;
pub mod site_build;
mod sunlight;
mod tradeoff;
mod update;

pub use checks::{
    AuditReport, AuditRequest, ComponentErrors, HourKindErrors, RepairDone, RepairRequest, SkyViewErrors, Verdict,
    WorstPair, is_time,
};
pub use covering::CoverRequest;
pub use envelope::{EnvelopeDone, EnvelopeRequest};
pub use people::ComfortSiteRequest;
pub use run::{RunDone, RunMap, RunRequest};
pub use site_build::{FolderOption, ReceiverSource, SiteArchiveRequest, SiteBuild, SiteFolder};
pub use sunlight::{
    ClockHours, ClockZone, DaySpan, DaysTogether, GlareChoice, LitPart, Rule, RuleClock, RuleCount, RuleMeasure,
    ShippedRules, SunlightDone, SunlightRequest, SunlightSite, Threshold, TreeShade, shipped_rules, shipped_with,
};
pub use tradeoff::{LadderStep, LadderTable, SettingPoint, TradeoffDone, TradeoffRequest};
pub use update::{UpdateDone, UpdateRequest};
