//! Covering: placing receivers. In: surfaces of a scene, lines that people move along, or
//! `receivers.csv`. Out: receivers, each with the length or area that it stands for.

pub mod cover;
pub mod lines;
mod necks;
pub mod receiver_ids;
pub mod receivers;
pub(crate) mod rows;
pub mod surfaces;
