//! All integration tests in one binary, by question.

/// The folder of the project.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

mod accuracy;
mod addresses;
mod archive;
mod atlas;
mod audit;
mod buildings;
mod canopy;
mod cityjson;
mod cityjson_out;
mod cli;
mod damage;
mod energyplus;
mod export;
mod figures;
mod gazetteer;
mod geometry;
mod ground;
mod honeybee;
mod hostile;
mod interrupt;
mod kaitai;
mod lit_wall;
mod longwave;
mod manners;
mod maps;
mod mirrors;
mod numerics;
mod paths;
mod physics;
mod pictures;
mod place;
mod plan;
mod pv;
mod reader;
mod reflectance;
#[cfg(feature = "remote")]
mod remote;
mod replay;
mod response;
mod results;
mod scenes;
mod shared;
mod site;
mod store;
mod study;
mod sums;
mod tables;
mod terrain;
mod tidy;
mod tilted;
mod times;
mod transfer;
mod view;
mod weather;
