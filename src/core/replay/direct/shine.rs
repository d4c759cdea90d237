//! A position of the sun as a result feels it.

use glam::DVec3;

/// A sun that shines on a result.
#[derive(Clone, Copy, Debug)]
pub struct Shine {
    /// Result.
    pub bin: usize,
    /// Irradiance normal to it x share of the time x weight in the result.
    pub strength: f64,
    /// Of its middle.
    pub direction: DVec3,
}
