//! Crossing: how often one ray passes leaves or screens of one material.

/// A ray of some list and what it passes on its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Crossing {
    /// Place of the ray in its list.
    pub ray: u32,
    /// Row of the materials table, one with a transmittance.
    pub material: u16,
    /// At least 1; 255 stands for more.
    pub count: u8,
}
