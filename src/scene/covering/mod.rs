//! Covering: placing receivers. In: surfaces of a scene. Out: receivers, each with the area that it
//! stands for.

pub mod cover;
mod necks;
pub mod surfaces;
