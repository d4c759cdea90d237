//! heliotile: an out-of-core tiled map database of hemispheres. A builder traces every receiver of a site once; replay
//! recombines the layers for any sun, sky and weather, and never casts a ray again.
//!
//! Stages, left to right; a file imports only stages to its left (a test reads the imports):
//!
//! `units, error, spill, hemisphere, mapping | scene | trace | layers | archive | recombine | outputs | cli, commands`
//!
//! What never happens: only `trace` casts rays; `recombine` does not import `trace`; only `archive::source` holds `unsafe`;
//! bytes of an archive do not depend on threads, on the order of receivers or faces, or on time.

pub mod archive;
pub mod cli;
pub mod commands;
pub mod error;
pub mod hemisphere;
pub mod layers;
pub mod mapping;
pub mod outputs;
pub mod recombine;
pub mod scene;
pub mod spill;
pub mod trace;
pub mod units;

pub use archive::Archive;
pub use error::{Error, Result};
pub use recombine::replay::{Replay, ReplaySettings};
