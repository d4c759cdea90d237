//! Where blocks come from: an archive, or one that is still being written.

use std::path::Path;

use crate::archive::codec::block::Block;
use crate::archive::reader::Archive;
use crate::error::Result;

/// Checked blocks by (kind, tile), for many threads.
pub trait Blocks: Sync {
    /// The file, for messages.
    fn path(&self) -> &Path;
    /// Whether there is such a block.
    fn has(&self, kind: u32, tile: u32) -> bool;
    /// Number of rows of such a block, by the directory.
    fn rows(&self, kind: u32, tile: u32) -> Option<u32>;
    /// The block, checked and decoded.
    fn block(&self, kind: u32, tile: u32) -> Result<Block>;
    /// Tells of blocks that will be read soon; see [`Archive::expect`].
    fn expect(&self, _blocks: &[(u32, u32)]) {}
}

impl Blocks for Archive {
    fn path(&self) -> &Path {
        Archive::path(self)
    }

    fn has(&self, kind: u32, tile: u32) -> bool {
        Archive::has(self, kind, tile)
    }

    fn rows(&self, kind: u32, tile: u32) -> Option<u32> {
        self.entry(kind, tile).map(|entry| entry.items)
    }

    fn block(&self, kind: u32, tile: u32) -> Result<Block> {
        Archive::block(self, kind, tile)
    }

    fn expect(&self, blocks: &[(u32, u32)]) {
        Archive::expect(self, blocks.iter().copied());
    }
}
