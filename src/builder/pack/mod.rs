//! From tables and textures to blocks, cut and compressed in one way. In: receivers of a tile, sorted cells. Out: the blocks of
//! an archive. The build packs what it traced and the transfer commands what they read, so equal contents give equal bytes.

mod chunks;
mod name_index;
mod overview;
mod tile;

pub(crate) use chunks::Chunks;
pub(crate) use name_index::NameIndexWriter;
pub use overview::{OverviewRow, overview};
use tile::extra;
pub(crate) use tile::{hits, responses, tile};

/// Level of the block compressor: textures are written once and read for years.
pub const COMPRESSION: i32 = heliotile_core::archive::codec::pack::DEFAULT_LEVEL;
