//! Sky components: light of an overcast sky on receivers, relative to open ground. In: a site. Out:
//! percent, tile by tile.

use glam::DVec3;

use heliotile_core::error::Result;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::sky::model::{CieType, SkyModel};
use heliotile_core::weather::conditions::Condition;

/// Irradiance of the overcast sky on open ground, W/m2. Any value would do: results are shares of
/// it.
const OVERCAST_W_M2: f64 = 100.0;

/// Direct light of the CIE traditional overcast sky, percent of that on open ground. On a vertical
/// surface this is the vertical sky component (BRE 209).
pub struct SkyComponents<'a>(Replay<'a>);

impl<'a> SkyComponents<'a> {
    /// Prepares the sky components of a site.
    pub fn new(site: &OpenSite<'a>) -> Result<Self> {
        let sky = [Condition::new("overcast".into(), &[], DVec3::Z, 0.0, OVERCAST_W_M2)];
        let settings = ReplaySettings {
            sky: SkyModel::Cie(CieType::TRADITIONAL_OVERCAST),
            components: ComponentSet::new(&[Component::SkyDirect]),
            ..ReplaySettings::default()
        };
        Replay::new(site, &sky, settings).map(SkyComponents)
    }

    /// Returns the percent of each receiver, `[row]`, of one tile after the other.
    pub fn tiles(&self, tiles: impl IntoIterator<Item = u32>) -> impl Iterator<Item = Result<Vec<f64>>> {
        self.0.results(tiles).map(|result| {
            let (ids, values) = result?;
            let percent = |row: usize| {
                let light = values.row(Component::SkyDirect, row).iter().copied().map(f64::from).sum::<f64>();
                100.0 * light / OVERCAST_W_M2
            };
            Ok((0..ids.len()).map(percent).collect())
        })
    }
}
