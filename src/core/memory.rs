//! How the bytes of `--memory` are divided: one table for all commands. A test adds up what is alive at one time.

use crate::units::Bytes;

/// Bytes to work in, besides a scene and its tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryBudget(u64);

/// What takes memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Receivers sorted along the Morton curve, from the beginning of a build to its end.
    SortedReceivers,
    /// Keys of cells that receivers see, while a build traces receivers and probes.
    CellKeys,
    /// Bounce cells, while a build traces them.
    BounceCells,
    /// Radiosities of the closed system.
    Radiosity,
    /// Tiles whose responses are derived together, and what they see.
    TileGroup,
    /// Sums by surface, while results are written.
    SurfaceSums,
    /// Values of an archive that is compared with another one, until the same receivers of that are replayed.
    ComparedValues,
    /// Sums by surface of both archives, while a comparison is written.
    ComparedSums,
    /// Rows of a map, until all are there.
    MapRows,
    /// Patches of receivers, until those of a surface stand together.
    MapPatches,
    /// The receivers of a list, and those of an archive, while they are matched.
    ReceiverList,
    /// Names of receivers, while archives are merged; of one of two archives that are compared.
    ReceiverIds,
    /// Names of receivers and what they stand for, while those of all tiles are put in order.
    NameIndex,
    /// One list of keys of cells, while an archive is extracted from.
    ExtractedKeys,
}

impl Use {
    /// Share of the whole, in sixteenths.
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

/// What is alive together, by the time of its command when most is.
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
    // Hits, what probes see, and two waves of what bounce cells see.
    ("extract", &[Use::ExtractedKeys, Use::ExtractedKeys, Use::ExtractedKeys, Use::ExtractedKeys]),
];

impl From<Bytes> for MemoryBudget {
    fn from(Bytes(bytes): Bytes) -> Self {
        MemoryBudget(bytes)
    }
}

impl MemoryBudget {
    /// What commands take if they are not told otherwise: 4 GiB.
    pub const DEFAULT: MemoryBudget = MemoryBudget(4 << 30);

    /// So many bytes.
    pub fn new(bytes: u64) -> Self {
        MemoryBudget(bytes)
    }

    /// All of them.
    pub fn total(self) -> u64 {
        self.0
    }

    /// What one use of them may take, bytes.
    pub fn share(self, of: Use) -> u64 {
        self.0 / 16 * of.sixteenths()
    }

    /// The same as a length in memory.
    pub fn length(self, of: Use) -> usize {
        usize::try_from(self.share(of)).unwrap_or(usize::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is alive together takes at most all: 8 of 8 times.
    #[test]
    fn the_parts_add_up() {
        let budget = MemoryBudget::new(1 << 30);
        for (when, uses) in TOGETHER {
            assert!(uses.iter().map(|of| budget.share(*of)).sum::<u64>() <= budget.total(), "{when}");
        }
    }
}
