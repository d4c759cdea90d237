//! Sides of the textures of a receiver's sky and of its response.

/// Sides of the textures that forcing is looked up in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureSides {
    /// The sky before it is refined, and its finest level: the base doubled some times.
    pub sky_base: usize,
    pub sky_fine: usize,
    /// The response, which has the texels of the probes' sky.
    pub response: usize,
}
