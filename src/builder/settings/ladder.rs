//! The accuracy ladder. In: a rung for each source of error. Out: settings.
//!
//! Errors are independent of each other, so each source has a ladder of its own: the receivers' sky
//! textures (sun and sky seen directly or in mirrors), the cells that receivers see (one
//! reflection), the cells that those see (further reflections), and the patches of the sky. The
//! values of the rungs are declared with the settings ([`heliotile_core::archive::settings`]). The
//! error of a rung was measured on the sites of `tools/accuracy`, against a rung that is finer
//! everywhere (`tools/accuracy/run`). A build with `--error` measures it on its own receivers.

use heliotile_core::archive::settings::{Ladder, SETTINGS};

use super::effects::Effects;
use super::quality::Quality;
use super::values::BuildSettings;

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

/// Returns the number of sky patches of each rung.
pub fn patches() -> [usize; PATCH_RUNGS] {
    std::array::from_fn(|patches| Rungs { patches, ..Rungs::FINEST }.settings().patches)
}

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

    /// Returns the settings of the rungs, which share probes and leave nothing out.
    pub fn settings(self) -> BuildSettings {
        BuildSettings::of_rungs(self)
    }
}

/// Returns the quality with these settings, whatever they leave out.
pub fn quality_of(settings: &BuildSettings) -> Option<Quality> {
    let traced = BuildSettings { left_out: Effects::NONE, ..*settings };
    Quality::ALL.into_iter().find(|quality| Rungs::new(*quality).settings() == traced)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All 4 named rungs are in range, are recognised from their settings, and are finer than the
    /// one before in every ladder. Settings with 1 changed number are no named rung.
    #[test]
    fn each_rung_is_finer_than_the_one_before() {
        for quality in Quality::ALL {
            let settings = Rungs::new(quality).settings();
            settings.check().expect("in range");
            assert_eq!(quality_of(&settings), Some(quality));
            assert_eq!(quality_of(&BuildSettings { probe_hits: 15, ..settings }), None);
        }
        for pair in Quality::ALL.windows(2) {
            let [coarse, fine] = [pair[0], pair[1]].map(Rungs::new);
            assert!(coarse.sky < fine.sky && coarse.seen < fine.seen && coarse.bounced < fine.bounced);
            assert!(coarse.patches <= fine.patches);
        }
        Rungs::FINEST.settings().check().expect("the finest");
        Rungs { sky: 0, seen: 0, bounced: 5, patches: 0 }.settings().check().expect("a coarse probe, fine bounces");
    }
}
