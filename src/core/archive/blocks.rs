//! Source of blocks: an archive, or one that is still being written.

use std::path::Path;

use crate::archive::codec::block::Block;
use crate::archive::format::{BlockKind, TileNumber};
use crate::archive::reader::Archive;
use crate::error::Result;

/// Source of checked blocks by (kind, tile), for many threads.
pub trait Blocks: Sync {
    /// Returns the file, for messages.
    fn path(&self) -> &Path;
    /// Returns true if there is such a block.
    fn has(&self, kind: BlockKind, tile: TileNumber) -> bool;
    /// Returns the number of rows of such a block, by the directory.
    fn rows(&self, kind: BlockKind, tile: TileNumber) -> Option<u32>;
    /// Returns the block, checked and decoded.
    fn block(&self, kind: BlockKind, tile: TileNumber) -> Result<Block>;
    /// Announces blocks that will be read soon; see [`Archive::expect`].
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
