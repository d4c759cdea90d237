//! The archive: one file that holds a traced site. In: encoded blocks and a manifest. Out: the same
//! blocks, checked, by (kind, tile).
//!
//! It promises four things. A file is whole or does not have its name. A changed byte is an error
//! that names the block, never other numbers. No input ends the program. Equal input gives equal
//! bytes. It never casts a ray and knows no physics. `schema/heliotile-1.md` defines the bytes and
//! comes first: tests compare it with this code.

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
