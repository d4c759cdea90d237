//! Probes and bounce cells as plain tables, sorted by key. In: traced cells. Out: columns that recombination reads.

use crate::scene::cells::CellKey;

/// Fine probes: each cell's sky bits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Probes {
    /// Sorted, no two equal.
    pub keys: Vec<CellKey>,
    /// Mean unit normal of the cell's points.
    pub normals: Vec<[f32; 3]>,
    /// [probe][texel / 8], world frame, row-major, lowest bit first.
    pub bits: Vec<u8>,
    /// [probe][ray], equal weights: rows of [`Bounces`] as in its own `hits`.
    pub hits: Vec<u32>,
}

/// Coarse cells of the bounce system. `hits` refers to the table itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bounces {
    /// Sorted, no two equal; every cell that a probe or a cell of the table sees.
    pub keys: Vec<CellKey>,
    pub normals: Vec<[f32; 3]>,
    /// [cell][texel / 8] of the cells' own sky texture.
    pub bits: Vec<u8>,
    /// [cell][ray], equal weights: index of the cell met, plus [`DOWN`] for rays below the horizon; [`MISS`] for nothing.
    pub hits: Vec<u32>,
}

/// Flag of a ray that goes below the horizon.
pub const DOWN: u32 = 1 << 31;
/// Index of a ray that met nothing.
pub const MISS: u32 = DOWN - 1;

impl Probes {
    /// Row of a key.
    pub fn find(&self, key: &CellKey) -> Option<usize> {
        self.keys.binary_search(key).ok()
    }
}
