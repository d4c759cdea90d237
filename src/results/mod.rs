//! What archives are asked for, and what becomes of the answer. In: archives, requests. Out: tiles of irradiance with their labels, and files
//! of results. Never: the command line, what is printed.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `request` | [`QueryRequest`], [`ReplayRequest`], [`LightChoice`]: what a user asks for |
//! | `archives`, `receivers` | one archive or those of an atlas, and which of their receivers count |
//! | `series` | conditions with labels, coarser periods of them |
//! | `stream` | [`TileStream`], the one place where a replay is set up, and [`TileSink`], what takes its tiles |
//! | `files` | [`FileRequest`]: tables, maps, charts, city models and folders of Honeybee as sinks |
//! | `buildings`, `places`, `factors` | further questions |
//! | `doubts` | what a user should know before results are used |

mod archives;
mod buildings;
mod doubts;
mod factors;
mod files;
mod places;
mod receivers;
mod request;
mod series;
mod stream;

pub use archives::{Archives, Sources};
pub use buildings::{BuildingsRequest, BuildingsSummary};
pub use factors::FactorRows;
pub use files::{AreaChart, CityModelSink, FileRequest, ResultRows, ResultSink, crs_of, name_of, surroundings};
pub use places::{PlaceOn, PlacesRequest, PlacesSummary};
pub use receivers::{PartReceivers, ReceiverChoice, ReceiverSet, TileReceivers};
pub use request::{LightChoice, QueryRequest, ReplayRequest};
pub use series::Series;
pub use stream::{CoarseSinks, Resources, Sinks, Tile, TileFn, TileSink, TileStream, replay_of};

pub use crate::outputs::periods::Every;
pub use crate::outputs::provenance::Provenance;
pub use crate::outputs::pv::hourly::{ONE_SIDE, SideHours};
pub use crate::outputs::tables::ArrowRows;
pub use crate::outputs::tables::layout::{By, Fact, Labels, Layout};
pub use crate::outputs::tables::row_labels::{Instants, Precision, RowLabels};
