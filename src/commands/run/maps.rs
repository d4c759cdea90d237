//! Which maps a run may write. In: its arguments, the scene. Out: a refusal before any work, the city model that takes sums.

use std::path::Path;

use glam::DVec3;

use crate::cli::{RunArgs, RunMap};
use crate::outputs::shapes::MapCrs;
use crate::outputs::shapes::writer::MapFormat;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::place::Place;
use heliotile_scene::input;
use heliotile_scene::site::Site;

/// Refuses maps that a scene of this place cannot have, before any work.
pub fn check(args: &RunArgs, place: Option<&Place>) -> Result<()> {
    let crs = MapCrs::of(place, DVec3::ZERO);
    formats(args).try_for_each(|format| format.check(&crs))
}

/// Formats of the further maps.
pub fn formats(args: &RunArgs) -> impl Iterator<Item = MapFormat> {
    args.map.iter().filter_map(|map| match map {
        RunMap::Map(format) => Some(*format),
        RunMap::CityModel => None,
    })
}

/// The city model of a scene, which sums can be written into.
pub fn city_model_of(site: &Site) -> Result<&Path> {
    let refuse = |what: &str, hint: &str| Err(Error::argument("--map cityjson", what, hint));
    match city_models(site).as_slice() {
        [only] => {
            let text = input::read(only)?;
            if !text.windows(CITY_JSON.len()).any(|part| part == CITY_JSON) {
                let what = format!("`{}` is not CityJSON", only.display());
                return refuse(&what, "give the scene as CityJSON, or take another --map");
            }
            Ok(only)
        }
        [] => refuse("no file of the scene is CityJSON", "give the scene as CityJSON, or take another --map"),
        _ => refuse(
            "several files of the scene may be CityJSON",
            "write each with `heliotile replay site.helio --model FILE.city.json -o OUT.city.json`",
        ),
    }
}

/// What every city model holds.
const CITY_JSON: &[u8] = b"\"CityJSON";

/// Files that may be city models, by their names.
fn city_models(site: &Site) -> Vec<&Path> {
    let files = site.parts.iter().map(|part| part.file.as_path());
    files.filter(|file| ["json", "jsonl", "cityjson", "cityjsonl"].contains(&input::ending(file).as_str())).collect()
}

/// Whether the city model of a scene is a sequence of features.
pub fn is_sequence(site: &Site) -> bool {
    city_models(site).first().is_some_and(|file| ["jsonl", "cityjsonl"].contains(&input::ending(file).as_str()))
}
