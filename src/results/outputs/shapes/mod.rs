//! Maps of results: polygons of receivers, surfaces, objects or buildings with their values, as
//! files for GIS, BIM and ParaView.
//!
//! In: places with the parts of surfaces that they stand for, and tiles of values. Out: a file,
//! complete or not there at all. Rows wait in sorted runs, which go to temporary files if they do
//! not fit into memory; each format reads them as often as it needs. Never: sums other than those
//! of months, colours other than those of pictures.

pub mod columns;
mod crs;
mod flatgeobuf;
mod geojson;
mod geoparquet;
mod glb;
pub mod group_patches;
mod outline;
pub mod picture;
mod ply;
mod pvd;
pub mod row;
mod rows;
pub mod stated;
mod style;
mod vtu;
pub mod writer;

pub use crs::MapCrs;
