//! Files of features: footprints of buildings and points of trees with attributes. In: GeoJSON,
//! shapefiles, GeoPackage, GeoParquet, registers of trees as CSV. Out: outlines with the heights
//! that their attributes state, in metres; trees; faces where a file holds walls and roofs
//! (multipatches, polygons that are not level).
//!
//! | file | content |
//! | --- | --- |
//! | `feature` | a feature, the same for every format |
//! | `system` | coordinate systems of such files, and conversion to metres |
//! | `collector` | footprints and faces from features |
//! | `shapes` | polygons of well-known binary, as the crate `geozero` reads it |
//! | `shape_index` | which shape of a shapefile belongs to which row of its table |
//! | `hstore` | OpenStreetMap tags in one column |
//! | `outlines` | areas from features |
//! | `layers` | which layers of a file are read |
//! | `geojson`, `shapefile`, `geopackage`, `geoparquet`, `tree_csv` | one reader each |
//!
//! Points that state a tree become one; other points and lines are left out, with a warning.

#[cfg(test)]
mod case_tests;
mod collector;
mod feature;
mod geojson;
mod geopackage;
mod geoparquet;
mod hstore;
mod layers;
mod outlines;
mod shape_index;
mod shapefile;
mod shapes;
mod system;
#[cfg(test)]
mod tests;
mod tree_csv;

use std::path::Path;

use crate::formats::ReadOptions;
use crate::formats::features::feature::TakeFeature;
use crate::formats::features::outlines::OutlineCollector;
use crate::geometry::Geometry;
use heliotile_core::error::Result;
use heliotile_core::text::Message;
use heliotile_files::input;

pub(super) use collector::Collector;
pub(super) use feature::Feature;
pub(super) use geojson::is_geojson;
pub(crate) use outlines::Outline;
pub(super) use system::FeatureSystem;

/// Formats of features.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FeatureFormat {
    GeoJson,
    GeoPackage,
    GeoParquet,
    Shapefile,
    /// A register of trees.
    TreeCsv,
}

/// Reads a file of features. `bytes` are its unpacked content; they are empty for a GeoPackage,
/// which SQLite opens itself.
pub(super) fn parse(format: FeatureFormat, bytes: Vec<u8>, file: &Path, asked: &ReadOptions) -> Result<Geometry> {
    let mut collector = Collector::new(file, asked);
    let system = each_feature(format, bytes, file, asked, &mut |feature| collector.add(feature))?;
    collector.finish(system)
}

/// Hands the features of a file to `take`, and returns their coordinate system.
fn each_feature(
    format: FeatureFormat,
    bytes: Vec<u8>,
    file: &Path,
    asked: &ReadOptions,
    take: &mut TakeFeature,
) -> Result<FeatureSystem> {
    match format {
        FeatureFormat::GeoJson => geojson::read(&bytes, file, take),
        FeatureFormat::GeoPackage => geopackage::read(file, asked, take),
        FeatureFormat::GeoParquet => geoparquet::read(bytes, file, take),
        FeatureFormat::Shapefile => shapefile::read(bytes, file, take),
        FeatureFormat::TreeCsv => tree_csv::read(&bytes, file, take),
    }
}

/// Hands the features of the shapefile in a zip to `take`, and returns their coordinate system;
/// `None` if the zip holds none.
fn each_zipped(file: &Path, take: &mut TakeFeature) -> Result<Option<FeatureSystem>> {
    let parts = input::zipped_shapefile(file)?;
    parts.map(|parts| shapefile::read_parts(&parts, file, take)).transpose()
}

/// Reads the shapefile in a zip; `None` if the zip holds none.
pub(super) fn zipped_shapefile(file: &Path, asked: &ReadOptions) -> Result<Option<Geometry>> {
    let mut collector = Collector::new(file, asked);
    let system = each_zipped(file, &mut |feature| collector.add(feature))?;
    system.map(|system| collector.finish(system)).transpose()
}

/// Reads the areas of the shapefile in a zip, as [`areas`] does; `None` if the zip holds none.
pub(super) fn zipped_areas(file: &Path, scene: Option<u32>) -> Result<Option<(Vec<Outline>, Vec<Message>)>> {
    let mut collector = OutlineCollector::new(file);
    let system = each_zipped(file, &mut |feature| collector.add(feature))?;
    system.map(|system| collector.finish(system, scene)).transpose()
}

/// Reads the areas of a file of features, in metres of the system `scene`, and sentences for the
/// user. `bytes` are as for [`parse`].
pub(super) fn areas(
    format: FeatureFormat,
    bytes: Vec<u8>,
    file: &Path,
    scene: Option<u32>,
) -> Result<(Vec<Outline>, Vec<Message>)> {
    let mut collector = OutlineCollector::new(file);
    let system = each_feature(format, bytes, file, &ReadOptions::default(), &mut |feature| collector.add(feature))?;
    collector.finish(system, scene)
}
