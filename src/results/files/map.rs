//! Maps of results. In: a stream, groups of its receivers. Out: a map that waits for values. A map
//! that cannot be drawn is refused before anything is computed.

use std::path::Path;

use glam::DVec3;

use crate::outputs::groups::Groups;
use crate::outputs::provenance::Provenance;
use crate::outputs::row_maker::RowMaker;
use crate::outputs::shapes::MapCrs;
use crate::outputs::shapes::group_patches::{PatchSorter, Shapeless};
use crate::outputs::shapes::writer::{MapFormat, MapRequest, MapStats, MapWriter, PlaceShapes, Surroundings};
use crate::receivers::ReceiverSet;
use crate::resources::Resources;
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::Use;
use heliotile_core::observer::Observer;
use heliotile_core::opened::OpenSite;
use heliotile_core::text::message;

/// Number of polygons beyond which most programs read GeoJSON slowly.
const MANY_POLYGONS: u64 = 10_000;

/// Map that is about to be started.
pub struct MapStart<'a> {
    pub path: &'a Path,
    pub format: MapFormat,
    /// Number of maps that share the memory.
    pub share: usize,
    /// Columns of the map and labels of its values.
    pub rows: &'a RowMaker,
    /// Description of the values in words.
    pub called: &'a str,
    /// Provenance of the values.
    pub about: &'a Provenance,
    /// Receivers whose scene is drawn around the map.
    pub scene: &'a ReceiverSet<'a>,
    /// Receivers that are drawn, or that belong to the drawn groups.
    pub receivers: &'a ReceiverSet<'a>,
}

impl<'a> MapStart<'a> {
    /// Starts the map of `groups`, or of receivers if `None`. Fails if receivers have no shape to
    /// draw. `place` is the path of the archive or of the atlas.
    pub fn start(self, resources: &Resources<'a>, groups: Option<&Groups>, place: &Path) -> Result<MapWriter<'a>> {
        let request = self.request(resources)?;
        let (receivers, memory) = (self.receivers, resources.memory);
        let shapes = match groups {
            Some(groups) => {
                let most = memory.length(Use::MapPatches) / self.share.max(1);
                let mut patches = PatchSorter::new(&request.folder, most);
                for (number, receiver) in receivers.shown().enumerate() {
                    patches.push(groups.place_of(number)?, receiver?)?;
                }
                PlaceShapes::Groups(Box::new(patches.finish(place)?))
            }
            None => {
                if !self.format.shows_points() {
                    Shapeless::refuse(receivers.shown(), place)?;
                }
                PlaceShapes::Receivers(Box::new(receivers.shown()))
            }
        };
        MapWriter::create(request, shapes)
    }

    /// Starts a map of other shapes.
    pub fn with_shapes(self, shapes: PlaceShapes<'a>, resources: &Resources<'a>) -> Result<MapWriter<'a>> {
        MapWriter::create(self.request(resources)?, shapes)
    }

    fn request(&self, resources: &Resources<'a>) -> Result<MapRequest<'a>> {
        let [first, others @ ..] = self.receivers.parts() else {
            return Err(Error::argument(
                "receivers",
                "no receiver is selected, so the map would be empty",
                "choose some receivers",
            ));
        };
        // The parts of an atlas show their neighbours, so no surroundings are drawn around several.
        let shows = self.format.shows_surroundings() && others.is_empty();
        let around = self.scene.parts().first().filter(|_| shows);
        let request = MapRequest {
            path: self.path,
            format: self.format,
            layout: self.rows.layout(),
            labels: self.rows.bin_labels(),
            every: self.rows.every(),
            crs: crs_of(first.archive),
            north: self.receivers.north(),
            called: self.called.to_owned(),
            around: around.and_then(|part| surroundings(part.archive, &part.site)),
            about: self.about.clone(),
            folder: std::env::temp_dir(),
            storage: resources.storage,
            memory_bytes: resources.memory.length(Use::MapRows) / self.share.max(1),
            archives: self.receivers.parts().iter().map(|part| part.archive).collect(),
        };
        request.columns()?;
        Ok(request)
    }
}

/// Returns the coordinate system of an archive.
pub fn crs_of(archive: &Archive) -> MapCrs {
    let manifest = archive.manifest();
    let [low, high] = manifest.scene.bounds_m.map(DVec3::from);
    MapCrs::new(manifest.place.as_ref(), 0.5 * (low + high))
}

/// Returns the triangles of an archive's scene, if it holds any.
pub fn surroundings<'a>(archive: &Archive, site: &OpenSite<'a>) -> Option<Surroundings<'a>> {
    let chunks = archive.entries_of(format::SCENE).len() as u32;
    let origin = DVec3::from(archive.manifest().scene.origin_m);
    (chunks > 0).then(|| Surroundings { site: site.clone(), chunks, origin })
}

/// Warns of a GeoJSON file that is too large for most programs.
pub fn say_large(path: &Path, stats: &MapStats, observer: &dyn Observer) {
    let MapStats { facts, bytes } = stats;
    let is_geojson = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("geojson"));
    if is_geojson && facts.polygons > MANY_POLYGONS {
        observer.warn(message!(
            "{} has {} polygons and {} MB, slow to read for browsers and text readers: .fgb (QGIS) and .parquet with {{geo}} (geopandas) are smaller",
            path.display(),
            facts.polygons,
            bytes.div_ceil(1_000_000)
        ));
    }
}
