//! Cells of a site, read chunk by chunk. In: a site that was opened. Out: cells that have the shape
//! of the settings, and whose materials and mirrors exist; errors for references to missing cells.

use rayon::prelude::*;

use crate::archive::format::{CellKind, TileNumber};
use crate::archive::{Block, format, tables};
use crate::error::{Error, Result};
use crate::layers::canopy::{Canopy, RayLists};
use crate::layers::cells::Cells;
use crate::layers::extras;
use crate::layers::mirror::CellMirrors;
use crate::opened::open_site::OpenSite;
use crate::site::cells::CellKey;

impl OpenSite<'_> {
    /// Returns the numbers of sky texels and of rays of a cell of a kind.
    fn rays_of(&self, kind: CellKind) -> [usize; 2] {
        let settings = self.settings();
        match kind {
            CellKind::Probes => [settings.probe * settings.probe, settings.probe_hits],
            CellKind::Bounces => [settings.bounce_sky * settings.bounce_sky, settings.bounce_hits],
        }
    }

    /// Returns the cells of a chunk with all their layers. [`CellSource::chunk`] checks that they
    /// belong between the chunks beside it.
    pub fn cells(&self, kind: CellKind, chunk: TileNumber) -> Result<Cells> {
        self.cells_in(kind, &self.block(kind.chunks(), chunk)?)
    }

    fn cells_in(&self, kind: CellKind, block: &Block) -> Result<Cells> {
        let mut cells = tables::CellsTable::from_block(block)?.into_cells();
        let (rows, [texels, rays]) = (cells.rows(), self.rays_of(kind));
        if cells.bits.len() != rows * texels.div_ceil(8) || cells.hits.len() != rows * rays {
            return Err(block.corrupt("malformed cells", "cells whose textures and rays match the manifest"));
        }
        self.check_materials(block, cells.keys.iter().chain(&cells.seen).map(|key| key.material))?;
        let [mirror, canopy] = kind.extras();
        let chunk = block.entry().tile;
        if self.has(mirror, chunk) {
            cells.mirrors = self.cell_mirrors(&self.block(mirror, chunk)?, rows, texels)?;
        }
        if self.has(canopy, chunk) {
            cells.canopies = self.cell_canopies(&self.block(canopy, chunk)?, rows, RayLists::of_cell(texels, rays))?;
        }
        Ok(cells)
    }

    /// Returns the light that `rows` cells, of `texels` sky texels each, see in mirrors.
    fn cell_mirrors(&self, block: &Block, rows: usize, texels: usize) -> Result<Vec<CellMirrors>> {
        let row = |row: &Vec<u8>| CellMirrors::from_bytes(row, texels.div_ceil(8));
        let found: Vec<CellMirrors> = extras::unpack(block.bytes(), rows)
            .and_then(|rows| rows.iter().map(row).collect())
            .ok_or_else(|| block.corrupt("malformed mirrors", format!("mirrors of {rows} cells")))?;
        for mirrors in &found {
            self.check_chains(block, mirrors.windows.iter().map(|window| window.chain))?;
            self.check_steps(block, mirrors.paths.iter().map(|path| path.steps.as_slice()))?;
            self.check_materials(block, mirrors.cells().map(|key| key.material))?;
            let mut seen = mirrors.windows.iter().flat_map(|window| &window.texels);
            if let Some(texel) = seen.find(|texel| usize::from(**texel) >= texels) {
                return Err(block.corrupt(format!("texel {texel}"), format!("a texel below {texels}")));
            }
        }
        Ok(found)
    }

    /// Returns the canopies that the rays of `rows` cells cross.
    fn cell_canopies(&self, block: &Block, rows: usize, rays: RayLists) -> Result<Vec<Canopy>> {
        let row = |row: &Vec<u8>| Canopy::from_bytes(row, rays, |material| self.is_canopy(material));
        let found = extras::unpack(block.bytes(), rows).and_then(|rows| rows.iter().map(row).collect());
        let expected = "crossings of canopies that match the textures and rays of the settings";
        found.ok_or_else(|| block.corrupt("malformed crossings of canopies", expected))
    }
}

/// Cells of one kind, found by the index of their chunks.
#[derive(Clone)]
pub struct CellSource<'a> {
    site: OpenSite<'a>,
    kind: CellKind,
    /// First key of every chunk.
    firsts: Vec<CellKey>,
}

impl<'a> CellSource<'a> {
    /// Returns the probes of a site.
    pub fn probes(site: &OpenSite<'a>) -> Result<Self> {
        CellSource::open(site, CellKind::Probes)
    }

    /// Returns the bounce cells of a site.
    pub fn bounces(site: &OpenSite<'a>) -> Result<Self> {
        CellSource::open(site, CellKind::Bounces)
    }

    fn open(site: &OpenSite<'a>, kind: CellKind) -> Result<Self> {
        let index = kind.index();
        // A site where no ray meets anything has no cells and no index. For an archive that is for
        // replay only, reading the index gives the error.
        let firsts = match site.has(format::INDEX, index) || site.is_replay_only() {
            true => tables::IndexTable::from_block(&site.block(format::INDEX, index)?)?.firsts(),
            false => Vec::new(),
        };
        Ok(CellSource { site: site.clone(), kind, firsts })
    }

    /// Returns the number of chunks.
    pub fn chunks(&self) -> usize {
        self.firsts.len()
    }

    /// Returns the first key of every chunk.
    pub fn firsts(&self) -> &[CellKey] {
        &self.firsts
    }

    /// Returns the only chunk that can hold a cell.
    pub fn chunk_of(&self, key: &CellKey) -> Option<usize> {
        self.firsts.partition_point(|first| first <= key).checked_sub(1)
    }

    /// Announces chunks that will be read soon, with all their layers.
    pub fn expect(&self, chunks: impl IntoIterator<Item = usize>) {
        let [mirror, canopy] = self.kind.extras();
        self.site.expect(&[self.kind.chunks(), mirror, canopy], chunks.into_iter().map(|chunk| chunk as u32));
    }

    /// Returns all cells of a chunk.
    pub fn chunk(&self, chunk: usize) -> Result<Cells> {
        let block = self.site.block(self.kind.chunks(), TileNumber(chunk as u32))?;
        let cells = self.site.cells_in(self.kind, &block)?;
        if cells.keys.first() != self.firsts.get(chunk) {
            return Err(
                block.corrupt("a first cell that differs from the index", "the first cell that the index states")
            );
        }
        if cells.keys.last().zip(self.firsts.get(chunk + 1)).is_some_and(|(last, next)| last >= next) {
            return Err(
                block.corrupt("keys beyond the first key of the next chunk", "keys that rise from chunk to chunk")
            );
        }
        Ok(cells)
    }

    /// Returns the cells of these keys, which must be sorted. A key without a cell is an error, in
    /// which `referring` names the block that refers to it.
    pub fn fetch(&self, keys: &[CellKey], referring: impl Fn(&CellKey) -> String + Sync) -> Result<Cells> {
        let parts: Vec<&[CellKey]> = keys.chunk_by(|a, b| self.chunk_of(a) == self.chunk_of(b)).collect();
        let missing = |key: &CellKey| self.missing(key, referring(key));
        self.expect(parts.iter().filter_map(|part| self.chunk_of(part.first()?)));
        let found: Vec<Cells> = parts
            .into_par_iter()
            .map(|part| {
                let cells = self.chunk(self.chunk_of(&part[0]).ok_or_else(|| missing(&part[0]))?)?;
                let row = |key: &CellKey| cells.keys.binary_search(key).map_err(|_| missing(key));
                Ok(cells.select(&part.iter().map(row).collect::<Result<Vec<usize>>>()?))
            })
            .collect::<Result<_>>()?;
        Ok(Cells::join(&found))
    }

    /// Returns the name of the block that holds a cell.
    pub fn block_of(&self, key: &CellKey) -> String {
        self.chunk_of(key).map_or_else(
            || format::kind_name(self.kind.chunks()),
            |chunk| format::block_name(self.kind.chunks(), TileNumber(chunk as u32)),
        )
    }

    /// Returns the name of the block of a cell, among some cells of this source, that sees another
    /// cell.
    pub fn observer_of(&self, cells: &Cells, seen: &CellKey) -> String {
        cells.observer_of(seen).map_or_else(|| format::kind_name(self.kind.chunks()), |key| self.block_of(&key))
    }

    /// Returns the error of a reference from a block to a cell that does not exist.
    pub fn missing(&self, key: &CellKey, referring: impl Into<String>) -> Error {
        let what = format!("names {key:?}, which block {} does not hold", self.block_of(key));
        Error::defect(self.site.path(), referring, "cells that are seen", what)
    }

    /// Returns the error of cells of this source that do not fit together.
    pub fn defect(&self, key: &CellKey, field: &'static str, what: impl Into<String>) -> Error {
        Error::defect(self.site.path(), self.block_of(key), field, what)
    }
}
