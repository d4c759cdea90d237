//! The judge: what a receiver gets, by tracing the paths of light one by one. In: a prepared scene, a receiver, suns and skies. Out: its six
//! components, each with a standard error. Unbiased, slow, and of one mind with the builder in nothing but what a ray meets: no textures, cells,
//! patches or probes.
//!
//! Paths start at the receiver, cosine-distributed, and go on until they see sky or die by chance (Kajiya 1986, "The rendering
//! equation"). Where they meet a matt surface the sun's disc is asked for, straight and by chains of mirrors. The first numbers of each path
//! come from a low-discrepancy sequence, shifted at random for each of [`BATCHES`] batches (Cranley and Patterson 1976), whose spread gives the
//! standard error.

mod audit;
mod carried;
pub mod comparison;
mod estimate;
pub mod groups;
pub mod hours;
mod random;
mod sky;
mod sun;
mod walk;

pub use audit::{AuditInputs, Audited, audit, judge_pairs, spread};
pub use estimate::{BATCHES, Judged, PARTS};
pub use sky::JudgedSky;
pub use walk::Judge;

#[cfg(test)]
mod tests;
