//! Readers of scene files, one a file, chosen by the ending of the name. In: a file of unknown origin. Out: polygons whose every
//! index and coordinate is checked. They drop nothing silently and never look at another file than those they are given.

mod ascii_grid;
mod building;
mod cityjson;
pub(crate) mod energyplus;
mod geokeys;
mod geotiff;
mod gltf;
mod honeybee;
mod mtl;
pub(super) mod obj;
mod ply;
mod ply_body;
mod ply_header;
mod stl;
#[cfg(test)]
mod test_solids;
mod tiff_directory;

use std::collections::BTreeSet;
use std::path::Path;

use crate::facing;
use crate::geometry::Geometry;
use crate::input;
use crate::model_version::ModelVersion;
use crate::terrain::raster::Raster;
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};

/// What is asked of a reader besides the geometry.
#[derive(Clone, Debug, Default)]
pub(super) struct Asked {
    /// Whether the materials that the file itself describes are wanted.
    pub reflectances: bool,
    /// Names of those that somebody else describes: what the file says of them does not matter.
    pub described: BTreeSet<String>,
    /// Level of detail where an object carries several; the finest without it.
    pub lod: Option<String>,
    /// Version of EnergyPlus that models are taken for, whatever they state.
    pub assume_version: Option<ModelVersion>,
}

impl Asked {
    /// Whether what the file says of a material is wanted.
    fn wants(&self, material: &str) -> bool {
        self.reflectances && !self.described.contains(material)
    }
}

/// What a file holds.
pub(super) enum Content {
    Polygons(Box<Geometry>),
    Terrain(Raster),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    AsciiGrid,
    CityJson,
    EnergyPlus,
    GeoTiff,
    Gltf,
    Honeybee,
    /// What it holds decides.
    Json,
    Obj,
    Ply,
    Stl,
}

/// What names end with, in lower case; `.gz` may stand behind each.
const ENDINGS: [(&str, Format); 14] = [
    ("asc", Format::AsciiGrid),
    ("dem", Format::AsciiGrid),
    ("epjson", Format::EnergyPlus),
    ("glb", Format::Gltf),
    ("gltf", Format::Gltf),
    ("hbjson", Format::Honeybee),
    ("idf", Format::EnergyPlus),
    ("json", Format::Json),
    ("jsonl", Format::CityJson),
    ("obj", Format::Obj),
    ("ply", Format::Ply),
    ("stl", Format::Stl),
    ("tif", Format::GeoTiff),
    ("tiff", Format::GeoTiff),
];

const SUPPORTED: &str = ".json and .jsonl (CityJSON), .tif, .tiff, .asc and .dem (terrain), .epjson and .idf (EnergyPlus), .hbjson \
                         (Honeybee), .gltf, .glb, .obj, .ply, .stl, each also packed, with .gz behind it, and site.toml";

/// The format of scenes that a name certainly belongs to, `.gz` or not; `None` also for `.json`, which may be much else.
pub fn format_of_name(path: &Path) -> Option<&'static str> {
    let ending = input::ending(path);
    ENDINGS.iter().find(|(known, _)| *known == ending).and_then(|(_, format)| format.name())
}

impl Format {
    fn name(self) -> Option<&'static str> {
        Some(match self {
            Format::AsciiGrid => "ASCII grid",
            Format::CityJson => "CityJSON",
            Format::EnergyPlus => "EnergyPlus",
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

/// Reads a scene file of any format.
pub(super) fn read(path: &Path, asked: &Asked) -> Result<Content> {
    let ending = input::ending(path);
    let Some((_, format)) = ENDINGS.iter().find(|(known, _)| *known == ending) else {
        input::check(path)?;
        return Err(Error::Unsupported {
            what: format!("the scene {}", path.display()),
            found: if ending.is_empty() {
                "a name without ending".into()
            } else {
                format!("a name that ends with .{}", excerpt(ending.as_bytes()))
            },
            supported: SUPPORTED.into(),
        });
    };
    let bytes = input::read(path)?;
    match format {
        Format::AsciiGrid => ascii_grid::parse(&bytes, path).map(Content::Terrain),
        Format::EnergyPlus => energyplus::parse(&bytes, path, asked).map(polygons),
        Format::GeoTiff => geotiff::parse(&bytes, path).map(Content::Terrain),
        Format::Gltf => gltf::parse(&bytes, path, asked).map(polygons),
        Format::Honeybee => honeybee::parse(&bytes, path, asked).map(polygons),
        Format::Json if honeybee::is_model(&bytes) => honeybee::parse(&bytes, path, asked).map(polygons),
        Format::Json if energyplus::is_model(&bytes) => energyplus::parse(&bytes, path, asked).map(polygons),
        Format::CityJson | Format::Json => cityjson::parse(&bytes, path, asked).map(polygons),
        Format::Obj => obj::read(&bytes, path, asked).map(polygons),
        Format::Ply => ply::parse(&bytes, path).map(polygons),
        Format::Stl => stl::parse(&bytes, path).map(polygons),
    }
}

/// Puts the faces in order, and names those that only their tilt tells.
fn polygons(mut geometry: Geometry) -> Content {
    facing::settle(&mut geometry);
    cityjson::name_by_tilt(&mut geometry);
    Content::Polygons(Box::new(geometry))
}

/// Name of a file without its folder and ending: what an object without a name is called.
pub(super) fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.split('.').find(|part| !part.is_empty()).unwrap_or("scene").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The message that names the endings names all of them, and says that each may be packed.
    #[test]
    fn endings_are_named() {
        for (ending, format) in ENDINGS {
            assert!(SUPPORTED.contains(&format!(".{ending}")), "{format:?}");
        }
        assert!(SUPPORTED.contains(".gz"));
    }

    /// Of 14 endings 13 belong to one format, packed or not.
    #[test]
    fn formats_of_names() {
        let named = |ending: &str, more: &str| format_of_name(Path::new(&format!("A.{}{more}", ending.to_uppercase())));
        assert_eq!(ENDINGS.iter().filter(|(ending, _)| named(ending, "").is_some()).count(), 13);
        assert!(ENDINGS.iter().all(|(ending, _)| named(ending, "") == named(ending, ".gz")));
        assert_eq!((named("hbjson", ".gz"), named("json", ""), named("csv", "")), (Some("Honeybee"), None, None));
    }
}
