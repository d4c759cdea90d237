//! What an archive is and how it is replayed.

pub mod archive;
pub mod error;
pub mod hemisphere;
pub mod layers;
pub mod light;
pub mod memory;
pub mod opened;
pub mod replay;
pub mod site;
pub mod sky;
pub mod text;
pub mod units;
pub mod weather;
