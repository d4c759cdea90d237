//! Ground of a scene. In: triangles of a scene, and the statements of EnergyPlus models. Out: true
//! if some of the triangles are ground, and a plane for scenes without ground.

pub(crate) mod endless;
pub(crate) mod found;
pub(crate) mod missing;
pub(crate) mod model;
#[cfg(test)]
mod tests;
