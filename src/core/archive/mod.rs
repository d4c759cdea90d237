//! The archive: one file that holds a traced site. In: encoded blocks and a manifest. Out: the same blocks, checked, by
//! (kind, tile).
//!
//! What it promises: a file is whole or has not got its name; a changed byte is an error that names the block, never other
//! numbers; no input ends the program; equal input gives equal bytes. It never casts a ray and knows no physics. The bytes
//! are told in `schema/heliotile-1.md`, which comes first: tests compare it with this code.

#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::arithmetic_side_effects,
    clippy::cast_possible_truncation
)]
#![cfg_attr(
    test,
    allow(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::arithmetic_side_effects,
        clippy::cast_possible_truncation
    )
)]

pub mod accuracy;
mod blocks;
pub mod codec;
pub mod format;
mod header;
pub mod manifest;
#[cfg(all(feature = "mmap", any(unix, windows)))]
mod mapping;
pub mod negligible;
pub mod pointer;
pub mod preview;
pub mod read_at;
pub mod reader;
pub mod record;
pub mod settings;
mod source;
pub mod tables;
pub mod verify;

pub use blocks::Blocks;
pub use codec::block::{Block, EncodedBlock};
#[cfg(feature = "zstd")]
pub use codec::pack::encode;
pub use header::Header;
pub use manifest::Manifest;
pub use read_at::ReadAt;
pub use reader::Archive;
pub use source::Access;
#[cfg(any(unix, windows))]
pub use verify::verify;
pub use verify::{Problem, VerifyReport, verify_bytes};
