//! Trace: the only stage that casts rays. In: a mesh and the points to look from. Out: raw hemispheres: sky bits and the
//! cells that are seen. It knows nothing of textures on disk, archives, weather or reflectances.

pub mod beam;
pub mod bounce;
pub mod canopy;
pub mod lanes;
pub mod lying;
pub mod mirror;
pub mod packet;
pub mod planes;
pub mod probe;
pub mod rays;
pub mod receiver;
pub mod surface;
pub mod surroundings;
pub mod tree;
pub mod triangle;
pub mod walk;

pub use rays::{Ray, Tracer};
