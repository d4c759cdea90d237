//! What archives are asked for, and what becomes of the answer. In: archives, requests. Out: tiles of irradiance with their labels, and files
//! of results.
//!
//! # Map
//!
//! | room | what it holds |
//! | --- | --- |
//! | `request` | [`QueryRequest`], [`ReplayRequest`], [`LightChoice`]: what a user asks for |
//! | `archives`, `receivers` | one archive or those of an atlas, and which of their receivers count |
//! | `bands` | [`BandChoice`]: light by band, as columns beside those of all light |
//! | `own_skies` | [`SkyFiles`]: skies and clouds of files, put into conditions |
//! | `series` | conditions with labels, coarser periods of them |
//! | `stream` | [`TileStream`], the one place where a replay is set up, and [`TileSink`], what takes its tiles |
//! | `files` | [`FileRequest`]: tables, maps, charts, city models and folders of Honeybee as sinks |
//! | `compare` | what a change of a site does to its light: [`CompareRequest`] |
//! | `buildings`, `places`, `factors` | further questions |
//! | `checks` | whether archives are what they say: [`AuditRequest`]; how they are made so again: [`RepairRequest`] |
//! | [`covering`] | a scene's surfaces with receivers on them, and the table of these |
//! | [`site_archive`] | the archive of a scene's receivers in a folder: the one that is there, or a new one |
//! | [`pv`] | light on solar modules, their best turns |
//! | [`run`] | from scene files to a folder of a year's results in one go |
//! | `sky_components` | what an overcast sky gives beside open ground |
//! | `comfort` | how warm it is for people: [`ComfortRequest`], [`ComfortSiteRequest`] |
//! | `sunlight` | hours of possible sun, the sun in mirrors, and rules about either: [`SunlightRequest`] |
//! | `tradeoff` | what accuracy costs on a site: [`TradeoffRequest`] |
//! | `update` | an archive after edits of its scene: [`UpdateRequest`] |
//! | `viewer` | the page that shows an archive, or two beside each other, as a file: [`PageRequest`], [`open_after`] |
//! | [`horizon`], `doubts` | what a user should know before results are used |
//! | [`outputs`] | writers: one model of columns for all tables, maps, pictures, models of others |
//!
//! # What never happens
//!
//! - Nothing is printed and no command line is known: an [`Observer`](heliotile_core::observer::Observer) is told; errors name fields of
//!   requests.
//! - A file is complete, or it is not there at all.

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
pub mod site_archive;
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
pub use request::{LightChoice, QueryRequest, ReplayRequest};
pub use resources::Resources;
pub use run::{RunDone, RunMap, RunRequest};
pub use series::Series;
pub use site_archive::SiteArchiveRequest;
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
pub use crate::outputs::tables::layout::{By, Fact, Labels, Layout};
pub use crate::outputs::tables::row_labels::{Instants, Precision, RowLabels};
