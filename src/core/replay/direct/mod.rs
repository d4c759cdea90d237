//! Direct light: irradiance of receivers from the suns that they see in their sky textures, in the
//! open, in mirrors and behind canopies.

pub mod canopy_transmittance;
pub mod sky_masks;
pub mod specular;
mod sun_map;
pub mod sun_samples;
pub mod suns;
