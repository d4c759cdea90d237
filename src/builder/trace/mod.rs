//! Trace: the only stage that casts rays. In: a mesh and the points to look from. Out: raw hemispheres: sky bits and the
//! cells that are seen. It knows nothing of textures on disk, archives, weather or reflectances.

pub mod beam;
pub mod bounce;
pub mod canopy;
pub mod kernel;
pub mod mirror;
pub mod placement;
pub mod probe;
pub mod receiver;
pub mod surface;
pub mod surroundings;

pub use kernel::rays::{Ray, Tracer};
