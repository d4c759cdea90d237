//! Packing of tables and textures into compressed blocks. In: receivers of a tile, sorted cells.
//! Out: the blocks of an archive. Builds and transfer commands use the same code, so equal contents
//! give equal bytes.

mod chunks;
mod name_index;
mod overview;
mod tile;

pub use chunks::Chunks;
pub use name_index::NameIndexWriter;
pub use overview::{OverviewRow, overview};
pub use tile::{COMPRESSION, hits, responses, tile};
