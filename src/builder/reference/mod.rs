//! Reference path tracer: the irradiance of a receiver, by tracing light paths one by one. In: a
//! prepared scene, a receiver, suns and skies. Out: its six components, each with a standard error.
//! It is unbiased and slow, and shares only the ray kernel with the builder: no textures, cells,
//! patches or probes.
//!
//! Paths start at the receiver, cosine-weighted, and go on until they see sky or end by Russian
//! roulette (Kajiya 1986, "The rendering equation"). Where they hit a matt surface, points of the
//! sun's disc are sampled, directly and by chains of mirrors. The first numbers of each path come
//! from a low-discrepancy sequence, shifted at random for each of [`BATCHES`] batches (Cranley and
//! Patterson 1976), whose spread gives the standard error.

mod audit;
mod carried;
pub mod comparison;
mod estimate;
pub mod groups;
pub mod hours;
mod random;
mod sky;
mod sun;
mod tracer;
mod walk;

pub use audit::{AuditInputs, Audited, audit, reference_pairs};
pub use estimate::{BATCHES, PARTS, ReferenceLight};
pub use random::spread;
pub use sky::ReferenceSky;
pub use tracer::PathTracer;

#[cfg(test)]
mod tests;
