//! Where blocks come from: an archive, or one that is still being written.

use std::path::Path;

use super::codec::Block;
use super::reader::Archive;
use super::writer::Writer;
use crate::error::Result;

/// Checked blocks by (kind, tile), for many threads.
pub trait Blocks: Sync {
    /// The file, for messages.
    fn path(&self) -> &Path;
    /// Whether there is such a block.
    fn has(&self, kind: u32, tile: u32) -> bool;
    /// The block, checked and decoded.
    fn block(&self, kind: u32, tile: u32) -> Result<Block>;
}

impl Blocks for Archive {
    fn path(&self) -> &Path {
        Archive::path(self)
    }

    fn has(&self, kind: u32, tile: u32) -> bool {
        Archive::has(self, kind, tile)
    }

    fn block(&self, kind: u32, tile: u32) -> Result<Block> {
        Archive::block(self, kind, tile)
    }
}

impl Blocks for Writer {
    fn path(&self) -> &Path {
        Writer::partial(self)
    }

    fn has(&self, kind: u32, tile: u32) -> bool {
        Writer::has(self, kind, tile)
    }

    fn block(&self, kind: u32, tile: u32) -> Result<Block> {
        self.read_back(kind, tile)
    }
}
