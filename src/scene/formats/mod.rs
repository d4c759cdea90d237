//! Readers of scene files, one format a file or folder, chosen by the ending of the file name. In:
//! a file of unknown origin. Out: polygons with every index and coordinate checked.
//!
//! No reader drops anything silently. A reader opens only the files that it is given, the files
//! that these name, and the files of the same name beside a raster or a shapefile.

mod ascii_grid;
mod building;
mod citygml;
mod cityjson;
pub(crate) mod energyplus;
mod features;
mod gdal_metadata;
mod geokeys;
mod geotiff;
mod gltf;
mod honeybee;
mod mtl;
pub(super) mod obj;
mod ply;
mod ply_body;
mod ply_header;
mod projections;
mod read_options;
mod sidecar;
mod stl;
mod tiff_directory;
mod unread;
mod wkt;
mod xml;

use std::path::Path;

use crate::facing;
use crate::geocentric::{is_geocentric, to_local};
use crate::geometry::Geometry;
use crate::terrain::raster::Raster;
use crate::text::{excerpt, utf8};
use features::{FeatureFormat, Outline};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::Message;
use heliotile_files::input;
use heliotile_files::input::NamedBytes;
pub(super) use read_options::{ReadOptions, stem};

/// Content of a scene file: polygons, or a raster of terrain heights.
pub(super) enum Content {
    Polygons(Box<Geometry>),
    Terrain(Raster),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    AsciiGrid,
    CityGml,
    CityJson,
    EnergyPlus,
    Features(FeatureFormat),
    GeoTiff,
    Gltf,
    Honeybee,
    /// A `.json` file, whose content decides: Honeybee, epJSON, GeoJSON or CityJSON.
    Json,
    Obj,
    Ply,
    Stl,
}

/// Endings of file names in lower case, with their formats. Each may be followed by `.gz` or
/// `.zip`.
const ENDINGS: [(&str, Format); 29] = [
    ("asc", Format::AsciiGrid),
    ("citygml", Format::CityGml),
    ("cityjson", Format::CityJson),
    ("cityjsonl", Format::CityJson),
    ("csv", Format::Features(FeatureFormat::TreeCsv)),
    ("dem", Format::AsciiGrid),
    ("epjson", Format::EnergyPlus),
    ("geojson", Format::Features(FeatureFormat::GeoJson)),
    ("geojsonl", Format::Features(FeatureFormat::GeoJson)),
    ("geojsonseq", Format::Features(FeatureFormat::GeoJson)),
    ("geoparquet", Format::Features(FeatureFormat::GeoParquet)),
    ("geotiff", Format::GeoTiff),
    ("glb", Format::Gltf),
    ("gltf", Format::Gltf),
    ("gml", Format::CityGml),
    ("gpkg", Format::Features(FeatureFormat::GeoPackage)),
    ("hbjson", Format::Honeybee),
    ("idf", Format::EnergyPlus),
    ("json", Format::Json),
    ("jsonl", Format::CityJson),
    ("ndjson", Format::Features(FeatureFormat::GeoJson)),
    ("obj", Format::Obj),
    ("parquet", Format::Features(FeatureFormat::GeoParquet)),
    ("ply", Format::Ply),
    ("shp", Format::Features(FeatureFormat::Shapefile)),
    ("stl", Format::Stl),
    ("tif", Format::GeoTiff),
    ("tiff", Format::GeoTiff),
    ("xml", Format::CityGml),
];

const SUPPORTED: &str = ".json, .jsonl, .cityjson and .cityjsonl (CityJSON), .gml, .citygml and .xml (CityGML), .tif, .tiff, .geotiff, .asc and .dem (terrain), .epjson and .idf (EnergyPlus), .hbjson \
                         (Honeybee), .geojson, .geojsonl, .geojsonseq, .ndjson, .shp, .gpkg, .parquet and .geoparquet (footprints, trees), .csv (registers of trees), .gltf, .glb, .obj, .ply, .stl, each also packed, with .gz or .zip behind it, and site.toml";

/// Returns the scene format that the name of `path` belongs to, packed with `.gz` or not. Returns
/// `None` for `.json` too, which need not be a scene.
pub fn format_of_name(path: &Path) -> Option<&'static str> {
    let ending = input::ending(path);
    ENDINGS.iter().find(|(known, _)| *known == ending).and_then(|(_, format)| format.name())
}

impl Format {
    /// Returns true if files of this format are plain text, which may be UTF-16.
    fn is_text(self) -> bool {
        !matches!(self, Format::GeoTiff | Format::Gltf | Format::Ply | Format::Stl)
            && (!matches!(self, Format::Features(_))
                || matches!(self, Format::Features(FeatureFormat::GeoJson | FeatureFormat::TreeCsv)))
    }

    fn name(self) -> Option<&'static str> {
        Some(match self {
            Format::AsciiGrid => "ASCII grid",
            Format::CityGml => "CityGML",
            Format::CityJson => "CityJSON",
            Format::EnergyPlus => "EnergyPlus",
            Format::Features(FeatureFormat::GeoJson) => "GeoJSON",
            Format::Features(FeatureFormat::GeoPackage) => "GeoPackage",
            Format::Features(FeatureFormat::GeoParquet) => "GeoParquet",
            Format::Features(FeatureFormat::Shapefile) => "shapefile",
            // A CSV may be weather or receivers, too.
            Format::Features(FeatureFormat::TreeCsv) => return None,
            Format::GeoTiff => "TIFF",
            Format::Gltf => "glTF",
            Format::Honeybee => "Honeybee",
            Format::Json => return None,
            Format::Obj => "OBJ",
            Format::Ply => "PLY",
            Format::Stl => "STL",
        })
    }
}

fn is_zip(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("zip"))
}

/// Reads a scene file of any format.
pub(super) fn read(path: &Path, asked: &ReadOptions) -> Result<Content> {
    let mut ending = input::ending(path);
    let known = |ending: &str| ENDINGS.iter().find(|(known, _)| *known == ending).map(|(_, format)| *format);
    let packed = is_zip(path);
    if known(&ending).is_none() && !packed {
        input::check(path)?;
        return Err(unknown_ending(path, &ending));
    }
    let is_city_gml = known(&ending) == Some(Format::CityGml)
        || (packed && known(&ending).is_none() && input::members::has(path, &citygml::ENDINGS));
    if is_city_gml {
        return settled(citygml::read(path, asked)?, path);
    }
    // SQLite reads a GeoPackage itself.
    let is_database = known(&ending) == Some(Format::Features(FeatureFormat::GeoPackage));
    let may_be_shapefile = matches!(known(&ending), None | Some(Format::Features(FeatureFormat::Shapefile)));
    if packed
        && may_be_shapefile
        && let Some(geometry) = features::zipped_shapefile(path, asked)?
    {
        return finished(geometry);
    }
    let NamedBytes { name, bytes } = match is_database {
        true => input::check(path).map(|()| NamedBytes { name: None, bytes: Vec::new() }),
        false => input::read_named(path, "read"),
    }?;
    if let Some(name) = name.filter(|_| known(&ending).is_none()) {
        ending = input::ending(Path::new(&name));
    }
    let Some(format) = known(&ending) else { return Err(unknown_ending(path, &ending)) };
    let bytes = if format.is_text() { utf8(bytes) } else { bytes };
    if let Some(refusal) = unread::refusal_of_content(path, &bytes) {
        return Err(refusal);
    }
    let mut geometry = match format {
        Format::AsciiGrid => return ascii_grid::parse(&bytes, path).map(Content::Terrain),
        Format::GeoTiff => return geotiff::parse(&bytes, path).map(Content::Terrain),
        Format::EnergyPlus => energyplus::parse(&bytes, path, asked),
        Format::Features(kind) => features::parse(kind, bytes, path, asked),
        Format::Gltf => gltf::parse(&bytes, path, asked),
        Format::Honeybee => honeybee::parse(&bytes, path, asked),
        Format::Json if honeybee::is_model(&bytes) => honeybee::parse(&bytes, path, asked),
        Format::Json if energyplus::is_model(&bytes) => energyplus::parse(&bytes, path, asked),
        Format::Json if features::is_geojson(&bytes) => features::parse(FeatureFormat::GeoJson, bytes, path, asked),
        // The name inside a zip is not CityGML here: such an archive was read above.
        Format::CityGml => citygml::read(path, asked),
        Format::CityJson | Format::Json => cityjson::parse(&bytes, path, asked),
        Format::Obj => obj::read(&bytes, path, asked),
        Format::Ply => ply::parse(&bytes, path),
        Format::Stl => stl::parse(&bytes, path),
    }?;
    // Formats of meshes fix no axis that points up.
    if matches!(format, Format::Gltf | Format::Obj | Format::Ply | Format::Stl) {
        geometry.local_frame = to_local(&mut geometry.vertices, asked.local_frame);
        if let Some(frame) = geometry.local_frame {
            geometry.reference = Some(frame.reference());
            geometry.warnings.push(format!(
                "{}: its geocentric (EPSG:4978) coordinates became x, y and z in metres east, north and up of {} at height 0 of the \
                 ellipsoid",
                path.display(),
                frame.reference()
            ).into());
        }
        return finished(geometry);
    }
    settled(geometry, path)
}

/// Finishes polygons of a format that has z up. Refuses geocentric coordinates, in which z is not
/// up.
fn settled(geometry: Geometry, path: &Path) -> Result<Content> {
    if is_geocentric(&geometry.vertices) {
        let hint = "reproject the file to a system in metres with z up, such as the national grid or UTM";
        return Err(Error::input(
            path,
            None,
            "its coordinates are geocentric: distances from the Earth's centre",
            hint,
        ));
    }
    finished(geometry)
}

/// Turns the faces outwards and returns the polygons.
fn finished(mut geometry: Geometry) -> Result<Content> {
    facing::settle(&mut geometry);
    // Names of some CityJSON faces depend on their tilt, which is final only now.
    cityjson::name_by_tilt(&mut geometry);
    Ok(Content::Polygons(Box::new(geometry)))
}

/// Reads the areas of a file of features, in metres of the plane system `scene`, and sentences for
/// the user.
pub(super) fn read_areas(path: &Path, scene: Option<u32>) -> Result<(Vec<Outline>, Vec<Message>)> {
    input::check(path)?;
    if is_zip(path)
        && let Some(read) = features::zipped_areas(path, scene)?
    {
        return Ok(read);
    }
    let ending = input::ending(path);
    let kind = match ENDINGS.iter().find(|(known, _)| *known == ending).map(|(_, format)| *format) {
        Some(Format::Features(kind)) if kind != FeatureFormat::TreeCsv => kind,
        Some(Format::Json) => FeatureFormat::GeoJson,
        _ => {
            return Err(Error::Unsupported {
                what: format!("the areas {}", path.display()).into(),
                found: format!("a name that ends with .{}", excerpt(ending.as_bytes())),
                supported: "polygons as .geojson, .gpkg, .shp (also in a .zip) or .parquet, or their corners as .csv"
                    .into(),
            });
        }
    };
    let bytes = match kind {
        FeatureFormat::GeoPackage => Vec::new(),
        FeatureFormat::GeoJson => utf8(input::read(path)?),
        _ => input::read(path)?,
    };
    features::areas(kind, bytes, path, scene)
}

fn unknown_ending(path: &Path, ending: &str) -> Error {
    if let Some(refusal) = unread::refusal(path, ending) {
        return refusal;
    }
    Error::Unsupported {
        what: format!("the scene {}", path.display()).into(),
        found: if ending.is_empty() {
            "a name without ending".into()
        } else {
            format!("a name that ends with .{}", excerpt(ending.as_bytes()))
        },
        supported: SUPPORTED.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The message that lists the supported endings lists all of them, and says that each may be
    /// packed.
    #[test]
    fn the_message_lists_every_ending() {
        for (ending, format) in ENDINGS {
            assert!(SUPPORTED.contains(&format!(".{ending}")), "{format:?}");
        }
        assert!(SUPPORTED.contains(".gz"));
    }

    /// 27 of 28 endings belong to one format, packed or not.
    #[test]
    fn every_ending_but_json_names_one_format() {
        let named = |ending: &str, more: &str| format_of_name(Path::new(&format!("A.{}{more}", ending.to_uppercase())));
        assert_eq!(ENDINGS.iter().filter(|(ending, _)| named(ending, "").is_some()).count(), 27);
        assert!(ENDINGS.iter().all(|(ending, _)| named(ending, "") == named(ending, ".gz")));
        assert_eq!((named("hbjson", ".gz"), named("json", ""), named("csv", "")), (Some("Honeybee"), None, None));
    }
}
