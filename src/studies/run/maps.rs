//! Maps that a run may write. In: its arguments, the scene. Out: a refusal before any work, and the
//! city model that gets sums.

use std::path::Path;

use glam::DVec3;

use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::named::NamedValues;
use heliotile_core::site::place::Place;
use heliotile_core::text::Message;
use heliotile_files::input;
use heliotile_results::outputs::shapes::MapCrs;
use heliotile_results::outputs::shapes::writer::MapFormat;
use heliotile_scene::site::SceneFiles;

/// Map of the annual sums.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RunMap {
    /// Map of polygons.
    Map(MapFormat),
    /// City model of the scene, with sums.
    CityModel,
}

impl NamedValues for RunMap {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("glb", "For Blender, three.js and Cesium, with the scene around", RunMap::Map(MapFormat::Glb)),
        ("fgb", "FlatGeobuf, for QGIS", RunMap::Map(MapFormat::FlatGeobuf)),
        ("geojson", "Longitude and latitude, for small maps in browsers", RunMap::Map(MapFormat::GeoJson)),
        ("geoparquet", "For geopandas and DuckDB: annual.parquet", RunMap::Map(MapFormat::GeoParquet)),
        ("ply", "Coloured triangles, for MeshLab and CloudCompare", RunMap::Map(MapFormat::Ply)),
        ("vtu", "For ParaView and PyVista", RunMap::Map(MapFormat::Vtu)),
        ("cityjson", "The CityJSON of the scene with attributes: annual.city.json", RunMap::CityModel),
    ];
}

heliotile_core::serde_by_name!(RunMap);

/// Refuses maps that a scene of this place cannot have, before any work.
pub fn check(maps: &[RunMap], place: Option<&Place>) -> Result<()> {
    let crs = MapCrs::new(place, DVec3::ZERO);
    formats(maps).try_for_each(|format| format.check(&crs, "map"))
}

/// Returns the formats of the further maps.
pub fn formats(maps: &[RunMap]) -> impl Iterator<Item = MapFormat> {
    maps.iter().filter_map(|map| match map {
        RunMap::Map(format) => Some(*format),
        RunMap::CityModel => None,
    })
}

/// Returns the city model of a scene that sums can be written into.
pub fn city_model_of(site: &SceneFiles) -> Result<&Path> {
    let refuse = |what: Message, hint: &'static str| {
        Err(Error::argument("map", what, hint).because(Problem::other_kind("not CityJSON")))
    };
    match city_models(site).as_slice() {
        [only] => {
            let text = input::read(only)?;
            if !text.windows(CITY_JSON.len()).any(|part| part == CITY_JSON) {
                let what = format!("`{}` is not CityJSON", only.display());
                return refuse(what.into(), "give the scene as CityJSON, or choose another map");
            }
            Ok(only)
        }
        [] => refuse("no file of the scene is CityJSON".into(), "give the scene as CityJSON, or choose another map"),
        _ => refuse(
            "several files of the scene may be CityJSON".into(),
            "replay site.helio with {model} FILE.city.json {output} OUT.city.json, once for each",
        ),
    }
}

/// Bytes that every city model contains.
const CITY_JSON: &[u8] = b"\"CityJSON";

/// Returns the files that may be city models, by their names.
fn city_models(site: &SceneFiles) -> Vec<&Path> {
    let files = site.parts.iter().map(|part| part.file.as_path());
    files.filter(|file| ["json", "jsonl", "cityjson", "cityjsonl"].contains(&input::ending(file).as_str())).collect()
}

/// Returns true if the city model of a scene is a sequence of features.
pub fn is_sequence(site: &SceneFiles) -> bool {
    city_models(site).first().is_some_and(|file| ["jsonl", "cityjsonl"].contains(&input::ending(file).as_str()))
}

heliotile_core::parse_by_name!(RunMap);
