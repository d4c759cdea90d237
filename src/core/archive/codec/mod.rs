//! Conversion from stored to raw bytes and back. In: bytes of a block and its directory entry. Out:
//! the raw or stored bytes, checked. Decoding is in C (`zstd`) or in Rust (`ruzstd`), with equal
//! results; packing is in C only.

pub mod block;
mod frame;
#[cfg(feature = "zstd")]
pub mod pack;
mod unpack;
