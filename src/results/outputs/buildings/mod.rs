//! Solar cadastre. In: receivers with their sums of a year, patches and sky views. Out: a row a
//! building and a row a roof face: areas, sums by orientation, and the area of connected regions
//! above a threshold.

mod cadastre;
mod face;
mod place;
mod regions;
mod tables;

pub use cadastre::Cadastre;
pub use face::Usable;
pub use place::{Envelope, building_of, face_of};
pub use tables::{building_rows, face_rows};
