//! Trace: the only stage that casts rays. In: a mesh and the points to look from. Out: raw hemispheres: sky bits and the
//! cells that are seen. It knows nothing of textures on disk, archives, weather or reflectances.

mod beam;
pub(crate) mod bounce;
pub mod canopy;
pub mod lanes;
pub mod lying;
pub(crate) mod mirror;
mod packet;
mod planes;
pub(crate) mod probe;
pub mod rays;
pub mod receiver;
pub(crate) mod surface;
pub(crate) mod surroundings;
mod tree;
mod triangle;
mod walk;

pub use rays::{Ray, Tracer};
