//! Report of a build. In: counts and times. Out: a report for people and tables.

use std::time::Instant;

use super::manifest::BuildCounts;
use heliotile_core::text::Message;

/// Report of a build.
#[derive(Clone, Debug)]
pub struct BuildReport {
    /// Numbers of receivers and cells in the archive.
    pub counts: BuildCounts,
    /// Rays cast by this run. A resumed build cast others before.
    pub rays: RayCounts,
    /// Seconds by stage.
    pub seconds: Vec<(&'static str, f64)>,
    /// Length of the archive, bytes.
    pub bytes: u64,
    /// Root hash of the archive, which identifies its content.
    pub root: [u8; 32],
    /// Warnings for the user.
    pub warnings: Vec<Message>,
    /// Largest share of a receiver's light, and of a cell's, that was lost behind the last mirror
    /// followed.
    pub lost_in_mirrors: [f64; 2],
    /// Numbers of layers kept from the archive before a change; `None` if none was used.
    pub kept: Option<ReusedCounts>,
}

/// Numbers of layers that a change of the scene left as they were.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReusedCounts {
    /// Receivers whose hits are unchanged.
    pub receivers: u64,
    /// Probes that were not traced.
    pub probes: u64,
    /// Bounce cells that were not traced.
    pub bounce_cells: u64,
}

/// Numbers of rays cast, by purpose.
#[derive(Clone, Copy, Debug, Default)]
pub struct RayCounts {
    /// Rays of receivers to the texels of the sky.
    pub sky: u64,
    /// Rays of receivers to surfaces.
    pub hit: u64,
    /// Rays of probes.
    pub probe: u64,
    /// Rays of bounce cells.
    pub bounce: u64,
    /// Rays by way of mirrors, for receivers and cells.
    pub mirror: u64,
    /// Rays of receivers through canopies; those of cells are in `probe` and `bounce`.
    pub canopy: u64,
}

impl RayCounts {
    /// Returns the number of all rays.
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
    /// Starts after a stage that is done already.
    pub fn after(name: &'static str, seconds: f64) -> Self {
        Clock { start: Instant::now(), laps: vec![(name, seconds)] }
    }

    /// Ends a stage.
    pub fn lap(&mut self, name: &'static str) {
        self.laps.push((name, self.start.elapsed().as_secs_f64()));
        self.start = Instant::now();
    }
}
