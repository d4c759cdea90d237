//! Trace: the only stage that casts rays. In: a mesh and viewpoints. Out: raw hemispheres: sky bits
//! and the cells that are seen. It knows nothing of textures on disk, archives, weather or
//! reflectances.

pub mod canopy;
mod canopy_sky;
pub(crate) mod change;
pub(crate) mod hidden;
pub mod kernel;
pub(crate) mod mirror;
pub mod placement;
pub(crate) mod probe;
pub mod receiver;
pub(crate) mod refinement;
pub mod sky_fans;
pub(crate) mod surface;
pub(crate) mod surroundings;
#[cfg(test)]
mod test_scenes;
pub mod viewpoint;
pub(crate) mod volume;

pub use crate::trace::kernel::ray::Ray;
pub use kernel::rays::Tracer;
