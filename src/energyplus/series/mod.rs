//! Models whose surroundings are removed. In: a model, archives with and without its surroundings,
//! a weather file. Out: the model without its surroundings, and a series of their effect on the
//! light of each surface.

pub mod deleted;
pub mod lights;
pub mod objects;
pub mod steps;
pub mod values;
