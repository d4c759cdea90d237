//! heliotile: an out-of-core tiled map database of hemispheres.

pub mod cli;
pub mod commands;
pub mod files;
pub mod outputs;
