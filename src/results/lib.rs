//! Requests to archives, and the results they give. In: archives, requests. Out: tiles of
//! irradiance with their labels, and files of results.
//!
//! # Map
//!
//! | room | what it holds |
//! | --- | --- |
//! | `request` | [`QueryRequest`], [`ReplayRequest`], [`LightChoice`]: what a user asks for |
//! | `archives`, `receivers` | one archive or those of an atlas, and their chosen receivers |
//! | `bands` | [`BandChoice`]: light by band, in columns that follow those of all light |
//! | `own_skies` | [`SkyFiles`]: skies and clouds from files, put into conditions |
//! | `series` | conditions with labels, and coarser periods of them |
//! | `stream` | [`TileStream`], the only setup of replays; [`TileSink`] takes the tiles |
//! | `files` | [`FileRequest`]: tables, maps, charts, city models and Honeybee folders as sinks |
//! | `compare` | [`CompareRequest`]: the light that a change of a site adds or takes |
//! | `buildings`, `places`, `factors` | cadastre, places of modules, factors by sun position |
//! | `checks` | [`AuditRequest`]: accuracy of an archive; [`RepairRequest`]: repair of an archive |
//! | [`covering`] | receivers on a scene's surfaces, and the table of these receivers |
//! | [`site_build`] | archive of a scene's receivers: planned, built, or kept in a folder |
//! | [`pv`] | light on solar modules, and their best orientation |
//! | [`run`] | from scene files to a folder of a year's results in one go |
//! | `sky_components` | light of an overcast sky in percent of open ground |
//! | `comfort` | thermal comfort of people: [`ComfortRequest`], [`ComfortSiteRequest`] |
//! | `sunlight` | [`SunlightRequest`]: hours of possible sun, glare, and rules about either |
//! | `tradeoff` | [`TradeoffRequest`]: cost of accuracy on a site |
//! | `update` | [`UpdateRequest`]: an archive after edits of its scene |
//! | `viewer` | [`PageRequest`], [`open_after`]: HTML file with one archive, or two compared |
//! | [`horizon`], `doubts` | warnings that a user should know before results are used |
//! | [`outputs`] | writers of tables, maps, pictures and foreign formats |
//!
//! # What never happens
//!
//! - No code here prints or knows a command line. Messages go to an
//!   [`Observer`](heliotile_core::observer::Observer); errors name fields of requests.
//! - No incomplete file is left: a file is complete, or it is not there at all.

pub mod along;
mod archives;
mod bands;
mod buildings;
mod checks;
mod comfort;
mod compare;
pub mod covering;
mod doubts;
mod factors;
mod files;
pub mod horizon;
pub mod outputs;
mod own_skies;
mod places;
pub mod pv;
mod receivers;
mod request;
mod resources;
pub mod run;
mod series;
pub mod site_build;
mod sky_components;
mod stream;
mod sunlight;
mod tradeoff;
mod update;
mod viewer;

pub use archives::{Archives, Sources};
pub use bands::{BandChoice, BandList};
pub use buildings::{BuildingsRequest, BuildingsSummary};
pub use checks::{
    AuditReport, AuditRequest, ComponentErrors, HourKindErrors, RepairDone, RepairRequest, SkyViewErrors, Verdict,
    WorstPair, is_time,
};
pub use comfort::{
    ClassShare, ComfortChoice, ComfortColumn, ComfortDone, ComfortRequest, ComfortSiteRequest, Posture, SunOnPerson,
    SurfaceTemperatures, WindChoice,
};
pub use compare::{
    BeforeSide, CompareRequest, CompareSummary, Illumination, LOSSES_PERCENT, LossCounts, VariantSummary,
};
pub use covering::CoverRequest;
pub use factors::{FactorRows, FactorsRequest};
pub use files::{
    AreaChart, CityModelSink, FileRequest, MapFile, Question, ResultRows, ResultSink, RowsAbout, crs_of, name_of,
    surroundings,
};
pub use own_skies::{SkyChoice, SkyFiles};
pub use places::{PlaceOn, PlacesRequest, PlacesSummary};
pub use receivers::{PartReceivers, ReceiverChoice, ReceiverSet, TileReceivers};
pub use request::{ConditionSource, LightChoice, QueryRequest, ReplayRequest};
pub use resources::Resources;
pub use run::{RunDone, RunMap, RunRequest};
pub use series::Series;
pub use site_build::{FolderOption, ReceiverSource, SiteArchiveRequest, SiteBuild, SiteFolder};
pub use sky_components::SkyComponents;
pub use stream::{CoarseSinks, Sinks, Tile, TileFn, TileSink, TileStream};
pub use sunlight::{
    ClockHours, ClockZone, DaySpan, DaysTogether, GlareChoice, LitPart, Rule, RuleClock, RuleCount, RuleMeasure,
    ShippedRules, SunlightDone, SunlightRequest, SunlightSite, Threshold, shipped_rules,
};
pub use tradeoff::{LadderStep, LadderTable, SettingPoint, TradeoffDone, TradeoffRequest};
pub use update::{UpdateDone, UpdateRequest};
pub use viewer::{PageRequest, open_after};

pub use crate::outputs::periods::Every;
pub use crate::outputs::provenance::Provenance;
pub use crate::outputs::pv::hourly::{ONE_SIDE, SideHours};
pub use crate::outputs::tables::ArrowRows;
pub use crate::outputs::tables::bin_labels::{BinLabels, Instants, Precision};
pub use crate::outputs::tables::layout::{BinKind, By, Fact, Layout};
