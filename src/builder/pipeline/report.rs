//! What a build did.

use std::time::Instant;

use super::manifest::BuildCounts;
use heliotile_core::archive::preview::Preview;

/// What a build did, for people and tables.
#[derive(Clone, Debug)]
pub struct BuildReport {
    /// How much the archive holds.
    pub counts: BuildCounts,
    /// Cast by this run: a build that was resumed cast others before.
    pub rays: RayCounts,
    /// Seconds by stage.
    pub seconds: Vec<(&'static str, f64)>,
    /// Length of the archive.
    pub bytes: u64,
    /// Root hash of the archive: names its content.
    pub root: [u8; 32],
    /// Sentences for the user.
    pub warnings: Vec<String>,
    /// Largest share of a receiver's light, and of a cell's, that was lost behind the last mirror followed.
    pub lost_in_mirrors: [f64; 2],
    /// What the archive from before a change gave; `None` where none was used.
    pub kept: Option<Kept>,
    /// What the archive says of itself, if it is a preview.
    pub preview: Option<Preview>,
}

/// What a change of the scene left as it was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Receivers that still meet what they met.
    pub receivers: u64,
    /// Probes that were not traced.
    pub probes: u64,
    /// Bounce cells that were not traced.
    pub bounce_cells: u64,
}

/// Rays cast, by purpose.
#[derive(Clone, Copy, Debug, Default)]
pub struct RayCounts {
    /// Of receivers to the texels of the sky.
    pub sky: u64,
    /// Of receivers to what they see.
    pub hit: u64,
    /// Of probes.
    pub probe: u64,
    /// Of bounce cells.
    pub bounce: u64,
    /// By way of mirrors, for receivers and cells.
    pub mirror: u64,
    /// Of receivers through canopies; those of cells are among `probe` and `bounce`.
    pub canopy: u64,
}

impl RayCounts {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.sky + self.hit + self.probe + self.bounce + self.mirror + self.canopy
    }
}

/// Seconds by stage.
pub(super) struct Clock {
    start: Instant,
    pub laps: Vec<(&'static str, f64)>,
}

impl Clock {
    /// Starts with what was done before.
    pub fn after(name: &'static str, seconds: f64) -> Self {
        Clock { start: Instant::now(), laps: vec![(name, seconds)] }
    }

    /// Ends a stage.
    pub fn lap(&mut self, name: &'static str) {
        self.laps.push((name, self.start.elapsed().as_secs_f64()));
        self.start = Instant::now();
    }
}
