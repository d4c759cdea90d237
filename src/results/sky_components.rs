//! Sky components: direct light of a sky on receivers, relative to open ground. In: a site. Out:
//! percent, tile by tile.

use glam::DVec3;

use heliotile_core::error::Result;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::sky::model::{CieType, SkyModel};
use heliotile_core::weather::conditions::Condition;

/// Irradiance of the sky on open ground, W/m2. Any value would do: results are shares of
/// it.
const OPEN_W_M2: f64 = 100.0;

/// Direct light of a sky, percent of that on open ground.
pub struct SkyComponents<'a>(Replay<'a>);

impl<'a> SkyComponents<'a> {
    /// Prepares the light of the CIE traditional overcast sky: on a vertical surface the vertical
    /// sky component (BRE 209).
    pub fn overcast(site: &OpenSite<'a>) -> Result<Self> {
        SkyComponents::new(site, SkyModel::Cie(CieType::TRADITIONAL_OVERCAST))
    }

    /// Prepares the light of a uniform sky: the share of the hemisphere that is sky, as seen
    /// through leaves.
    pub fn uniform(site: &OpenSite<'a>) -> Result<Self> {
        SkyComponents::new(site, SkyModel::Uniform)
    }

    fn new(site: &OpenSite<'a>, sky: SkyModel) -> Result<Self> {
        let diffuse = [Condition::new("sky".into(), &[], DVec3::Z, 0.0, OPEN_W_M2)];
        let settings =
            ReplaySettings { sky, components: ComponentSet::new(&[Component::SkyDirect]), ..ReplaySettings::default() };
        Replay::new(site, &diffuse, settings).map(SkyComponents)
    }

    /// Returns the percent of each receiver, `[row]`, of one tile after the other.
    pub fn tiles(&self, tiles: impl IntoIterator<Item = u32>) -> impl Iterator<Item = Result<Vec<f64>>> {
        self.0.results(tiles).map(|result| {
            let (ids, values) = result?;
            let percent = |row: usize| {
                let light = values.row(Component::SkyDirect, row).iter().copied().map(f64::from).sum::<f64>();
                100.0 * light / OPEN_W_M2
            };
            Ok((0..ids.len()).map(percent).collect())
        })
    }
}
