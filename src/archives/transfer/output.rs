//! Assembly of an archive from receivers and cells of others, in the build's order of blocks. In:
//! rows of other archives. Out: an archive.

use std::fs;
use std::path::Path;

use rayon::prelude::*;

use crate::Workspace;
use crate::pack;
use crate::pack::Chunks;
use crate::transfer::compare::shows;
use crate::transfer::rows::{LayeredReceiver, Shown, TracedLayers};
use crate::writing::{Job, Summary, Writer};
use heliotile_core::archive::format::{CellKind, TileNumber};
use heliotile_core::archive::settings::Settings;
use heliotile_core::archive::{Archive, EncodedBlock, Manifest, format, manifest, tables};
use heliotile_core::error::{Error, Result};
use heliotile_core::layers::cells::{Cell, Cells};
use heliotile_core::layers::extras::ReceiverExtras;
use heliotile_core::layers::hit::HitTile;
use heliotile_core::layers::response::Response;
use heliotile_core::layers::sky::SkyTexture;
use heliotile_core::memory::Use;
use heliotile_core::observer::{Observer, Stage};
use heliotile_core::site::receiver::TILE;

/// Archive being written. Its methods are called in the order in which they are declared.
pub struct ArchiveAssembly<'a> {
    observer: &'a dyn Observer,
    writer: Writer,
    receivers: u64,
    tiles: u32,
    cells: manifest::CellCounts,
}

/// Content of the assembled archive.
#[derive(Clone, Debug)]
pub struct Assembled {
    /// Number of receivers.
    pub receivers: u64,
    /// Number of their tiles.
    pub tiles: u32,
    /// Number of cells of both kinds.
    pub cells: manifest::CellCounts,
    /// Length and root of the archive.
    pub summary: Summary,
}

impl<'a> ArchiveAssembly<'a> {
    pub fn create(path: &Path, inputs: &[&Archive], observer: &'a dyn Observer) -> Result<Self> {
        let same = |archive: &&&Archive| match (fs::canonicalize(path), fs::canonicalize(archive.path())) {
            (Ok(a), Ok(b)) => a == b,
            _ => false,
        };
        if inputs.iter().find(same).is_some() {
            let what = "is also an input, and would be replaced";
            return Err(Error::input(path, None, what, "give the output a name of its own"));
        }
        let hash = |what: &[u8]| {
            let mut hasher = blake3::Hasher::new();
            hasher.update(what);
            for archive in inputs {
                hasher.update(&archive.root());
            }
            *hasher.finalize().as_bytes()
        };
        // The archive is written in one go, without checkpoints. The job only tells it from an
        // interrupted build.
        let job = Job { scene: hash(b"scene"), receivers: hash(b"receivers"), settings: hash(b"settings") };
        let advice = "finish it with the build that began it, remove it, or give the archive another name";
        let writer = Writer::create(path, &job).map_err(|error| error.advise(advice))?;
        Ok(ArchiveAssembly { observer, writer, receivers: 0, tiles: 0, cells: manifest::CellCounts::default() })
    }

    /// Writes receivers, sky and hit layers; no hits where rows have none, for replay only.
    pub fn tiles(&mut self, rows: impl Iterator<Item = Result<LayeredReceiver<TracedLayers>>>) -> Result<()> {
        (self.receivers, self.tiles) = self.cut("receivers", rows, |number, rows| {
            let hits: Vec<_> = rows.iter().map(|row| row.layers.hits.as_slice()).collect();
            let hits = hits.iter().any(|of| !of.is_empty()).then(|| HitTile::new(&hits));
            let sky: Vec<SkyTexture> = rows.iter().map(|row| row.layers.sky.clone()).collect();
            let table = tables::ReceiversTable::new(rows.iter().map(|row| (&row.receiver, row.views)));
            let extras: Vec<ReceiverExtras> = rows.iter().map(|row| row.layers.extras.clone()).collect();
            let parts = tables::PartsTable::new(rows.iter().map(|row| &row.receiver));
            pack::tile(TileNumber(number), &table, parts.as_ref(), &sky, hits.as_ref(), &extras)
        })?;
        Ok(())
    }

    /// Writes probes and their index.
    pub fn probes(&mut self, settings: &Settings, cells: impl Iterator<Item = Result<Cell>>) -> Result<()> {
        self.cells.probes = self.chunks(Chunks::with_settings(CellKind::Probes, settings), cells)?;
        Ok(())
    }

    /// Writes bounce cells and their index.
    pub fn bounces(&mut self, settings: &Settings, cells: impl Iterator<Item = Result<Cell>>) -> Result<()> {
        self.cells.bounce_cells = self.chunks(Chunks::with_settings(CellKind::Bounces, settings), cells)?;
        Ok(())
    }

    /// Writes the materials of an archive.
    pub fn materials(&mut self, archive: &Archive) -> Result<()> {
        let table = tables::MaterialsTable::from_block(&archive.block(format::MATERIALS, TileNumber::FIRST)?)?;
        self.writer.append(table.encode(format::MATERIALS, TileNumber::FIRST, pack::COMPRESSION)?)?;
        if archive.has(format::OPTICS, TileNumber::FIRST) {
            let table = tables::OpticsTable::from_block(&archive.block(format::OPTICS, TileNumber::FIRST)?)?;
            self.writer.append(table.encode(format::OPTICS, TileNumber::FIRST, pack::COMPRESSION)?)?;
        }
        if archive.has(format::MIRRORS, TileNumber::FIRST) {
            let table = tables::MirrorsTable::from_block(&archive.block(format::MIRRORS, TileNumber::FIRST)?)?;
            self.writer.append(table.encode(format::MIRRORS, TileNumber::FIRST, pack::COMPRESSION)?)?;
        }
        if archive.has(format::BANDS, TileNumber::FIRST) {
            let table = tables::BandsTable::from_block(&archive.block(format::BANDS, TileNumber::FIRST)?)?;
            self.writer.append(table.encode(format::BANDS, TileNumber::FIRST, pack::COMPRESSION)?)?;
        }
        Ok(())
    }

    /// Writes the scene's triangles with their objects, if one of the archives, which share one
    /// scene, holds them.
    pub fn scene(&mut self, archives: &[&Archive]) -> Result<()> {
        let holds = |archive: &&&Archive| archive.has(format::SCENE, TileNumber::FIRST);
        let Some(archive) = archives.iter().find(holds) else { return Ok(()) };
        archive.expect_all(format::SCENE);
        archive.entries_of(format::SCENE).iter().try_for_each(|entry| {
            let table = tables::GeometryTable::from_block(&archive.fetch(entry)?)?;
            self.writer.append(table.encode(format::SCENE, entry.tile, pack::COMPRESSION)?)
        })?;
        archive.entries_of(format::OBJECTS).iter().try_for_each(|entry| {
            let table = tables::ObjectsTable::from_block(&archive.fetch(entry)?)?;
            self.writer.append(table.encode(format::OBJECTS, entry.tile, pack::COMPRESSION)?)
        })
    }

    /// Writes the responses of the receivers, in the order of the tiles.
    pub fn responses(&mut self, rows: impl Iterator<Item = Result<LayeredReceiver<Response>>>) -> Result<()> {
        self.cut("responses", rows, |number, rows| {
            let responses: Vec<Response> = rows.iter().map(|row| row.layers.clone()).collect();
            Ok(vec![pack::responses(TileNumber(number), &responses)?])
        })?;
        Ok(())
    }

    /// Writes the overview of the receivers, in the order of the tiles, if every archive has an
    /// overview.
    pub fn overview(
        &mut self,
        archives: &[&Archive],
        rows: impl Iterator<Item = Result<LayeredReceiver<Shown>>>,
    ) -> Result<()> {
        let Some(first) = archives.first().filter(|_| archives.iter().all(|archive| shows(archive))) else {
            return Ok(());
        };
        let origin = first.manifest().scene.origin_m.into();
        let shown = rows.map(|row| {
            row.map(|mut row| {
                row.receiver.patch = std::mem::take(&mut row.layers.patch);
                row
            })
        });
        self.cut("overview", shown, |number, rows| {
            let shown = rows.iter().map(|row| pack::OverviewRow {
                receiver: &row.receiver,
                sky_view: row.views[0],
                clear_year: row.layers.clear_year,
            });
            Ok(vec![pack::overview(TileNumber(number), origin, shown)?])
        })?;
        Ok(())
    }

    /// Writes the name index of the receivers, in the order of the tiles. Names that exceed the
    /// workspace's memory go to files in its folder.
    pub fn name_index(
        &mut self,
        workspace: &Workspace,
        mut rows: impl Iterator<Item = Result<LayeredReceiver<()>>>,
    ) -> Result<()> {
        let budget = workspace.memory.length(Use::NameIndex);
        let mut name_index = pack::NameIndexWriter::new(&workspace.folder, budget);
        loop {
            let tile: Vec<_> = rows.by_ref().take(TILE).collect::<Result<_>>()?;
            if tile.is_empty() {
                return name_index.finish(|block| self.writer.append(block));
            }
            name_index.add(tile.iter().map(|row| &row.receiver))?;
        }
    }

    /// Copies the blocks of kinds that this release does not know. Of equal names the first
    /// archive's block is copied.
    pub fn copy_unknown(&mut self, archives: &[&Archive]) -> Result<()> {
        let mut count = 0;
        for archive in archives {
            for entry in unknown(archive) {
                if !self.writer.has(entry.kind, entry.tile) {
                    self.writer.append(archive.copy(entry)?)?;
                    count += 1;
                }
            }
        }
        if count > 0 {
            self.observer.warn(format!(
                "{count} blocks of kinds that this release does not know were copied unchanged; the tiles and chunks that they may \
                 refer to were divided again"
            ));
        }
        Ok(())
    }

    /// Finishes with the statements of a manifest, including its unknown keys, and the counts of
    /// this archive.
    pub fn finish(self, stated: Manifest) -> Result<Assembled> {
        let ArchiveAssembly { writer, receivers, tiles, cells, .. } = self;
        let own = Manifest::new();
        let manifest = Manifest {
            creator: own.creator,
            receivers: manifest::ReceiverSummary {
                count: receivers,
                tile_size: TILE as u32,
                tiles,
                ..stated.receivers
            },
            counts: cells.clone(),
            layers: writer.layers(),
            ..stated
        };
        let summary = writer.finish(&manifest)?;
        Ok(Assembled { receivers, tiles, cells, summary })
    }

    /// Cuts rows into tiles and writes the blocks of each. Returns the numbers of rows and tiles.
    fn cut<L: Send + Sync>(
        &mut self,
        what: &'static str,
        mut rows: impl Iterator<Item = Result<LayeredReceiver<L>>>,
        pack: impl Fn(u32, &[LayeredReceiver<L>]) -> Result<Vec<EncodedBlock>> + Sync,
    ) -> Result<(u64, u32)> {
        let (mut count, mut tiles) = (0, 0);
        let progress = Stage::begin(self.observer, what, None);
        loop {
            // A multiple of TILE, so that only the last tile of all is not full.
            let some = TILE * rayon::current_num_threads();
            let batch: Vec<LayeredReceiver<L>> = rows.by_ref().take(some).collect::<Result<_>>()?;
            if batch.is_empty() {
                return Ok((count, tiles));
            }
            progress.advance(batch.len() as u64);
            let pack = |(i, rows)| pack(tiles + i as u32, rows);
            let blocks: Vec<Vec<EncodedBlock>> = batch.par_chunks(TILE).enumerate().map(pack).collect::<Result<_>>()?;
            count += batch.len() as u64;
            tiles += blocks.len() as u32;
            // Appended in the order of tiles, so that bytes do not depend on the number of threads.
            blocks.into_iter().flatten().try_for_each(|block| self.writer.append(block))?;
        }
    }

    fn chunks(&mut self, mut chunks: Chunks, mut cells: impl Iterator<Item = Result<Cell>>) -> Result<u64> {
        let progress = Stage::begin(self.observer, "cells", None);
        loop {
            let batch: Vec<Cell> = cells.by_ref().take(chunks.batch()).collect::<Result<_>>()?;
            progress.advance(batch.len() as u64);
            if batch.is_empty() {
                return chunks.finish(&mut self.writer);
            }
            let first = chunks.next();
            let encode = |(i, cells): (usize, &[Cell])| {
                let chunk = Cells::new(cells);
                let blocks = chunks.encode(TileNumber(first.0 + i as u32), &chunk)?;
                Ok((chunk, blocks))
            };
            let done: Vec<(Cells, Vec<EncodedBlock>)> =
                batch.par_chunks(chunks.size()).enumerate().map(encode).collect::<Result<_>>()?;
            done.into_iter().try_for_each(|(chunk, blocks)| chunks.add(&chunk, blocks, &mut self.writer))?;
        }
    }
}

/// Returns the entries of blocks whose kinds this release does not know.
pub fn unknown(archive: &Archive) -> impl Iterator<Item = &format::Entry> {
    archive.entries().iter().filter(|entry| format::schema_of(entry.kind).is_none())
}
