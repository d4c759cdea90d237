//! From stored to raw bytes and back. In: bytes of a block and its directory entry. Out: the other ones, checked. Decoding is in C (`zstd`) or in
//! Rust (`ruzstd`), with the same result; packing is in C only.

pub mod block;
mod frame;
#[cfg(feature = "zstd")]
pub mod pack;
mod unpack;
