//! The accuracy ladder. In: a rung for each source of error. Out: settings.
//!
//! Errors are independent of each other, so each has a ladder of its own: the receivers' sky textures (sun and sky seen directly or in
//! mirrors), the cells that they see (one reflection), what those see (further ones), and the patches of the sky. What a rung is
//! worth was measured on the sites of `tools/accuracy` against one that is finer everywhere (`tools/accuracy/run`); a build with
//! `--error` measures it on its own receivers.

use super::BuildSettings;
use crate::cli::{Effects, Quality, Share};

/// The receivers' sky texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyRung {
    pub base: usize,
    pub fine: usize,
    /// Sun positions in an hour of replay: more than these show no difference beside the texels.
    pub steps: u16,
}

/// From coarse to fine.
pub const SKY: [SkyRung; 6] = [
    SkyRung { base: 32, fine: 256, steps: 4 },
    SkyRung { base: 64, fine: 512, steps: 6 },
    SkyRung { base: 64, fine: 1024, steps: 12 },
    SkyRung { base: 128, fine: 1024, steps: 12 },
    SkyRung { base: 128, fine: 2048, steps: 30 },
    SkyRung { base: 128, fine: 4096, steps: 60 },
];

/// Cells that receivers see, and their probes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenRung {
    pub hit: usize,
    pub cell_factor: f64,
    pub cell_floor_m: f64,
    pub probe: usize,
}

pub const SEEN: [SeenRung; 7] = [
    SeenRung { hit: 8, cell_factor: 4.0, cell_floor_m: 2.0, probe: 8 },
    SeenRung { hit: 16, cell_factor: 4.0, cell_floor_m: 1.0, probe: 16 },
    SeenRung { hit: 16, cell_factor: 2.0, cell_floor_m: 0.5, probe: 16 },
    SeenRung { hit: 32, cell_factor: 4.0, cell_floor_m: 0.5, probe: 32 },
    SeenRung { hit: 32, cell_factor: 2.0, cell_floor_m: 0.5, probe: 32 },
    SeenRung { hit: 32, cell_factor: 2.0, cell_floor_m: 0.25, probe: 64 },
    SeenRung { hit: 64, cell_factor: 2.0, cell_floor_m: 0.125, probe: 64 },
];

/// What the cells see, and the closed system of coarse ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BouncedRung {
    pub probe_hits: usize,
    pub closed_m: f64,
    pub bounce_sky: usize,
    pub bounce_hits: usize,
}

pub const BOUNCED: [BouncedRung; 6] = [
    BouncedRung { probe_hits: 4, closed_m: 32.0, bounce_sky: 8, bounce_hits: 8 },
    BouncedRung { probe_hits: 8, closed_m: 32.0, bounce_sky: 8, bounce_hits: 8 },
    BouncedRung { probe_hits: 8, closed_m: 16.0, bounce_sky: 16, bounce_hits: 8 },
    BouncedRung { probe_hits: 16, closed_m: 8.0, bounce_sky: 16, bounce_hits: 32 },
    BouncedRung { probe_hits: 16, closed_m: 4.0, bounce_sky: 16, bounce_hits: 16 },
    BouncedRung { probe_hits: 64, closed_m: 2.0, bounce_sky: 16, bounce_hits: 64 },
];

/// Sky patches of replay.
pub const PATCHES: [usize; 3] = [145, 577, 2305];

/// A rung of each ladder: indices into [`SKY`], [`SEEN`], [`BOUNCED`] and [`PATCHES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rungs {
    pub sky: usize,
    pub seen: usize,
    pub bounced: usize,
    pub patches: usize,
}

impl Rungs {
    /// Finer everywhere than any named rung: what they are judged by.
    pub const FINEST: Rungs =
        Rungs { sky: SKY.len() - 1, seen: SEEN.len() - 1, bounced: BOUNCED.len() - 1, patches: PATCHES.len() - 1 };

    pub const fn of(quality: Quality) -> Self {
        match quality {
            Quality::Draft => Rungs { sky: 1, seen: 1, bounced: 1, patches: 0 },
            Quality::Standard => Rungs { sky: 2, seen: 2, bounced: 2, patches: 1 },
            Quality::Fine => Rungs { sky: 3, seen: 3, bounced: 3, patches: 1 },
            Quality::Reference => Rungs { sky: 4, seen: 5, bounced: 4, patches: 2 },
        }
    }

    /// Settings that share probes and leave nothing out.
    pub fn settings(self) -> BuildSettings {
        let (sky, seen, bounced) = (SKY[self.sky], SEEN[self.seen], BOUNCED[self.bounced]);
        BuildSettings {
            sky_base: sky.base,
            sky_fine: sky.fine,
            hit: seen.hit,
            cell_factor: seen.cell_factor,
            cell_floor_m: seen.cell_floor_m,
            probe: seen.probe,
            probe_hits: bounced.probe_hits,
            closed_m: bounced.closed_m,
            bounce_sky: bounced.bounce_sky.min(seen.probe),
            bounce_hits: bounced.bounce_hits,
            patches: PATCHES[self.patches],
            steps: sky.steps,
            share: Share::Cells,
            left_out: Effects::NONE,
        }
    }
}

/// The quality whose settings these are, whatever is left out.
pub fn quality_of(settings: &BuildSettings) -> Option<Quality> {
    let traced = BuildSettings { left_out: Effects::NONE, ..*settings };
    Quality::ALL.into_iter().find(|quality| Rungs::of(*quality).settings() == traced)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All 4 named rungs are in range, are told by their settings, and are finer than the one before in every ladder; 1 changed number is
    /// no named rung.
    #[test]
    fn rungs() {
        for quality in Quality::ALL {
            let settings = Rungs::of(quality).settings();
            settings.check().expect("in range");
            assert_eq!(quality_of(&settings), Some(quality));
            assert_eq!(quality_of(&BuildSettings { probe_hits: 15, ..settings }), None);
        }
        for pair in Quality::ALL.windows(2) {
            let [coarse, fine] = [pair[0], pair[1]].map(Rungs::of);
            assert!(coarse.sky < fine.sky && coarse.seen < fine.seen && coarse.bounced < fine.bounced);
            assert!(coarse.patches <= fine.patches);
        }
        Rungs::FINEST.settings().check().expect("the finest");
        Rungs { sky: 0, seen: 0, bounced: 5, patches: 0 }.settings().check().expect("a coarse probe, fine bounces");
    }
}
