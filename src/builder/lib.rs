//! Traces a site and writes its archive.

pub mod receiver_tiles;
pub mod spill;
pub mod study;
pub mod trace;
pub mod writing;
