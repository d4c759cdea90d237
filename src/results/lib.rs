//! Requests to archives, and the results they give. In: archives, requests. Out: tiles of
//! irradiance with their labels, and files of results.
//!
//! # Map
//!
//! | room | what it holds |
//! | --- | --- |
//! | `request` | [`QueryRequest`], [`ReplayRequest`], [`LightRequest`]: what a user asks for |
//! | `archives`, `receivers` | one archive or those of an atlas, and their chosen receivers |
//! | `bands` | [`BandChoice`]: light by band, in columns that follow those of all light |
//! | `own_skies` | [`SkyFiles`]: skies and clouds from files, put into conditions |
//! | `series` | conditions with labels, and coarser periods of them |
//! | `stream` | [`TileStream`], the only setup of replays; [`TileSink`] takes the tiles |
//! | `files` | [`OutputRequest`]: tables, maps, charts, city models and Honeybee folders as sinks |
//! | `compare` | [`CompareRequest`]: the light that a change of a site adds or takes |
//! | `buildings`, `places`, `factors` | cadastre, places of modules, factors by sun position |
//! | `shading` | light that each object takes from receivers and reflects to them |
//! | `gap_fractions` | shares of the sky through leaves by rings of zenith angles |
//! | `sky_components` | light of an overcast sky in percent of open ground |
//! | `comfort` | thermal comfort of people: [`ComfortRequest`] |
//! | `viewer` | [`PageRequest`], [`open_after`]: HTML file with one archive, or two compared |
//! | [`report`] | statement for people about tables: [`ReportRequest`] |
//! | [`horizon`], `doubts` | warnings that a user should know before results are used |
//! | [`outputs`] | writers of tables, maps, pictures and foreign formats |
//!
//! # What never happens
//!
//! - No code here prints or knows a command line. Messages go to an
//!   [`Observer`](heliotile_core::observer::Observer); errors name fields of requests.
//! - No incomplete file is left: a file is complete, or it is not there at all.

pub mod archives;
pub mod bands;
pub mod buildings;
pub mod comfort;
pub mod compare;
pub mod doubts;
pub mod factors;
pub mod files;
pub mod gap_fractions;
pub mod horizon;
pub mod outputs;
pub mod own_skies;
pub mod percentiles;
pub mod places;
pub mod receivers;
pub mod report;
pub mod request;
pub mod resources;
pub mod series;
pub mod shading;
pub mod sky_components;
pub mod stream;
pub mod viewer;

pub use archives::{Archives, Sources};
pub use bands::{BandChoice, BandList};
pub use buildings::{BuildingsRequest, BuildingsSummary};
pub use comfort::{
    ClassShare, ComfortChoice, ComfortColumn, ComfortDone, ComfortRequest, Posture, SunOnPerson, SurfaceTemperatures,
    WindChoice,
};
pub use compare::{
    BeforeSide, CompareRequest, CompareSummary, LOSSES_PERCENT, LightSource, LossCounts, VariantSummary,
};
pub use factors::{FactorRows, FactorsRequest};
pub use files::{
    AreaChart, CityModelSink, MapFile, OutputRequest, Question, ResultSink, RowsAbout, crs_of, name_of, rows_of,
    surroundings,
};
pub use gap_fractions::GapFractions;
pub use own_skies::{SkyChoice, SkyFiles};
pub use places::{PlaceOn, PlacesRequest, PlacesSummary};
pub use receivers::{PartReceivers, ReceiverChoice, ReceiverSet, TileReceivers};
pub use report::{ReportDone, ReportRequest};
pub use request::{ConditionSource, LightRequest, QueryRequest, ReplayRequest};
pub use resources::Resources;
pub use series::Series;
pub use shading::{ShadingRequest, ShadingSummary, Takers};
pub use sky_components::SkyComponents;
pub use stream::{CoarseSinks, Sinks, Tile, TileFn, TileSink, TileStream};
pub use viewer::{PageRequest, open_after};

pub use crate::outputs::periods::Every;
pub use crate::outputs::provenance::Provenance;
pub use crate::outputs::pv::hourly::{ONE_SIDE, SideHours};
pub use crate::outputs::tables::ArrowRows;
pub use crate::outputs::tables::bin_labels::{BinLabels, Instants, Precision};
pub use crate::outputs::tables::layout::{BinKind, By, Fact, Layout};
