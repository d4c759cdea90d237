//! How much sun does every point of a building, a solar module or a street get? heliotile traces a
//! site once and replays any weather, reflectance and season from one file, without tracing a ray
//! again.
//!
//! This crate is the entry to the library: requests that a program fills, and their results. The
//! program `heliotile`, the Python package and the page fill the same requests.
//!
//! ```no_run
//! use heliotile::{ReplayRequest, Resources, SceneRequest, Silent, Site, SiteArchiveRequest};
//!
//! fn main() -> heliotile::Result<()> {
//!     // Files of the world: CityJSON, terrain, OBJ, glTF, EnergyPlus, Honeybee.
//!     let scene = SceneRequest::of(["block.city.json"]);
//!     // Receivers on its roofs, walls and windows, traced once into out/site.helio.
//!     let archive = SiteArchiveRequest::new(scene, "out").build(&Silent)?;
//!     // A year of weather; nothing is traced.
//!     let year = ReplayRequest::new("rotterdam.epw");
//!     for receiver in Site::open(archive)?.totals(&year, &Resources::usual())? {
//!         println!("{}: {:.0} kWh/m2", receiver.id, receiver.kwh_m2);
//!     }
//!     Ok(())
//! }
//! ```
//!
//! Five programs stand in `tools/examples`: the one above, hours of a tile passed to a function of
//! the caller, conditions with another albedo, geometry that a program makes, and receivers and
//! weather in memory.
//!
//! # What it is made of
//!
//! ```text
//! requests <- core <- files <- archives <- remote <- results <- studies <- atlas, energyplus
//!              ^-- weather, comfort, sunlight, place <'    scene <- builder <-'
//!                                                          heliotile <- program, python
//! ```
//!
//! Results reach neither scenes nor the tracer: what only replays compiles neither.
//!
//! | crate | what it holds |
//! | --- | --- |
//! | [`heliotile_requests`] | requests that declare their fields once, for every face |
//! | [`heliotile_core`] | what an archive is and how it is replayed |
//! | [`heliotile_weather`] | weather files of all layouts: checked rows, series of conditions, doubts |
//! | `heliotile_comfort` | thermal comfort of people: mean radiant temperature, UTCI, PET |
//! | `heliotile_sunlight` | hours of direct sun, from the path of the sun through the sky that receivers see |
//! | [`heliotile_files`] | files: unpacked on the way in, whole or absent on the way out, sorted beyond memory |
//! | [`heliotile_archives`] | archives as files: written whole or resumed, cut, joined, compared |
//! | `heliotile_place` | places on Earth: coordinate systems by number |
//! | [`heliotile_scene`] | files of the world: geometry, materials, receivers |
//! | [`heliotile_builder`] | tracing, plans, the reference path tracer |
//! | [`heliotile_remote`] | places of files: paths, and addresses in object stores (feature `remote`) |
//! | [`heliotile_results`] | replay and its results: tables, maps, pictures, models of other programs |
//! | [`heliotile_studies`] | what reads scenes or traces: receivers, builds, runs, modules, hours of sun, audits |
//! | [`heliotile_atlas`] | regions in parts: planned, built, opened, checked |
//!
//! # What never happens
//!
//! - A replay casts no ray: [`heliotile_core`] holds no code that could.
//! - Nothing is printed and no command line is read: messages go to an [`Observer`].
//! - A file is whole or does not have its name; a changed byte is an error that names the block.
//! - Bytes of an archive do not depend on threads, on the order of receivers or faces, on the
//!   machine or on time.
//! - No input ends the program: what cannot be used is an [`Error`] that says what was found,
//!   where, and what to do.

#![deny(missing_docs)]

pub mod book;
pub mod cases;
mod site;

pub use heliotile_archives::transfer::{Bounds, ExtractContent, Selection};
pub use heliotile_builder::pipeline::{Output, Start};
pub use heliotile_builder::planning::{AccuracyRequest, BuildDone, EffectsUnder, PlanReport};
pub use heliotile_builder::settings::{EffectChoice, Quality, Share};
pub use heliotile_core::archive::Access;
pub use heliotile_core::error;
pub use heliotile_core::error::{Error, Result};
pub use heliotile_core::light::paths::LightPaths;
pub use heliotile_core::light::radiosity::MaxBounces;
pub use heliotile_core::memory::MemoryBudget;
pub use heliotile_core::observer::{Observer, Silent, Tone};
pub use heliotile_core::replay::components::{Component, ComponentList, ComponentSet};
pub use heliotile_core::replay::factors::FACTORS;
pub use heliotile_core::replay::reflectances::{Changes, ConstantOrFile, Snow};
pub use heliotile_core::site::bands::BandOptics;
pub use heliotile_core::site::material::{Class, Material};
pub use heliotile_core::site::receiver::Receiver;
pub use heliotile_core::sky::model::SkyModel;
pub use heliotile_core::sky::own_skies::SkyScale;
pub use heliotile_core::units::{Bytes, direction_from_degrees};
pub use heliotile_core::weather::conditions::Condition;
pub use heliotile_core::weather::options::{DateOrder, StampedAt, TimeShift, WeatherOptions};
pub use heliotile_core::weather::span::Moment;
pub use heliotile_core::weather::time::clock_zone::ClockZone;
pub use heliotile_energyplus::{EnergyplusRequest, Physics};
pub use heliotile_requests as requests;
pub use heliotile_results::{
    BandChoice, BandList, BinLabels, BuildingsRequest, By, ClassShare, ComfortChoice, ComfortColumn, ComfortRequest,
    CompareRequest, ConditionSource, Every, FactorRows, FactorsRequest, LightRequest, LightSource, OutputRequest,
    PageRequest, PartReceivers, PlaceOn, PlacesRequest, Posture, Provenance, QueryRequest, ReceiverChoice,
    ReplayRequest, ReportDone, ReportRequest, Resources, ShadingRequest, ShadingSummary, SideHours, SkyChoice,
    SkyFiles, SunOnPerson, SurfaceTemperatures, Takers, Tile, TileSink, WindChoice,
};
pub use heliotile_scene::edit::{ObjectHeight, ObjectMaterial, ObjectMove, SceneEdits};
pub use heliotile_scene::footprint_options::{FootprintOptions, HeightAbove, HeightSource};
pub use heliotile_scene::placing::frame::{SiteFrame, UpAxis};
pub use heliotile_scene::points::receivers::ReceiverCsv;
pub use heliotile_scene::request::SceneRequest;
pub use heliotile_scene::site::SceneFiles;
pub use heliotile_scene::{ModelVersion, Scene, SurfaceRasters};
pub use heliotile_studies::covering::{CoverRequest, Density};
pub use heliotile_studies::pv::{EnergyRequest, Mounting, Price, PvDone, PvRequest};
pub use heliotile_studies::site_build::check_output;
pub use heliotile_studies::{
    AuditReport, AuditRequest, ComfortSiteRequest, DaySpan, EnvelopeDone, EnvelopeRequest, FolderOption, GlareChoice,
    ReceiverSource, RepairRequest, RunDone, RunMap, RunRequest, SiteArchiveRequest, SiteBuild, SiteFolder,
    SunlightDone, SunlightRequest, TradeoffRequest, TreeShade, UpdateDone, UpdateRequest, Verdict, shipped_rules,
    shipped_with,
};
pub use heliotile_weather::temperatures::Temperature;
pub use site::{ReceiverTotal, Site, SiteOptions, SiteReplay};

/// Archives as files: blocks, transfers between archives.
pub mod archive {
    pub use heliotile_archives::transfer;
    pub use heliotile_archives::transfer::{Assembled, LayeredReceiver};
    pub use heliotile_core::archive::accuracy::Accuracy;
    pub use heliotile_core::archive::format::TileNumber;
    pub use heliotile_core::archive::{Archive, Problem, ReadAt, format, tables, verify};
    pub use heliotile_core::opened::OpenSite;
    pub use heliotile_core::replay::run::Replay;
    pub use heliotile_remote::places::{hold, open_archive, require_file};
}

/// Regions in parts: planned, built, listed, copied, catalogued.
pub mod atlas {
    pub use heliotile_atlas::about::built;
    pub use heliotile_atlas::catalogue::{CatalogueRequest, catalogue};
    pub use heliotile_atlas::listed::{PARTS, archive_of, list};
    pub use heliotile_atlas::opened::check_square;
    pub use heliotile_atlas::part::{PartRequest, build_parts};
    pub use heliotile_atlas::partition::{PartitionRequest, partition};
    pub use heliotile_atlas::plan::{AtlasPlan, CutRequest, FILE};
    pub use heliotile_atlas::sources::holding;
    pub use heliotile_atlas::{
        Atlas, CheckedArchive, ExportRequest, ListedPart, SunPosition, VerifyRequest, about, copied, parts,
    };
}

/// Receivers on surfaces and along lines.
pub mod covering {
    pub use heliotile_core::site::semantics::SurfaceKind;
    pub use heliotile_results::horizon::black_below_horizon;
    pub use heliotile_scene::covering::surfaces::Surfaces;
    pub use heliotile_studies::covering::{check_name, cover_scene, cover_site, doubts, save, summary, write};
    pub use heliotile_studies::on_ground::{AlongRequest, AreaSource, WithinRequest, write_points};
}

/// Materials: numbers in messages, files of changes.
pub mod materials {
    pub use heliotile_core::site::material::{density_of, rounded};
}

/// Memory of the machine, and scratch space on disk.
pub mod memory {
    pub use heliotile_files::spill::{SystemTemp, check_memory, parse_memory};
}

/// Values that users choose by name.
pub mod names {
    pub use heliotile_core::named::{NamedValues, by_name, name_of};
}

/// Files to write: guards, endings, formats.
pub mod output {
    pub use heliotile_files::writing::claim::{ClaimedOutput, OutputGuard, same_place};
    pub use heliotile_files::writing::copy::folder_of;
    pub use heliotile_files::writing::guards::{check_archive_name, guard_archive, guard_output, is_archive};
    pub use heliotile_files::writing::whole_file::remove_unfinished;
    pub use heliotile_results::outputs::city_model::is_city_model;
    pub use heliotile_results::outputs::result_file::ResultFormat;
    pub use heliotile_results::outputs::shapes::writer::MapFormat;
    pub use heliotile_results::outputs::sink::write_texts;
    pub use heliotile_results::outputs::tables::format::{Format, files_of};
    pub use heliotile_results::outputs::viewer_page::{ViewerPage, packed};
    pub use heliotile_studies::run::folder_beside;
}

/// Addresses in object stores.
pub mod remote {
    pub use heliotile_remote::naming::{is_address, shown};
    pub use heliotile_remote::{copy, traffic};
}

/// Files of the world: input, checks of their options.
pub mod scene {
    pub use heliotile_files::input;
    pub use heliotile_files::input::weather::read_weather_as;
    pub use heliotile_scene::format_of_name;
    pub use heliotile_scene::placing::frame::{check_elevation, check_epsg, check_rotation, check_scale};
}

/// Tables of results.
pub mod tables {
    pub use heliotile_results::outputs::tables;
    pub use heliotile_results::outputs::tables::records::Records;
    pub use heliotile_results::outputs::tables::table::Cell;
    pub use heliotile_results::{ArrowRows, Layout, ONE_SIDE, open_after};
    pub use heliotile_studies::is_time;
}

/// Words of messages.
pub mod text {
    pub use heliotile_core::text::{Message, Named, counted, excerpt, message, with_list, without_secrets};
}

/// Tracing: plans, conditions of accuracy.
pub mod tracing {
    pub use heliotile_archives::Workspace;
    pub use heliotile_builder::accuracy::conditions::ErrorConditions;
    pub use heliotile_builder::planning::tables;
    pub use heliotile_builder::planning::tables::in_hours;
    pub use heliotile_builder::trace::Tracer;
    pub use heliotile_builder::trace::canopy::in_hulls;
    pub use heliotile_builder::trace::placement::Placement;
    pub use heliotile_builder::trace::viewpoint::Viewpoint;
}

/// Weather: sums, distance from a site.
pub mod weather {
    pub use heliotile_weather::distance::far_apart;
    pub use heliotile_weather::monthly::WeatherSums;
}
