//! What a build did.

use std::time::Instant;

use super::manifest::BuildCounts;

/// What a build did.
#[derive(Clone, Debug)]
pub struct BuildReport {
    pub counts: BuildCounts,
    /// Cast by this run: a build that was resumed cast others before.
    pub rays: RayCounts,
    /// Seconds by stage.
    pub seconds: Vec<(&'static str, f64)>,
    pub bytes: u64,
    pub root: [u8; 32],
    pub warnings: Vec<String>,
    /// Largest share of a receiver's light, and of a cell's, that was lost behind the last mirror followed.
    pub lost_in_mirrors: [f64; 2],
}

/// Rays cast, by purpose.
#[derive(Clone, Copy, Debug, Default)]
pub struct RayCounts {
    pub sky: u64,
    pub hit: u64,
    pub probe: u64,
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
