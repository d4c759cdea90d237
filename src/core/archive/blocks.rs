//! Where blocks come from: an archive, or one that is still being written.

use std::path::Path;

use crate::archive::codec::block::Block;
use crate::archive::format::{BlockKind, TileNumber};
use crate::archive::reader::Archive;
use crate::error::Result;

/// Checked blocks by (kind, tile), for many threads.
pub trait Blocks: Sync {
    /// The file, for messages.
    fn path(&self) -> &Path;
    /// Whether there is such a block.
    fn has(&self, kind: BlockKind, tile: TileNumber) -> bool;
    /// Number of rows of such a block, by the directory.
    fn rows(&self, kind: BlockKind, tile: TileNumber) -> Option<u32>;
    /// The block, checked and decoded.
    fn block(&self, kind: BlockKind, tile: TileNumber) -> Result<Block>;
    /// Tells of blocks that will be read soon; see [`Archive::expect`].
    fn expect(&self, _blocks: &[(BlockKind, TileNumber)]) {}
}

impl Blocks for Archive {
    fn path(&self) -> &Path {
        Archive::path(self)
    }

    fn has(&self, kind: BlockKind, tile: TileNumber) -> bool {
        Archive::has(self, kind, tile)
    }

    fn rows(&self, kind: BlockKind, tile: TileNumber) -> Option<u32> {
        self.entry(kind, tile).map(|entry| entry.items)
    }

    fn block(&self, kind: BlockKind, tile: TileNumber) -> Result<Block> {
        Archive::block(self, kind, tile)
    }

    fn expect(&self, blocks: &[(BlockKind, TileNumber)]) {
        Archive::expect(self, blocks.iter().copied());
    }
}
