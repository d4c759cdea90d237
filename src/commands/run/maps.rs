//! Further maps of a run's annual sums, beside `annual.ply`, and their picture. In: its archive, the sums of its receivers. Out: files as
//! `replay` writes them.

use std::path::Path;

use glam::DVec3;

use super::folder::Files;
use crate::cli::{RunArgs, RunMap};
use crate::commands::replay::mapped::{crs_of, say_large, surroundings};
use crate::commands::replay::pictures::name_of;
use crate::commands::temporary_files;
use crate::outputs::annual::AnnualRow;
use crate::outputs::periods::Every;
use crate::outputs::provenance::Provenance;
use crate::outputs::shapes::MapCrs;
use crate::outputs::shapes::group_patches::Shapeless;
use crate::outputs::shapes::writer::{MapFormat, MapRequest, MapWriter, PlaceShapes};
use crate::outputs::tables::layout::{By, Labels, Layout};
use crate::outputs::tables::row_labels::RowLabels;
use heliotile_builder::transfer::{ArchiveReceivers, Shown};
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentList};
use heliotile_core::replay::values::TileValues;
use heliotile_core::site::place::Place;
use heliotile_core::site::receiver::{Receiver, TILE};
use heliotile_scene::input;
use heliotile_scene::site::Site;

/// Refuses maps that a scene of this place cannot have, before any work.
pub fn check(args: &RunArgs, place: Option<&Place>) -> Result<()> {
    let crs = MapCrs::of(place, DVec3::ZERO);
    formats(args).try_for_each(|format| format.check(&crs))
}

fn formats(args: &RunArgs) -> impl Iterator<Item = MapFormat> {
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

/// Writes the picture and the maps that are asked for; receivers that these cannot draw are an error.
pub fn write(args: &RunArgs, files: &Files, archive: &Archive, rows: &[AnnualRow], about: &Provenance) -> Result<()> {
    let site = OpenSite::of(archive)?;
    let shown = || {
        let rows = ArchiveReceivers::<Shown>::new(&site);
        rows.map(|row| row.map(|row| Receiver { patch: row.layers.patch, ..row.receiver }))
    };
    let formats = || formats(args).chain([MapFormat::Png]);
    if !formats().all(MapFormat::shows_points) {
        Shapeless::refuse(shown(), &files.archive)?;
    }
    let layout = Layout { labels: Labels::Sums, by: By::Receiver, components: ComponentList::all(), facts: Vec::new() };
    let (labels, storage) = (RowLabels::words(vec!["total".into()]), temporary_files());
    let called = format!("{} under {}", name_of(&files.archive), name_of(&args.weather));
    for format in formats() {
        let path =
            if format == MapFormat::Png { files.picture.clone() } else { files.further_map(RunMap::Map(format)) };
        let request = MapRequest {
            path: &path,
            format,
            layout: &layout,
            labels: &labels,
            every: Some(Every::Total),
            crs: crs_of(archive),
            north: site.north(),
            called: called.clone(),
            around: format.shows_surroundings().then(|| surroundings(archive, &site)).flatten(),
            about: about.clone(),
            folder: std::env::temp_dir(),
            storage: &storage,
            memory_bytes: MemoryBudget::new(args.memory.0).length(Use::MapRows),
        };
        let mut map = MapWriter::create(request, PlaceShapes::Receivers(Box::new(shown())))?;
        for some in rows.chunks(TILE) {
            let names: Vec<String> = some.iter().map(|row| row.receiver.id.clone()).collect();
            let mut values = TileValues::new(some.len(), 1);
            for component in Component::ALL {
                let column = values.component_mut(component);
                column.iter_mut().zip(some).for_each(|(to, row)| *to = row.kwh_m2[component as usize]);
            }
            map.write_tile(&names, &values, &[])?;
        }
        say_large(&path, &map.finish()?);
    }
    Ok(())
}
