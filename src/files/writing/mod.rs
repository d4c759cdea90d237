//! Outputs of a run. In: paths. Out: claims, which keep other runs and inputs away, and files that
//! appear under their names when they are whole.

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

pub mod claim;
pub mod copy;
pub mod file_lock;
pub mod guards;
pub mod regular;
pub mod whole_file;
