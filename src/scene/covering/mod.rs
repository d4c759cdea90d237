//! Covering: where receivers stand. In: surfaces of a scene, lines that people move along, or `receivers.csv`. Out: receivers, each with what it
//! stands for.

pub mod cover;
pub mod lines;
mod necks;
pub mod receiver_ids;
pub mod receivers;
pub(crate) mod rows;
pub mod surfaces;
