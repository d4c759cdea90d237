//! Blocks about a site besides its light: the scene's triangles, an overview of its receivers, and
//! an index of their names and places. In: a mesh, receivers, the archive so far. Out: blocks.

use std::sync::Arc;

use rayon::prelude::*;

use super::report::Clock;
use super::site_tracer::SiteTracer;
use crate::receiver_tiles::ReceiverTiles;
use heliotile_archives::pack::{COMPRESSION, NameIndexWriter, OverviewRow, overview};
use heliotile_archives::writing::Writer;
use heliotile_core::archive::format::{Entry, TileNumber, content_id};
use heliotile_core::archive::tables::{GeometryTable, MAX_TRIANGLES, ObjectsTable};
use heliotile_core::archive::{Archive, EncodedBlock, format};
use heliotile_core::error::Result;
use heliotile_core::memory::Use;
use heliotile_core::observer::Stage;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::north::North;
use heliotile_core::site::place::Place;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::weather::clear::clear_year;
use heliotile_core::weather::conditions::in_axes;
use heliotile_scene::Scene;
use heliotile_scene::mesh::Mesh;

impl SiteTracer<'_> {
    /// Encodes the objects of all triangles, in the same chunks as [`SiteTracer::scene_blocks`]; no
    /// blocks for a scene without named objects.
    pub(super) fn object_blocks(&self) -> impl Iterator<Item = Result<EncodedBlock>> {
        let objects = &self.scene.objects;
        (0..).zip(objects.of_triangle.chunks(MAX_TRIANGLES)).map(|(chunk, some)| {
            ObjectsTable::new(&objects.list, some).encode(format::OBJECTS, TileNumber(chunk), COMPRESSION)
        })
    }

    /// Encodes all triangles in the order of the mesh, which is that of their vertices from west to
    /// east, block by block.
    pub(super) fn scene_blocks(&self) -> impl Iterator<Item = Result<EncodedBlock>> {
        let mesh = &self.scene.mesh;
        let count = mesh.triangles.len();
        (0..count).step_by(MAX_TRIANGLES).zip(0..).map(move |(first, chunk)| {
            let some = first..count.min(first + MAX_TRIANGLES);
            table(mesh, some).encode(format::SCENE, TileNumber(chunk), COMPRESSION)
        })
    }
}

impl SiteTracer<'_> {
    /// Writes the overview of all tiles after everything else, so that it is contiguous in the
    /// file.
    pub(super) fn write_overview(
        &self,
        receivers: &mut ReceiverTiles,
        writer: &mut Writer,
        clock: &mut Clock,
    ) -> Result<()> {
        let missing: Vec<u32> = (0..receivers.tile_count() as u32)
            .filter(|&tile| !writer.has(format::OVERVIEW, TileNumber(tile)))
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        let sums = match self.scene.place {
            Some(place) => self.clear_years(&place, &missing, &*writer)?,
            None => Vec::new(),
        };
        let mut sums = sums.into_iter();
        let mut tiles = (0..).zip(receivers.tiles()?).filter(|(tile, _)| missing.binary_search(tile).is_ok());
        loop {
            let batch: Vec<(u32, Result<Vec<Receiver>>)> = tiles.by_ref().take(GROUP).collect();
            if batch.is_empty() {
                clock.lap("overview");
                return Ok(());
            }
            let batch: Vec<(u32, Vec<Receiver>, Vec<f32>)> = batch
                .into_iter()
                .map(|(tile, receivers)| receivers.map(|of| (tile, sums.by_ref().take(of.len()).collect(), of)))
                .map(|tile| tile.map(|(tile, sums, of)| (tile, of, sums)))
                .collect::<Result<_>>()?;
            // The sky view is read back from the file, so resumed tiles need no special case.
            let site = OpenSite::over(&*writer, Arc::clone(&self.facts));
            let blocks: Vec<EncodedBlock> = batch
                .par_iter()
                .map(|(tile, receivers, sums)| {
                    let views = site.tile_receivers(*tile)?.sky_view;
                    let row = |(i, (receiver, sky_view))| OverviewRow {
                        receiver,
                        sky_view,
                        clear_year: sums.get(i).copied(),
                    };
                    let rows = receivers.iter().zip(views).enumerate().map(row);
                    overview(TileNumber(*tile), self.scene.mesh.origin, rows)
                })
                .collect::<Result<_>>()?;
            blocks.into_iter().try_for_each(|block| writer.append(block))?;
            self.checkpoint(writer)?;
        }
    }

    /// Writes the name index after everything else, so that it is contiguous in the file.
    pub(super) fn write_name_index(&self, receivers: &mut ReceiverTiles, writer: &mut Writer) -> Result<()> {
        // The chunk that lists the other chunks is written last, so the index is complete if it is
        // there.
        if writer.has(format::NAMES, TileNumber::FIRST) {
            return Ok(());
        }
        let mut name_index = NameIndexWriter::new(&self.folder, self.memory.length(Use::NameIndex));
        for tile in receivers.tiles()? {
            name_index.add(tile?.iter())?;
        }
        name_index.finish(|block| {
            let (kind, chunk) = block.entry().key();
            if writer.has(kind, chunk) { Ok(()) } else { writer.append(block) }
        })
    }

    /// Returns the sums over the clear year of all receivers of some tiles, kWh/m2, rounded to
    /// `SUM_STEP`.
    fn clear_years(&self, place: &Place, tiles: &[u32], writer: &Writer) -> Result<Vec<f32>> {
        let site = OpenSite::over(writer, Arc::clone(&self.facts));
        let (conditions, bins) = clear_year(place);
        // The axes of a site that is being built are not turned yet.
        let conditions = in_axes(&conditions, North::new(Some(place)));
        let settings = ReplaySettings { patches: PATCHES, memory: self.memory, ..ReplaySettings::default() };
        let replay = Replay::builder(&site, &conditions, settings).summed(&bins).build()?;
        let progress = Stage::begin(self.observer, "overview", Some(tiles.len() as u64));
        let mut sums = Vec::new();
        for tile in replay.results(tiles.iter().copied()) {
            let (ids, values) = tile?;
            let sum = |row| values.row(Component::Total, row).first().copied().unwrap_or_default();
            sums.extend((0..ids.len()).map(|row| (sum(row) / SUM_STEP).round() * SUM_STEP));
            progress.advance(1);
        }
        Ok(sums)
    }
}

/// Returns true if an archive that holds its scene has the same object names as a scene of the same
/// triangles.
pub fn holds_objects(archive: &Archive, scene: &Scene) -> bool {
    let held = archive.entries_of(format::OBJECTS);
    let chunks = || scene.objects.of_triangle.chunks(MAX_TRIANGLES);
    let same = |(entry, some): (&Entry, &[u32])| {
        let bytes = ObjectsTable::new(&scene.objects.list, some).to_bytes();
        bytes.is_ok_and(|bytes| content_id(entry.kind, entry.schema, &bytes) == entry.content)
    };
    held.len() == chunks().count() && held.iter().zip(chunks()).all(same)
}

/// Number of sky patches for clear years: the smallest number available.
const PATCHES: usize = 145;

/// Step to which sums are rounded, kWh/m2.
const SUM_STEP: f32 = 0.25;

/// Number of tiles that are written at a time.
const GROUP: usize = 64;

/// Returns the table of some triangles and their vertices, which keep their order.
fn table(mesh: &Mesh, some: std::ops::Range<usize>) -> GeometryTable {
    let triangles = &mesh.triangles[some.clone()];
    let mut rows: Vec<u32> = triangles.iter().flatten().copied().collect();
    rows.sort_unstable();
    rows.dedup();
    // Every corner is in `rows`, and there are less than 2^18.
    let place = |corner: &u32| rows.partition_point(|row| row < corner) as u32;
    GeometryTable {
        vertex: rows.iter().map(|&row| mesh.vertices[row as usize].as_vec3().to_array()).collect(),
        corner: triangles.iter().map(|corners| corners.each_ref().map(place)).collect(),
        material: mesh.triangle_material[some].to_vec(),
    }
}
