//! What solar cadastres publish. In: receivers with their sums of a year, patches and views of the sky. Out: a row a building, and a row a
//! roof face: areas, sums by orientation, and how much of a roof gets more than a threshold in one piece.

mod cadastre;
mod face;
mod place;
mod regions;
mod tables;

pub use cadastre::Cadastre;
pub use face::Usable;
pub use place::{Envelope, building_of, face_of};
pub use tables::{building_rows, face_rows};
