//! What lies below the horizon. In: triangles of a scene, and what EnergyPlus models say. Out: whether some of the triangles are ground,
//! and a plane for scenes that have none.

pub(crate) mod endless;
pub(crate) mod found;
pub(crate) mod missing;
pub(crate) mod model;
#[cfg(test)]
mod tests;
