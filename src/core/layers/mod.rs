//! Layers: the data that the archive keeps of a hemisphere, packed and unpacked. In: bits, keys and
//! vectors of receivers and probes. Out: the raw bytes of a tile's blocks, and back. This module
//! casts no rays and knows no weather. Shapes and conventions: `schema/layers.md`.

pub mod bits;
pub mod canopy;
pub mod cells;
pub mod extras;
pub mod hit;
pub mod mirror;
pub mod rans;
mod refinement_decoder;
pub mod response;
pub mod sides;
pub mod sky;
pub mod sky_bitmap;
pub mod texel_block;
