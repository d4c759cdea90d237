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
//!     let archive = SiteArchiveRequest::of(scene, "out").build(&Silent)?;
//!     // A year of weather; nothing is traced.
//!     let year = ReplayRequest::of("rotterdam.epw");
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
//! core <- scene <- builder <- results <- energyplus
//!  ^-- remote <----- atlas <-----'
//!                      ^------- heliotile <- program, python
//! ```
//!
//! | crate | what it holds |
//! | --- | --- |
//! | [`heliotile_core`] | what an archive is and how it is replayed; every formula |
//! | [`heliotile_scene`] | files of the world: geometry, materials, receivers |
//! | [`heliotile_builder`] | tracing, writing, plans, the reference path tracer, parts and unions of archives |
//! | [`heliotile_remote`] | places of files: paths, and addresses in object stores (feature `remote`) |
//! | [`heliotile_results`] | requests and their results: tables, maps, pictures, models of other programs |
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
mod site;

pub use heliotile_builder::pipeline::{Output, Start};
pub use heliotile_builder::planning::{AccuracyRequest, BuildDone, PlanReport};
pub use heliotile_builder::settings::{EffectChoice, Quality, Share};
pub use heliotile_builder::transfer::{Bounds, Selection};
pub use heliotile_core::archive::Access;
pub use heliotile_core::error::{Error, Result};
pub use heliotile_core::memory::MemoryBudget;
pub use heliotile_core::observer::{Observer, Silent};
pub use heliotile_core::replay::components::{Component, ComponentList, ComponentSet};
pub use heliotile_core::site::material::{Class, Material};
pub use heliotile_core::site::receiver::Receiver;
pub use heliotile_core::units::direction_from_degrees;
pub use heliotile_core::weather::conditions::Condition;
pub use heliotile_results::site_build::check_output;
pub use heliotile_results::{
    CompareRequest, ConditionSource, CoverRequest, Every, FileRequest, FolderOption, Illumination, LightChoice,
    Provenance, QueryRequest, ReceiverChoice, ReceiverSource, ReplayRequest, Resources, SiteArchiveRequest, SiteBuild,
    SiteFolder, Tile,
};
pub use heliotile_scene::Scene;
pub use heliotile_scene::request::SceneRequest;
pub use site::{ReceiverTotal, Site, SiteOptions, SiteReplay};
pub use {heliotile_atlas, heliotile_builder, heliotile_core, heliotile_remote, heliotile_results, heliotile_scene};
