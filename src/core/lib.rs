//! What an archive is and how it is replayed.
//!
//! It opens no file by itself but in [`archive::Archive::open`] and [`archive::verify()`]: bytes of archives come through
//! [`archive::ReadAt`], weather and conditions are parsed from bytes, and temporary storage is what the caller gives
//! ([`light::scratch`]). Features, both on by default: `zstd` packs and decodes blocks with the C library, otherwise `ruzstd` decodes them
//! and none can be packed; `mmap` reads archives of a file system through a mapping. Without them nothing here is C, and it compiles for
//! `wasm32-unknown-unknown`, where `rayon` works on the one thread there is (`tools/wasm`).

pub mod archive;
pub mod error;
pub mod hemisphere;
pub mod layers;
pub mod light;
pub mod memory;
pub mod opened;
pub mod replay;
pub mod site;
pub mod sky;
pub mod text;
pub mod units;
pub mod weather;
