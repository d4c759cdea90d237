//! Results as a map. In: an archive, its chosen receivers, groups of them. Out: a map that waits for values; nothing is computed before it is
//! known that it can be drawn.

use std::path::Path;

use glam::DVec3;

use crate::cli::TableArgs;
use crate::commands::warn;
use crate::outputs::groups::Groups;
use crate::outputs::periods::Every;
use crate::outputs::provenance::Provenance;
use crate::outputs::shapes::MapCrs;
use crate::outputs::shapes::group_patches::{PatchSorter, Shapeless};
use crate::outputs::shapes::writer::{MapFormat, MapRequest, MapStats, MapWriter, PlaceShapes, Surroundings};
use crate::outputs::tables::layout::Layout;
use crate::outputs::tables::row_labels::RowLabels;
use crate::recombine::Chosen;
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::light::scratch::ScratchSpace;
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::opened::OpenSite;

/// GeoJSON with more polygons is slow wherever it is read.
const MANY_POLYGONS: u64 = 10_000;

/// Starts a map of groups, or of receivers where there are none; receivers that cannot be drawn are an error.
pub fn start<'a>(
    asked: &TableArgs,
    (path, format): (&'a Path, MapFormat),
    (chosen, groups): (&'a Chosen<'a>, Option<&Groups>),
    (layout, labels, every): (&'a Layout, &'a RowLabels, Option<Every>),
    (about, called): (Provenance, &str),
    storage: &'a dyn ScratchSpace,
) -> Result<MapWriter<'a>> {
    let memory = MemoryBudget::new(asked.memory.0);
    let [first, others @ ..] = chosen.parts() else {
        return Err(Error::argument("--receivers", "there is nothing to draw", "choose some receivers"));
    };
    // Parts of an atlas show their neighbours, too.
    let shows = format.shows_surroundings() && others.is_empty();
    let folder = std::env::temp_dir();
    let request = MapRequest {
        path,
        format,
        layout,
        labels,
        every,
        crs: crs_of(first.archive),
        north: chosen.north(),
        called: called.to_owned(),
        around: shows.then(|| surroundings(first.archive, &first.site)).flatten(),
        about,
        folder: folder.clone(),
        storage,
        memory_bytes: memory.length(Use::MapRows),
    };
    request.columns()?;
    let shown = || chosen.shown();
    let shapes = match groups {
        Some(groups) => {
            let mut patches = PatchSorter::new(&folder, memory.length(Use::MapPatches));
            for (number, receiver) in shown().enumerate() {
                patches.push(groups.place_of(number), receiver?)?;
            }
            PlaceShapes::Groups(Box::new(patches.finish(&asked.archive)?))
        }
        None => {
            if !format.shows_points() {
                Shapeless::refuse(shown(), &asked.archive)?;
            }
            PlaceShapes::Receivers(Box::new(shown()))
        }
    };
    MapWriter::create(request, shapes)
}

/// The system of an archive's coordinates.
pub fn crs_of(archive: &Archive) -> MapCrs {
    let manifest = archive.manifest();
    let [low, high] = manifest.scene.bounds_m.map(DVec3::from);
    MapCrs::of(manifest.place.as_ref(), 0.5 * (low + high))
}

/// The triangles that an archive shows, if it shows any.
pub fn surroundings<'a>(archive: &Archive, site: &OpenSite<'a>) -> Option<Surroundings<'a>> {
    let chunks = archive.entries_of(format::SCENE).len() as u32;
    let origin = DVec3::from(archive.manifest().scene.origin_m);
    (chunks > 0).then(|| Surroundings { site: site.clone(), chunks, origin })
}

/// Warns of a GeoJSON file that is too large for what reads such files.
pub fn say_large(path: &Path, MapStats { facts, bytes }: &MapStats) {
    let is_geojson = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("geojson"));
    if is_geojson && facts.polygons > MANY_POLYGONS {
        warn(&format!(
            "{} has {} polygons and {} MB, which browsers and text readers take long for: .fgb (QGIS) and .parquet with --geo (geopandas) \
             hold the same in less",
            path.display(),
            facts.polygons,
            bytes.div_ceil(1_000_000)
        ));
    }
}
