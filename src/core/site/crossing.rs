//! Crossings: how often one ray passes leaves or screens of one material.

/// A ray of a list and the canopy material that it passes on its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Crossing {
    /// Index of the ray in its list.
    pub ray: u32,
    /// Row of the materials table, of a material with a transmittance.
    pub material: u16,
    /// Number of crossings, at least 1, or the code of a length in a volume of leaves.
    pub count: u16,
}
