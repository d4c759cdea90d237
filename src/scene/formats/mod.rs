//! Readers of scene files, one a file, chosen by the ending of the name. In: a file of unknown origin. Out: polygons whose every
//! index and coordinate is checked. They drop nothing silently and never look at another file than those they are given.

mod ascii_grid;
mod cityjson;
mod energyplus;
#[cfg(test)]
mod energyplus_tests;
mod geokeys;
mod geotiff;
mod gltf;
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

use crate::geometry::Geometry;
use crate::terrain::raster::Raster;
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

const ENDINGS: &str = ".json and .jsonl (CityJSON), .tif, .tiff and .asc (terrain), .epJSON and .idf (EnergyPlus), .gltf, .glb, .obj, \
                       .ply, .stl, and site.toml";

/// Reads a scene file of any format.
pub(super) fn read(path: &Path, asked: &Asked) -> Result<Content> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let (_, ending) = name.rsplit_once('.').unwrap_or_default();
    match ending {
        "asc" => ascii_grid::read(path, asked).map(Content::Terrain),
        "epjson" | "idf" => energyplus::read(path, asked).map(polygons),
        "gltf" | "glb" => gltf::read(path, asked).map(polygons),
        "json" if energyplus::is_model(path)? => energyplus::read(path, asked).map(polygons),
        "json" | "jsonl" => cityjson::read(path, asked).map(polygons),
        "obj" => obj::read(path, asked).map(polygons),
        "ply" => ply::read(path, asked).map(polygons),
        "stl" => stl::read(path, asked).map(polygons),
        "tif" | "tiff" => geotiff::read(path, asked).map(Content::Terrain),
        _ => Err(Error::Unsupported {
            what: format!("the scene {}", path.display()),
            found: if ending.is_empty() {
                "a name without ending".into()
            } else {
                format!("a name that ends with .{ending}")
            },
            supported: ENDINGS.into(),
        }),
    }
}

fn polygons(geometry: Geometry) -> Content {
    Content::Polygons(Box::new(geometry))
}

/// Name of a file without its folder and ending: what an object without a name is called.
pub(super) fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.split('.').find(|part| !part.is_empty()).unwrap_or("scene").to_owned()
}
