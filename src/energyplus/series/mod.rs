//! Models whose surroundings leave them. In: a model, archives with and without what stands around it, a weather file. Out: the model
//! without it, and a series of what it does to the light of each surface.

pub mod deleted;
pub mod lights;
pub mod objects;
pub mod steps;
pub mod values;
