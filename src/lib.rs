//! How much sun does every point of a building, a solar module or a street get? heliotile traces a site once and replays any weather,
//! reflectance and season from one file, without tracing a ray again.
//!
//! This crate is the face of four: what a program needs stands here, what it is made of in [`heliotile_core`] (an archive and how it is
//! replayed), [`heliotile_scene`] (files of the world) and [`heliotile_builder`] (tracing and writing). The arrow goes one way,
//! `core <- scene <- builder <- heliotile`, and the compiler holds it. With the feature `remote` a fifth one opens archives in object stores
//! and on web servers ([`files::open_archive`]). The command line is in here too, and private.
//!
//! # From a scene to watts
//!
//! ```
//! use heliotile::{
//!     Archive, Build, BuildSettings, Class, Component, Condition, DVec3, Material, MemoryBudget, OpenSite, Output, Plan, PreparedScene,
//!     Quality, Receiver, ReceiverTiles, Replay, ReplaySettings, Rungs, Scene, Silent, Workspace,
//! };
//!
//! # fn main() -> heliotile::Result<()> {
//! // A ground of 100 m x 100 m with a white wall on it, 10 m wide and high; metres, x east, y north, z up.
//! let quad = |a: DVec3, u: DVec3, v: DVec3, material: u16| [([a, a + u, a + u + v], material), ([a, a + u + v, a + v], material)];
//! let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
//! let triangles = [
//!     quad(-50.0 * x - 50.0 * y, 100.0 * x, 100.0 * y, 0),
//!     quad(-5.0 * x + 5.0 * y, 10.0 * x, 10.0 * z, 1),
//! ]
//! .concat();
//! let materials = vec![Material::matt("ground", 0.2, Class::Ground), Material::matt("wall", 0.8, Class::Obstruction)];
//! let scene = Scene::from_triangles(&triangles, materials)?;
//!
//! // One receiver that looks up and one that looks at the wall.
//! let receiver = |id: &str, normal: DVec3| Receiver::new(id.into(), z, normal);
//! let receivers = [receiver("up", z), receiver("north", y)];
//!
//! // Plan, then write.
//! let folder = tempfile::tempdir().expect("a folder");
//! let workspace = Workspace { folder: folder.path().into(), memory: MemoryBudget::DEFAULT };
//! let mut tiles = ReceiverTiles::from_receivers(&receivers, scene.mesh.origin, folder.path(), 1 << 20)?;
//! let prepared = PreparedScene::new(&scene)?;
//! let mut build = Build { scene: &prepared, receivers: &mut tiles, workspace: &workspace, observer: &Silent };
//! let plan = Plan::of(Rungs::of(Quality::Draft).settings());
//! let path = folder.path().join("site.helio");
//! build.write(&plan, &Output::new(&path), &[])?;
//!
//! // Two conditions: the sun in the south at 40 degrees, and an overcast sky. Degrees, W/m2.
//! let sun = heliotile::direction_from_degrees(180.0, 40.0);
//! let conditions =
//!     [Condition::new("clear".into(), &[sun], sun, 800.0, 80.0), Condition::new("overcast".into(), &[sun], sun, 0.0, 150.0)];
//! let archive = Archive::open(&path)?;
//! let replay = Replay::new(&OpenSite::of(&archive)?, &conditions, ReplaySettings::default())?;
//! for tile in replay.results(0..replay.tiles()) {
//!     let (ids, values) = tile?;
//!     for (row, id) in ids.iter().enumerate() {
//!         let [direct, reflected] = [Component::SunDirect, Component::SunDiffuse].map(|c| values.row(c, row)[0]);
//!         println!("{id}: {direct:.0} W/m2 from the sun, {reflected:.0} by way of ground and wall");
//!         // The wall stands in the sun, and the receiver in front of it looks away from the sun.
//!         match id.as_str() {
//!             "north" => assert!(direct == 0.0 && reflected > 100.0),
//!             _ => assert!((direct - 800.0 * 40_f32.to_radians().sin()).abs() < 2.0),
//!         }
//!     }
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # What never happens
//!
//! - Replay casts no ray: [`heliotile_core`] holds no code that could.
//! - The engine prints nothing and reads no command line: it tells an [`Observer`].
//! - A file is whole or has not got its name; a changed byte is an error that names the block.
//! - Bytes of an archive do not depend on threads, on the order of receivers or faces, on the machine or on time.
//! - No input ends the program: what cannot be used is an [`Error`] that says what was found, where, and what to do.

#![deny(missing_docs)]

mod cli;
mod commands;
pub mod covering;
mod energyplus;
pub mod files;
pub mod guards;
mod outputs;
pub mod results;

pub mod book;

pub use glam::{DVec2, DVec3};
pub use heliotile_builder::build::{
    Build, BuildReport, Forecast, Output, Plan, PreparedScene, RayCounts, Start, Workspace,
};
pub use heliotile_builder::observer::{Observer, Silent};
pub use heliotile_builder::planning::{EffectsUnder, ErrorTarget, PlanReport, PlanRequest};
pub use heliotile_builder::receiver_tiles::ReceiverTiles;
pub use heliotile_builder::settings::{BuildSettings, Effect, EffectChoice, Effects, Quality, Rungs, Share};
pub use heliotile_builder::transfer::{Bounds, Selection, diff, extract, merge};
pub use heliotile_core::archive::{Access, Archive, Manifest, verify};
pub use heliotile_core::error::{Error, Result};
pub use heliotile_core::memory::MemoryBudget;
pub use heliotile_core::opened::OpenSite;
pub use heliotile_core::replay::components::{Component, ComponentList, ComponentSet};
pub use heliotile_core::replay::run::{Replay, ReplaySettings, TileResult};
pub use heliotile_core::replay::values::TileValues;
pub use heliotile_core::site::material::{Class, Glass, Material};
pub use heliotile_core::site::place::Place;
pub use heliotile_core::site::receiver::Receiver;
pub use heliotile_core::sky::model::SkyModel;
pub use heliotile_core::units::direction_from_degrees;
pub use heliotile_core::weather::conditions::Condition;
pub use heliotile_core::weather::series::Weather;
pub use heliotile_core::weather::time::bins::Bins;
pub use heliotile_scene::Scene;

pub use cli::{NamedValues, by_name};
pub use commands::nothing_seen;

use std::ffi::OsString;

/// The program `heliotile`: parses the words of a command line, the program's name first, does what they ask and prints the error, if there is
/// one. 0 fine, 1 found a problem, 2 could not run, 130 stopped by Ctrl-C, 143 by SIGTERM.
pub fn program(words: &[OsString]) -> u8 {
    let (cli, about) = cli::parse(words);
    match commands::run(&cli, about) {
        Ok(commands::Outcome::Fine) => 0,
        Ok(commands::Outcome::ProblemFound) => 1,
        Err(error @ Error::Stopped { .. }) => {
            eprintln!("heliotile: {error}; to go on: {}", cli::again(words));
            commands::exit_code()
        }
        Err(error) => {
            eprintln!("heliotile: {}", cli::worded(error));
            2
        }
    }
}

/// Regions in parts.
pub mod atlas {
    pub use crate::commands::atlas::listed::{ListedPart, parts};
    pub use crate::commands::atlas::opened::check_square;
    pub use crate::commands::atlas::part::PartState;
    pub use crate::commands::atlas::sources::archives;
}

/// For tests of what the program writes.
#[doc(hidden)]
pub mod pictures {
    pub use crate::outputs::pictures::{colours, fisheye, panel};
    pub use crate::outputs::provenance::Provenance;
}
