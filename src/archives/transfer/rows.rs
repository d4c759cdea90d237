//! Rows of archives. In: an archive. Out: its receivers and its cells one after the other, in the
//! order that all archives share.

use std::cmp::Ordering;
use std::collections::VecDeque;

use rayon::prelude::*;

use heliotile_core::archive::format::{BlockKind, TileNumber};
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::layers::cells::Cell;
use heliotile_core::layers::extras::ReceiverExtras;
use heliotile_core::layers::response::Response;
use heliotile_core::layers::sky::SkyTexture;
use heliotile_core::layers::sky_bitmap::SkyBitmap;
use heliotile_core::opened::{CellSource, OpenSite};
use heliotile_core::site::cells::CellKey;
use heliotile_core::site::morton::morton_key;
use heliotile_core::site::patch::Patch;
use heliotile_core::site::receiver::Receiver;

/// Receiver with some of its layers.
pub struct LayeredReceiver<L> {
    /// Sort key of the receiver.
    pub key: Vec<u8>,
    /// Id, position and normal.
    pub receiver: Receiver,
    /// Shares of its hemisphere: sky, ground, obstruction.
    pub views: [f32; 3],
    /// Layers that were read with it: `()` for none.
    pub layers: L,
}

impl<L> LayeredReceiver<L> {
    /// Compares receivers in the order that all archives share.
    pub fn order(&self, other: &Self) -> Ordering {
        self.key.cmp(&other.key)
    }

    /// Returns the receiver with other layers.
    pub fn map<M>(self, layers: impl FnOnce(L) -> M) -> LayeredReceiver<M> {
        LayeredReceiver { key: self.key, receiver: self.receiver, views: self.views, layers: layers(self.layers) }
    }
}

/// Layers that can be read tile by tile.
pub trait Layers: Send + Sized {
    /// Returns the kinds of blocks that are read.
    fn kinds() -> Vec<BlockKind>;

    /// Returns one value for each of a tile's receivers.
    fn of_tile(site: &OpenSite, tile: u32, receivers: usize) -> Result<Vec<Self>>;
}

/// Layers of a receiver that a build traces before the cells.
pub struct TracedLayers {
    pub sky: SkyTexture,
    /// One key per texel of the hit texture; empty in an archive for replay only.
    pub hits: Vec<Option<CellKey>>,
    pub extras: ReceiverExtras,
}

impl TracedLayers {
    /// Returns the cells that the receiver sees, including those in mirrors and those of leaves.
    pub fn reached(&self) -> impl Iterator<Item = CellKey> + '_ {
        self.hits.iter().flatten().copied().chain(self.extras.mirrors.cells()).chain(self.extras.canopy.cells())
    }
}

/// Overview of a receiver; empty if the archive does not hold it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// Part of a surface that the receiver stands for.
    pub patch: Patch,
    /// Irradiation of a clear year, kWh/m2; `None` if the place is unknown.
    pub clear_year: Option<f32>,
}

impl Layers for Shown {
    fn kinds() -> Vec<BlockKind> {
        vec![format::OVERVIEW]
    }

    fn of_tile(site: &OpenSite, tile: u32, receivers: usize) -> Result<Vec<Self>> {
        let Some(overview) = site.tile_overview(tile, receivers)? else {
            return Ok(vec![Shown::default(); receivers]);
        };
        let row = |(i, patch)| Shown { patch, clear_year: overview.clear_year.get(i).copied() };
        Ok(overview.patches().into_iter().enumerate().map(row).collect())
    }
}

impl Layers for () {
    fn kinds() -> Vec<BlockKind> {
        Vec::new()
    }

    fn of_tile(_: &OpenSite, _: u32, receivers: usize) -> Result<Vec<Self>> {
        Ok(vec![(); receivers])
    }
}

impl Layers for SkyBitmap {
    fn kinds() -> Vec<BlockKind> {
        vec![format::SKY]
    }

    fn of_tile(site: &OpenSite, tile: u32, receivers: usize) -> Result<Vec<Self>> {
        site.tile_sky(tile, receivers)
    }
}

impl Layers for TracedLayers {
    fn kinds() -> Vec<BlockKind> {
        vec![format::SKY, format::HIT, format::MIRROR, format::CANOPY]
    }

    fn of_tile(site: &OpenSite, tile: u32, receivers: usize) -> Result<Vec<Self>> {
        let sky = site.tile_sky_textures(tile, receivers)?;
        let hits = match site.is_replay_only() {
            true => vec![Vec::new(); receivers],
            false => site.tile_hits(tile, receivers)?.split(receivers),
        };
        let layers = sky.into_iter().zip(hits).zip(site.tile_extras(tile, receivers)?);
        Ok(layers.map(|(((sky, _), hits), extras)| TracedLayers { sky, hits, extras }).collect())
    }
}

impl Layers for Response {
    fn kinds() -> Vec<BlockKind> {
        vec![format::RESPONSE]
    }

    fn of_tile(site: &OpenSite, tile: u32, receivers: usize) -> Result<Vec<Self>> {
        let responses = site.tile_responses(tile)?;
        if responses.len() != receivers {
            let block = site.block(format::RESPONSE, TileNumber(tile))?;
            return Err(block.corrupt(format!("{} responses", responses.len()), format!("{receivers}")));
        }
        Ok(responses)
    }
}

impl<A: Layers, B: Layers> Layers for (A, B) {
    fn kinds() -> Vec<BlockKind> {
        [A::kinds(), B::kinds()].concat()
    }

    fn of_tile(site: &OpenSite, tile: u32, receivers: usize) -> Result<Vec<Self>> {
        let (a, b) = (A::of_tile(site, tile, receivers)?, B::of_tile(site, tile, receivers)?);
        Ok(a.into_iter().zip(b).collect())
    }
}

/// Iterator over the receivers of an archive. A few tiles are in memory at a time.
pub struct ArchiveReceivers<'a, L> {
    site: OpenSite<'a>,
    /// Numbers of the tiles to read, and which of their receivers are wanted; `None` for all.
    tiles: std::vec::IntoIter<(u32, Option<&'a [bool]>)>,
    ready: VecDeque<LayeredReceiver<L>>,
    last: Vec<u8>,
    /// Number of remaining tiles at which the next tiles are announced for prefetching.
    told_from: usize,
}

/// Number of tiles between two announcements.
const AHEAD: usize = 64;

impl<'a, L: Layers> ArchiveReceivers<'a, L> {
    /// Returns all receivers of a site, in the archive's order.
    pub fn new(site: &OpenSite<'a>) -> Self {
        ArchiveReceivers::of_tiles(site, 0..site.tiles())
    }

    /// Returns the receivers of some tiles, whose numbers ascend.
    pub fn of_tiles(site: &OpenSite<'a>, tiles: impl IntoIterator<Item = u32>) -> Self {
        let tiles: Vec<_> = tiles.into_iter().map(|tile| (tile, None)).collect();
        ArchiveReceivers {
            site: site.clone(),
            tiles: tiles.into_iter(),
            ready: VecDeque::new(),
            last: Vec::new(),
            told_from: usize::MAX,
        }
    }

    /// Returns the receivers for which `kept` is true, in the archive's order. Tiles without any
    /// are not read.
    pub fn chosen(site: &OpenSite<'a>, archive: &Archive, kept: &'a [bool]) -> Self {
        let mut rest = kept;
        let mut tiles = Vec::new();
        for entry in archive.entries_of(format::RECEIVERS) {
            let (here, behind) = rest.split_at((entry.items as usize).min(rest.len()));
            rest = behind;
            if here.contains(&true) {
                tiles.push((entry.tile.0, Some(here)));
            }
        }
        ArchiveReceivers { tiles: tiles.into_iter(), ..ArchiveReceivers::new(site) }
    }

    /// Reads the next tiles.
    fn refill(&mut self) -> Result<()> {
        if self.tiles.len() <= self.told_from {
            self.told_from = self.tiles.len().saturating_sub(AHEAD);
            let mut kinds = [vec![format::RECEIVERS, format::PARTS], L::kinds()].concat();
            kinds.retain(|kind| !(self.site.is_replay_only() && format::REFLECTING.contains(kind)));
            self.site.expect(&kinds, self.tiles.as_slice().iter().take(2 * AHEAD).map(|(tile, _)| *tile));
        }
        let numbers: Vec<_> = self.tiles.by_ref().take(rayon::current_num_threads()).collect();
        let site = &self.site;
        let tiles: Vec<Vec<LayeredReceiver<L>>> =
            numbers.par_iter().map(|&(tile, _)| read_tile(site, tile)).collect::<Result<_>>()?;
        for ((number, kept), tile) in numbers.into_iter().zip(tiles) {
            let wanted = |row: usize| kept.is_none_or(|kept| kept.get(row) == Some(&true));
            for row in tile.into_iter().enumerate().filter(|(i, _)| wanted(*i)).map(|(_, row)| row) {
                if row.key <= self.last {
                    let block = self.site.block(format::RECEIVERS, TileNumber(number))?;
                    let got = format!("receiver {} after one that belongs behind it", row.receiver.id);
                    return Err(block.corrupt(got, "receivers along the Morton curve"));
                }
                self.last.clone_from(&row.key);
                self.ready.push_back(row);
            }
        }
        Ok(())
    }
}

/// Reads the receivers of one tile.
fn read_tile<L: Layers>(site: &OpenSite, tile: u32) -> Result<Vec<LayeredReceiver<L>>> {
    let table = site.tile_receivers(tile)?;
    let (layers, receivers) = (L::of_tile(site, tile, table.rows())?, site.tile_parts(tile, &table)?);
    if layers.len() != receivers.len() {
        let what = format!("{} rows of its layers for {} receivers", layers.len(), receivers.len());
        return Err(Error::defect(site.path(), format::block_name(format::RECEIVERS, TileNumber(tile)), "rows", what));
    }
    let rows = receivers.into_iter().zip(table.views()).zip(layers);
    Ok(rows
        .map(|((receiver, views), layers)| LayeredReceiver { key: morton_key(&receiver), receiver, views, layers })
        .collect())
}

impl<L: Layers> Iterator for ArchiveReceivers<'_, L> {
    type Item = Result<LayeredReceiver<L>>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ready.is_empty()
            && let Err(error) = self.refill()
        {
            return Some(Err(error));
        }
        self.ready.pop_front().map(Ok)
    }
}

/// Returns all cells of one kind, in order.
pub fn all_cells<'a>(source: &'a CellSource) -> impl Iterator<Item = Result<Cell>> + 'a {
    cells(source, (0..source.chunks()).collect(), |_, _| true)
}

/// Returns some cells of one kind, in order: those of `chunks` for which `keep` (chunk, row) is
/// true.
pub fn cells<'a>(
    source: &'a CellSource,
    chunks: Vec<usize>,
    keep: impl Fn(usize, usize) -> bool + Sync + 'a,
) -> impl Iterator<Item = Result<Cell>> + 'a {
    let step = rayon::current_num_threads();
    source.expect(chunks.iter().copied());
    (0..chunks.len()).step_by(step).flat_map(move |first| {
        let kept = |number: usize| -> Vec<Result<Cell>> {
            match source.chunk(number) {
                Ok(chunk) => {
                    (0..chunk.keys.len()).filter(|&row| keep(number, row)).map(|row| Ok(chunk.cell(row))).collect()
                }
                Err(error) => vec![Err(error)],
            }
        };
        let numbers = chunks.get(first..chunks.len().min(first + step)).unwrap_or_default();
        numbers.par_iter().copied().map(kept).collect::<Vec<_>>().into_iter().flatten()
    })
}
