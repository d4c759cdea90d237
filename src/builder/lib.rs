//! Traces a site and writes its archive.

pub mod accuracy;
pub mod build;
pub mod observer;
pub mod pack;
pub mod receiver_tiles;
pub mod settings;
pub mod spill;
pub mod store;
pub mod study;
pub mod trace;
pub mod transfer;
pub mod writing;
