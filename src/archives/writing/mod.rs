//! Writing of archives. In: encoded blocks and a manifest. Out: a finished file, complete or
//! absent; an interrupted build can be resumed.

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

pub(crate) mod disk;
pub(crate) mod journal;
pub(crate) mod writer;

#[cfg(test)]
mod damage_tests;
#[cfg(test)]
mod fault_tests;
#[cfg(test)]
mod memory_disk;
#[cfg(test)]
mod power_tests;
#[cfg(test)]
mod reader_tests;
#[cfg(test)]
mod republish_tests;
#[cfg(test)]
mod resume_tests;
#[cfg(test)]
mod schema_tests;
#[cfg(test)]
mod test_site;
#[cfg(test)]
mod verify_tests;

pub use journal::{Job, Progress};
pub use writer::{Summary, Writer};
