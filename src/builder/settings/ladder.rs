//! The accuracy ladder. In: a rung for each source of error. Out: the rung of a quality in each.
//!
//! Errors are independent of each other, so each source has a ladder of its own: the receivers' sky
//! textures (sun and sky seen directly or in mirrors), the cells that receivers see (one
//! reflection), the cells that those see (further reflections), and the patches of the sky. The
//! values of the rungs are declared with the settings ([`heliotile_core::archive::settings`]). The
//! error of a rung was measured on the sites of `tools/accuracy`, against a rung that is finer
//! everywhere (`tools/accuracy/run`). A build with `--error` measures it on its own receivers.

use heliotile_core::archive::settings::{Ladder, SETTINGS};

use super::quality::Quality;

/// Returns the number of rungs of a ladder.
pub const fn rungs_of(ladder: Ladder) -> usize {
    let mut i = 0;
    while i < SETTINGS.len() {
        if SETTINGS[i].ladder as u8 == ladder as u8 {
            return SETTINGS[i].rungs.len();
        }
        i += 1;
    }
    0
}

/// Number of rungs of the ladder of the receivers' sky textures.
pub const SKY_RUNGS: usize = rungs_of(Ladder::Sky);
/// Number of rungs of the ladder of the cells that receivers see.
pub const SEEN_RUNGS: usize = rungs_of(Ladder::Seen);
/// Number of rungs of the ladder of the cells that those cells see.
pub const BOUNCED_RUNGS: usize = rungs_of(Ladder::Bounced);
/// Number of rungs of the ladder of the sky patches.
pub const PATCH_RUNGS: usize = rungs_of(Ladder::Patches);

/// One rung of each ladder, counted from 0, the coarsest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rungs {
    /// Rung of the receivers' sky textures, below [`SKY_RUNGS`].
    pub sky: usize,
    /// Rung of the cells that receivers see, below [`SEEN_RUNGS`].
    pub seen: usize,
    /// Rung of the cells that those cells see, below [`BOUNCED_RUNGS`].
    pub bounced: usize,
    /// Rung of the sky patches, below [`PATCH_RUNGS`].
    pub patches: usize,
}

impl Rungs {
    /// Finest rung of every ladder: the reference that the error of other rungs is measured
    /// against.
    pub const FINEST: Rungs =
        Rungs { sky: SKY_RUNGS - 1, seen: SEEN_RUNGS - 1, bounced: BOUNCED_RUNGS - 1, patches: PATCH_RUNGS - 1 };

    /// Returns the rungs of a quality.
    pub const fn new(quality: Quality) -> Self {
        match quality {
            Quality::Draft => Rungs { sky: 1, seen: 1, bounced: 1, patches: 0 },
            Quality::Standard => Rungs { sky: 2, seen: 2, bounced: 2, patches: 1 },
            Quality::Fine => Rungs { sky: 3, seen: 3, bounced: 3, patches: 1 },
            Quality::Reference => Rungs { sky: 4, seen: 6, bounced: 4, patches: 2 },
        }
    }

    /// Returns the rung of one ladder.
    pub const fn at(self, ladder: Ladder) -> usize {
        match ladder {
            Ladder::Sky => self.sky,
            Ladder::Seen => self.seen,
            Ladder::Bounced => self.bounced,
            Ladder::Patches => self.patches,
        }
    }

    /// Returns true if no rung is above that of `other`.
    pub const fn is_nowhere_finer(self, other: Rungs) -> bool {
        self.sky <= other.sky
            && self.seen <= other.seen
            && self.bounced <= other.bounced
            && self.patches <= other.patches
    }
}
