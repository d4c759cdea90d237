//! Sides of the textures of a receiver's sky and of its response.

/// Sides of the textures in which a replay looks up the sun and the sky, in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureSides {
    /// Side of the sky texture before it is refined. The finest level is this doubled some times.
    pub sky_base: usize,
    /// Side of the finest level of the sky texture, in which the sun's disc is looked up.
    pub sky_fine: usize,
    /// Side of the response texture, whose texels are those of the probes' sky.
    pub response: usize,
}
