//! Replay: layers of an archive and the weather of an hour become irradiance. In: an archive,
//! conditions, the choice of a sky. Out: six components and their total for every receiver and
//! condition, and longwave irradiance on request. A replay never casts a ray: the crate has no code
//! that could.

pub mod bands;
pub mod by_object;
pub mod components;
mod direct;
pub mod factors;
pub mod interactive;
mod longwave;
pub mod maps;
pub mod receiver_view;
pub mod reflectances;
mod response_sums;
pub mod run;
pub mod schedule_csv;
pub mod seen;
pub mod sun_hours;
mod sun_sample;
mod sun_texels;
mod through_canopy;
pub mod tile;
mod tile_layers;
pub mod values;

pub use direct::specular::MirrorView;
pub use tile_layers::mirror_views;
