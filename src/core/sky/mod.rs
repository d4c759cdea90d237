//! Radiance of the sky. In: a condition and a sky model. Out: radiances of patches and texels,
//! W/(m2 sr). Never: obstructions, receivers, files.

pub mod disc;
pub mod distribution;
pub mod efficacy;
pub mod horizon;
pub mod model;
pub mod own_skies;
pub mod patches;
pub mod perez;
pub mod perez1990;
pub mod projection;
pub(crate) mod skies;
pub(crate) mod sky_field;
