//! Packing of tables and textures into compressed blocks. In: receivers of a tile, sorted cells.
//! Out: the blocks of an archive. Builds and transfer commands use the same code, so equal contents
//! give equal bytes.

mod chunks;
mod name_index;
mod tile;

pub use chunks::Chunks;
pub use name_index::NameIndexWriter;
pub use tile::{COMPRESSION, hits, responses, tile};
pub use tile::{OverviewRow, overview};
