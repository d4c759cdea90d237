//! Receivers of an archive one after the other, in the order that all archives share, and its cells likewise.

use std::cmp::Ordering;
use std::collections::VecDeque;

use rayon::prelude::*;

use heliotile_core::archive::manifest::Settings;
use heliotile_core::archive::{Archive, format, tables};
use heliotile_core::error::{Error, Result};
use heliotile_core::layers::cells::Cell;
use heliotile_core::layers::extras::{Extras, MIRROR};
use heliotile_core::layers::mirror::ReceiverMirrors;
use heliotile_core::layers::response::Response;
use heliotile_core::layers::sky::SkyTexture;
use heliotile_core::light::load::{CellSource, cached_responses, hits_of, settings, tile_extras, tile_sky};
use heliotile_core::site::cells::CellKey;
use heliotile_core::site::morton::morton_key;
use heliotile_core::site::receiver::Receiver;

/// A receiver with some of its layers.
pub struct Row<L> {
    /// Sorts as receivers do.
    pub key: Vec<u8>,
    pub receiver: Receiver,
    /// Shares of its hemisphere: sky, ground, obstruction.
    pub views: [f32; 3],
    pub layers: L,
}

impl<L> Row<L> {
    pub fn order(&self, other: &Self) -> Ordering {
        self.key.cmp(&other.key)
    }

    /// The same receiver with other layers.
    pub fn map<M>(self, layers: impl FnOnce(L) -> M) -> Row<M> {
        Row { key: self.key, receiver: self.receiver, views: self.views, layers: layers(self.layers) }
    }
}

/// Layers that can be read a tile at a time.
pub trait Layers: Send + Sized {
    /// One value for each of a tile's receivers.
    fn of_tile(archive: &Archive, tile: u32, receivers: usize) -> Result<Vec<Self>>;
}

/// What the build knows of a receiver before it knows the cells.
pub struct Traced {
    pub sky: SkyTexture,
    /// One key a texel of the hit texture.
    pub hits: Vec<Option<CellKey>>,
    pub extras: Extras,
}

impl Traced {
    /// The cells that the receiver sees, some of them in mirrors.
    pub fn reached(&self, settings: &Settings) -> impl Iterator<Item = CellKey> + '_ {
        let (base, hit) = (settings.sky_base as usize, settings.hit as usize);
        let mirrors = ReceiverMirrors::from_bytes(&self.extras[MIRROR], base, hit).unwrap_or_default();
        self.hits.iter().flatten().copied().chain(mirrors.paths.into_iter().map(|path| path.cell))
    }
}

impl Layers for () {
    fn of_tile(_: &Archive, _: u32, receivers: usize) -> Result<Vec<Self>> {
        Ok(vec![(); receivers])
    }
}

impl Layers for Traced {
    fn of_tile(archive: &Archive, tile: u32, receivers: usize) -> Result<Vec<Self>> {
        let sky = tile_sky(archive, tile, receivers)?;
        let hits = hits_of(&archive.block(format::HIT, tile)?, receivers, settings(archive)?.hit as usize)?;
        let layers = sky.into_iter().zip(hits.split(receivers)).zip(tile_extras(archive, tile, receivers)?);
        Ok(layers.map(|(((sky, _), hits), extras)| Traced { sky, hits, extras }).collect())
    }
}

impl Layers for Response {
    fn of_tile(archive: &Archive, tile: u32, receivers: usize) -> Result<Vec<Self>> {
        let block = archive.block(format::RESPONSE, tile)?;
        if block.items() as usize != receivers {
            return Err(block.corrupt(format!("{} responses", block.items()), format!("{receivers}")));
        }
        cached_responses(archive, tile)
    }
}

impl<A: Layers, B: Layers> Layers for (A, B) {
    fn of_tile(archive: &Archive, tile: u32, receivers: usize) -> Result<Vec<Self>> {
        let (a, b) = (A::of_tile(archive, tile, receivers)?, B::of_tile(archive, tile, receivers)?);
        Ok(a.into_iter().zip(b).collect())
    }
}

/// Receivers of an archive; a few tiles are in memory at a time.
pub struct Rows<'a, L> {
    archive: &'a Archive,
    /// Numbers of the tiles to read, and which of their receivers are wanted: all, without a choice.
    tiles: std::vec::IntoIter<(u32, Option<&'a [bool]>)>,
    ready: VecDeque<Row<L>>,
    last: Vec<u8>,
}

impl<'a, L: Layers> Rows<'a, L> {
    pub fn new(archive: &'a Archive) -> Self {
        let tiles: Vec<_> = (0..archive.tiles()).map(|tile| (tile, None)).collect();
        Rows { archive, tiles: tiles.into_iter(), ready: VecDeque::new(), last: Vec::new() }
    }

    /// Those receivers for which `kept` is true, in the archive's order; tiles without any are not read.
    pub fn chosen(archive: &'a Archive, kept: &'a [bool]) -> Self {
        let mut rest = kept;
        let mut tiles = Vec::new();
        for entry in archive.entries_of(format::RECEIVERS) {
            let (here, behind) = rest.split_at((entry.items as usize).min(rest.len()));
            rest = behind;
            if here.contains(&true) {
                tiles.push((entry.tile, Some(here)));
            }
        }
        Rows { tiles: tiles.into_iter(), ..Rows::new(archive) }
    }

    /// Reads the next tiles.
    fn refill(&mut self) -> Result<()> {
        let numbers: Vec<_> = self.tiles.by_ref().take(rayon::current_num_threads()).collect();
        let archive = self.archive;
        let tiles: Vec<Vec<Row<L>>> =
            numbers.par_iter().map(|&(tile, _)| read_tile(archive, tile)).collect::<Result<_>>()?;
        for ((number, kept), tile) in numbers.into_iter().zip(tiles) {
            let wanted = |row: usize| kept.is_none_or(|kept| kept.get(row) == Some(&true));
            for row in tile.into_iter().enumerate().filter(|(i, _)| wanted(*i)).map(|(_, row)| row) {
                if row.key <= self.last {
                    let block = self.archive.block(format::RECEIVERS, number)?;
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

/// Refuses an archive of format 1.0: its cells and the order of its receivers are those of its own scene's origin.
fn check_format(archive: &Archive) -> Result<()> {
    if !archive.entries_of(format::MATERIALS).iter().any(format::is_older) {
        return Ok(());
    }
    let what = "is of format 1.0, whose cells and order of receivers hang on the middle of its scene";
    let hint = "query, replay, export, info and verify read it as ever; to cut, merge or compare it, build it again";
    Err(Error::input(archive.path(), None, what, hint))
}

/// The receivers of one tile.
fn read_tile<L: Layers>(archive: &Archive, tile: u32) -> Result<Vec<Row<L>>> {
    check_format(archive)?;
    let table = tables::Receivers::from_block(&archive.block(format::RECEIVERS, tile)?)?;
    let layers = L::of_tile(archive, tile, table.rows())?;
    let rows = table.receivers().into_iter().zip(table.views()).zip(layers);
    Ok(rows.map(|((receiver, views), layers)| Row { key: morton_key(&receiver), receiver, views, layers }).collect())
}

impl<L: Layers> Iterator for Rows<'_, L> {
    type Item = Result<Row<L>>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ready.is_empty()
            && let Err(error) = self.refill()
        {
            return Some(Err(error));
        }
        self.ready.pop_front().map(Ok)
    }
}

/// Some cells of one kind, in order: those for which `keep` (chunk, row) holds.
pub fn cells<'a>(
    source: &'a CellSource,
    keep: impl Fn(usize, usize) -> bool + Sync + 'a,
) -> impl Iterator<Item = Result<Cell>> + 'a {
    let step = rayon::current_num_threads();
    (0..source.chunks()).step_by(step).flat_map(move |first| {
        let kept = |number: usize| -> Vec<Result<Cell>> {
            match source.chunk(number) {
                Ok(chunk) => {
                    (0..chunk.keys.len()).filter(|&row| keep(number, row)).map(|row| Ok(chunk.cell(row))).collect()
                }
                Err(error) => vec![Err(error)],
            }
        };
        let numbers = first..source.chunks().min(first + step);
        numbers.into_par_iter().map(kept).collect::<Vec<_>>().into_iter().flatten()
    })
}
