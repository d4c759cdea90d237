//! Sides of the textures of a receiver's sky and of its response.

/// Sides of the textures that forcing is looked up in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureSides {
    /// Side of the sky before it is refined; the finest level is it doubled some times.
    pub sky_base: usize,
    /// Side of the finest level, which the sun's disc is looked up in.
    pub sky_fine: usize,
    /// The response, which has the texels of the probes' sky.
    pub response: usize,
}
