//! Layers of the receivers of a tile. In: a site that was opened. Out: the layers of one tile, one
//! value a receiver, whose materials and mirrors exist.

use crate::archive::format::TileNumber;
use crate::archive::{Block, format, tables};
use crate::error::{Error, Result};
use crate::layers::bits::BitSquare;
use crate::layers::canopy::Canopy;
use crate::layers::extras::{self, ReceiverExtras};
use crate::layers::hit::HitTile;
use crate::layers::mirror::ReceiverMirrors;
use crate::layers::response::{self, Response};
use crate::layers::sky::SkyTexture;
use crate::layers::sky_bitmap::SkyBitmap;
use crate::opened::open_site::OpenSite;
use crate::site::chain::{Chain, MirrorStep};
use crate::site::receiver::Receiver;

/// Limit on the bytes of a tile's refined sky. A small block can stand for large textures.
pub const MAX_SKY: usize = 256 << 20;

impl OpenSite<'_> {
    /// Reads the table of receivers of a tile.
    pub fn tile_receivers(&self, tile: u32) -> Result<tables::ReceiversTable> {
        tables::ReceiversTable::from_block(&self.block(format::RECEIVERS, TileNumber(tile))?)
    }

    /// Returns the receivers of a tile's table one by one, with their parts of the model.
    pub fn tile_parts(&self, tile: u32, table: &tables::ReceiversTable) -> Result<Vec<Receiver>> {
        let mut receivers = table.receivers();
        tables::PartsTable::join(self.blocks(), tile, &mut receivers)?;
        Ok(receivers)
    }

    /// Reads the table by which a tile of `rows` receivers is drawn; `None` where the archive does
    /// not have it.
    pub fn tile_overview(&self, tile: u32, rows: usize) -> Result<Option<tables::OverviewTable>> {
        tables::OverviewTable::of_tile(self.blocks(), tile, rows)
    }

    /// Reads the sky textures of a tile of `rows` receivers, ready for look-ups.
    pub fn tile_sky(&self, tile: u32, rows: usize) -> Result<Vec<SkyBitmap>> {
        let (block, settings) = (self.sky_block(tile, rows)?, self.settings());
        SkyBitmap::unpack(block.bytes(), rows, settings.sky_base, settings.sky_fine).ok_or_else(|| other_sky(&block))
    }

    /// Reads the sky textures of a tile of `rows` receivers as they are stored, each with the bits
    /// that it describes.
    pub fn tile_sky_textures(&self, tile: u32, rows: usize) -> Result<Vec<(SkyTexture, BitSquare)>> {
        let (block, settings) = (self.sky_block(tile, rows)?, self.settings());
        SkyTexture::split(block.bytes(), rows, settings.sky_base, settings.sky_fine).ok_or_else(|| other_sky(&block))
    }

    /// Reads the sky block of a tile of `rows` receivers; refuses one that decodes to more than
    /// [`MAX_SKY`].
    fn sky_block(&self, tile: u32, rows: usize) -> Result<Block> {
        let (block, fine) = (self.block(format::SKY, TileNumber(tile))?, self.settings().sky_fine);
        let bytes = rows.saturating_mul(fine * fine / 8);
        if bytes > MAX_SKY {
            return Err(block.corrupt(format!("sky of {bytes} bytes"), format!("at most {MAX_SKY}")));
        }
        Ok(block)
    }

    /// Reads the hits of a tile of `rows` receivers.
    pub fn tile_hits(&self, tile: u32, rows: usize) -> Result<HitTile> {
        let (block, side) = (self.block(format::HIT, TileNumber(tile))?, self.settings().hit);
        let hits = HitTile::unpack(block.bytes(), rows.saturating_mul(side * side))
            .ok_or_else(|| block.corrupt("malformed hits", "hits that match the texture size of the settings"))?;
        self.check_materials(&block, hits.palette.iter().map(|key| key.material))?;
        Ok(hits)
    }

    /// Reads the light that `rows` receivers of a tile see in mirrors; empty where the tile has no
    /// such layer.
    pub fn tile_mirrors(&self, tile: u32, rows: usize) -> Result<Vec<ReceiverMirrors>> {
        if !self.has(format::MIRROR, TileNumber(tile)) {
            return Ok(Vec::new());
        }
        let (block, settings) = (self.block(format::MIRROR, TileNumber(tile))?, self.settings());
        let row = |row: &Vec<u8>| ReceiverMirrors::from_bytes(row, settings.sky_base, settings.hit);
        let found: Vec<ReceiverMirrors> = extras::unpack(block.bytes(), rows)
            .and_then(|rows| rows.iter().map(row).collect())
            .ok_or_else(|| block.corrupt("malformed mirrors", format!("mirrors of {rows} receivers")))?;
        for mirrors in &found {
            self.check_chains(&block, mirrors.windows.iter().map(|window| window.chain))?;
            self.check_steps(&block, mirrors.paths.iter().map(|path| path.steps.as_slice()))?;
            self.check_materials(&block, mirrors.cells().map(|key| key.material))?;
        }
        Ok(found)
    }

    /// Reads the canopies that the rays of a tile's receivers cross; empty where the tile has no
    /// such layer.
    pub fn tile_canopies(&self, tile: u32, rows: usize) -> Result<Vec<Canopy>> {
        if !self.has(format::CANOPY, TileNumber(tile)) {
            return Ok(Vec::new());
        }
        let (block, rays) = (self.block(format::CANOPY, TileNumber(tile))?, self.settings().receiver_rays());
        let row = |bytes: &Vec<u8>| Canopy::from_bytes(bytes, rays, |material| self.is_canopy(material));
        let found = extras::unpack(block.bytes(), rows).and_then(|bytes| bytes.iter().map(row).collect());
        found.ok_or_else(|| {
            block.corrupt(
                "malformed crossings of canopies",
                "crossings of canopies that match the textures of the settings",
            )
        })
    }

    /// Reads mirrors and canopies, one value of each for every receiver.
    pub fn tile_extras(&self, tile: u32, rows: usize) -> Result<Vec<ReceiverExtras>> {
        let (mut mirrors, mut canopies) = (self.tile_mirrors(tile, rows)?, self.tile_canopies(tile, rows)?);
        // A missing layer is empty for every receiver.
        mirrors.resize_with(rows, ReceiverMirrors::default);
        canopies.resize_with(rows, Canopy::default);
        Ok(mirrors.into_iter().zip(canopies).map(|(mirrors, canopy)| ReceiverExtras { mirrors, canopy }).collect())
    }

    /// Reads the responses that the build derived: for its own reflectances and all bounces.
    pub fn tile_responses(&self, tile: u32) -> Result<Vec<Response>> {
        let block = self.block(format::RESPONSE, TileNumber(tile))?;
        response::unpack(block.bytes(), block.items() as usize, self.settings().probe).ok_or_else(|| {
            block.corrupt("malformed responses", "responses that match the texture size of the manifest")
        })
    }

    /// Refuses a block that names a missing material.
    pub(super) fn check_materials(&self, block: &Block, mut materials: impl Iterator<Item = u16>) -> Result<()> {
        match materials.find(|&material| !self.has_material(material)) {
            Some(material) => Err(block.corrupt(format!("material {material}"), "a row of the materials table")),
            None => Ok(()),
        }
    }

    /// Refuses a block with chains of missing mirrors.
    pub(super) fn check_chains(&self, block: &Block, mut chains: impl Iterator<Item = Chain>) -> Result<()> {
        let count = self.orientations().len();
        let unknown = |number: &u16| usize::from(*number) >= count;
        match chains.find_map(|chain| chain.numbers().find(unknown)) {
            Some(number) => Err(block.corrupt(format!("mirror {number}"), format!("a mirror below {count}"))),
            None => Ok(()),
        }
    }

    /// Refuses a block with paths by mirrors of missing materials.
    pub(super) fn check_steps<'s>(&self, block: &Block, steps: impl Iterator<Item = &'s [MirrorStep]>) -> Result<()> {
        self.check_materials(block, steps.flatten().map(|step| step.0))
    }
}

fn other_sky(block: &Block) -> Error {
    block.corrupt("malformed sky bits", "sky bits that match the texture size of the manifest")
}
