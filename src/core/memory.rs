//! Division of the bytes of `--memory` among their uses: one table for all commands. A test adds up
//! the uses that are alive at one time.

use crate::units::Bytes;

/// Bytes of working memory, besides a scene and its tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryBudget(u64);

/// A use of working memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Receivers sorted along the Morton curve, from the beginning of a build to its end.
    SortedReceivers,
    /// Keys of cells that receivers see, while a build traces receivers and probes.
    CellKeys,
    /// Bounce cells, while a build traces them.
    BounceCells,
    /// Radiosities of the closed system of bounce cells.
    Radiosity,
    /// Tiles whose responses are derived together, and the cells that they see.
    TileGroup,
    /// Sums by surface, while results are written.
    SurfaceSums,
    /// Values of one archive in a comparison, until the same receivers of the other one are
    /// replayed.
    ComparedValues,
    /// Sums by surface of both archives, while a comparison is written.
    ComparedSums,
    /// Rows of a map, until the map is complete.
    MapRows,
    /// Patches of receivers, until all patches of a surface are there.
    MapPatches,
    /// The receivers of a list and those of an archive, while they are matched.
    ReceiverList,
    /// Names of receivers, while archives are merged; names of one of two archives that are
    /// compared.
    ReceiverIds,
    /// Names of receivers and the places that they stand for, while those of all tiles are sorted.
    NameIndex,
    /// One list of cell keys, while a part of an archive is extracted.
    ExtractedKeys,
}

impl Use {
    /// Returns the share of the use in the whole, in sixteenths.
    const fn sixteenths(self) -> u64 {
        match self {
            Use::SortedReceivers | Use::NameIndex | Use::CellKeys | Use::BounceCells | Use::ComparedValues => 2,
            Use::Radiosity
            | Use::TileGroup
            | Use::ReceiverList
            | Use::ReceiverIds
            | Use::ExtractedKeys
            | Use::ComparedSums => 4,
            Use::SurfaceSums => 6,
            Use::MapRows | Use::MapPatches => 1,
        }
    }
}

/// Uses that are alive together, at the moment of each command when most are.
pub const TOGETHER: [(&str, &[Use]); 9] = [
    ("build, cells", &[Use::SortedReceivers, Use::CellKeys, Use::BounceCells]),
    ("build, responses", &[Use::SortedReceivers, Use::Radiosity, Use::TileGroup]),
    ("build, merge, extract, names", &[Use::SortedReceivers, Use::NameIndex]),
    ("replay", &[Use::Radiosity, Use::TileGroup, Use::SurfaceSums, Use::MapRows, Use::MapPatches]),
    (
        "compare",
        &[Use::ComparedValues, Use::Radiosity, Use::TileGroup, Use::ComparedSums, Use::MapRows, Use::MapPatches],
    ),
    ("replay, choice of receivers", &[Use::ReceiverList]),
    ("glare", &[Use::ReceiverList, Use::TileGroup, Use::ComparedValues, Use::MapRows, Use::MapPatches]),
    ("merge, diff", &[Use::ReceiverIds, Use::ReceiverIds]),
    // Hits, cells that probes see, and two waves of the cells that bounce cells see.
    ("extract", &[Use::ExtractedKeys, Use::ExtractedKeys, Use::ExtractedKeys, Use::ExtractedKeys]),
];

impl Default for MemoryBudget {
    fn default() -> Self {
        MemoryBudget::DEFAULT
    }
}

impl heliotile_requests::Parse for MemoryBudget {
    fn parse(text: &str) -> Result<Self, heliotile_requests::Wrong> {
        Ok(MemoryBudget::from(text.parse::<Bytes>()?))
    }
}

impl From<Bytes> for MemoryBudget {
    fn from(Bytes(bytes): Bytes) -> Self {
        MemoryBudget(bytes)
    }
}

impl MemoryBudget {
    /// Memory of a command without `--memory`: 4 GiB.
    pub const DEFAULT: MemoryBudget = MemoryBudget(4 << 30);

    /// Returns a budget of `bytes` bytes.
    pub fn new(bytes: u64) -> Self {
        MemoryBudget(bytes)
    }

    /// Returns the whole budget, bytes.
    pub fn total(self) -> u64 {
        self.0
    }

    /// Returns the bytes that one use may take.
    pub fn share(self, of: Use) -> u64 {
        self.0 / 16 * of.sixteenths()
    }

    /// Returns [`MemoryBudget::share`] as a length in memory.
    pub fn length(self, of: Use) -> usize {
        usize::try_from(self.share(of)).unwrap_or(usize::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uses that are alive together take at most the whole budget: 9 of 9 times.
    #[test]
    fn uses_alive_together_fit_the_budget() {
        let budget = MemoryBudget::new(1 << 30);
        for (when, uses) in TOGETHER {
            assert!(uses.iter().map(|of| budget.share(*of)).sum::<u64>() <= budget.total(), "{when}");
        }
    }
}
