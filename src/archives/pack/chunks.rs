//! Chunks of one kind of cells for an archive, and the index that finds them. In: sorted cells.
//! Out: blocks.

use crate::pack::tile::{COMPRESSION, extra};
use crate::writing::Writer;
use heliotile_core::archive::format::{CellKind, TileNumber};
use heliotile_core::archive::settings::Settings;
use heliotile_core::archive::{EncodedBlock, format, tables};
use heliotile_core::error::Result;
use heliotile_core::layers::canopy::Canopy;
use heliotile_core::layers::cells::{Cells, cells_per_chunk};
use heliotile_core::site::cells::CellKey;

/// Chunks written so far. All but the last one hold [`Chunks::size`] cells.
pub struct Chunks {
    kind: CellKind,
    size: usize,
    firsts: Vec<CellKey>,
    count: u64,
}

impl Chunks {
    /// Creates a writer for chunks of cells that cast `rays` rays each and have skies of `side` x
    /// `side` texels.
    pub fn new(kind: CellKind, rays: usize, side: usize) -> Self {
        Chunks { kind, size: cells_per_chunk(rays, side * side), firsts: Vec::new(), count: 0 }
    }

    /// Creates a writer for chunks of the cells of an archive with these settings.
    pub fn with_settings(kind: CellKind, settings: &Settings) -> Self {
        let (rays, side) = match kind {
            CellKind::Probes => (settings.probe_hits, settings.probe),
            CellKind::Bounces => (settings.bounce_hits, settings.bounce_sky),
        };
        Chunks::new(kind, rays as usize, side as usize)
    }

    /// Returns the kind of the cells.
    pub fn kind(&self) -> CellKind {
        self.kind
    }

    /// Returns the number of cells of a full chunk.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Returns the number of cells to be given at a time: two chunks for every core.
    pub fn batch(&self) -> usize {
        self.size * rayon::current_num_threads() * 2
    }

    /// Returns the number of the next chunk.
    pub fn next(&self) -> TileNumber {
        TileNumber(self.firsts.len() as u32)
    }

    /// Encodes the blocks of a chunk.
    pub fn encode(&self, number: TileNumber, chunk: &Cells) -> Result<Vec<EncodedBlock>> {
        let mut blocks = vec![tables::CellsTable::new(chunk).encode(self.kind.chunks(), number, COMPRESSION)?];
        let [mirror, canopy] = self.kind.extras();
        let mirrors = chunk.mirrors.iter().enumerate().map(|(i, mirrors)| mirrors.to_bytes(chunk.bits_of(i).len()));
        blocks.extend(extra(mirror, number, mirrors.collect())?);
        blocks.extend(extra(canopy, number, chunk.canopies.iter().map(Canopy::to_bytes).collect())?);
        Ok(blocks)
    }

    /// Writes the next chunk. `blocks` is empty if the file already holds the chunk.
    pub fn add(&mut self, chunk: &Cells, blocks: Vec<EncodedBlock>, writer: &mut Writer) -> Result<()> {
        blocks.into_iter().try_for_each(|block| writer.append(block))?;
        self.firsts.extend(chunk.keys.first());
        self.count += chunk.keys.len() as u64;
        Ok(())
    }

    /// Writes the index, and returns the number of cells.
    pub fn finish(self, writer: &mut Writer) -> Result<u64> {
        if !self.firsts.is_empty() && !writer.has(format::INDEX, self.kind.index()) {
            writer.append(tables::IndexTable::new(&self.firsts).encode(
                format::INDEX,
                self.kind.index(),
                COMPRESSION,
            )?)?;
        }
        Ok(self.count)
    }
}
