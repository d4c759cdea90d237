//! Factors of receivers or groups. In: archives, a grid of suns. Out: name after name, five factors for each sun.

use super::Chosen;
use crate::outputs::groups::{GroupMeans, Groups};
use crate::outputs::tables::layout::By;
use heliotile_builder::observer::Observer;
use heliotile_core::error::{Error, Result};
use heliotile_core::light::scratch::ScratchSpace;
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::replay::factors::{PARTS, SunGrid};
use heliotile_core::replay::run::ReplaySettings;
use heliotile_core::replay::values::TileValues;

/// Factors of receivers, ready to be computed.
pub struct FactorRows<'a> {
    chosen: &'a Chosen<'a>,
    grid: SunGrid,
    settings: ReplaySettings<'a>,
    means: Option<GroupMeans>,
}

impl<'a> FactorRows<'a> {
    /// Of receivers, or of what they are parts of; steps in degrees. An error: steps that divide no circle, groups that do not fit.
    pub fn new(
        chosen: &'a Chosen<'a>,
        steps_deg: (f64, f64),
        by: By,
        (memory, storage): (MemoryBudget, &'a dyn ScratchSpace),
    ) -> Result<Self> {
        let hint = "give divisors of 360 and 90, such as 10 and 5";
        let grid = SunGrid::new(steps_deg.0, steps_deg.1)
            .map_err(|what| Error::argument("--azimuth-step, --altitude-step", what, hint))?;
        let settings = ReplaySettings { memory, storage, ..ReplaySettings::default() };
        let means = match (by, chosen.parts()) {
            (By::Receiver, _) | (_, []) => None,
            (by, [first, ..]) => {
                let groups = Groups::new(chosen.receivers(), by, first.archive.path())?;
                Some(GroupMeans::new(groups, &PARTS, grid.labels(), memory.share(Use::SurfaceSums))?)
            }
        };
        Ok(FactorRows { chosen, grid, settings, means })
    }

    /// The suns.
    pub fn grid(&self) -> &SunGrid {
        &self.grid
    }

    /// Hands on names and their factors, sun by sun, until `each` gives false.
    pub fn each(
        self,
        observer: &dyn Observer,
        mut each: impl FnMut(&str, &mut dyn Iterator<Item = [f64; 5]>) -> Result<bool>,
    ) -> Result<()> {
        let mut means = self.means;
        let mut tell = |names: &[String], values: &TileValues| {
            for (i, name) in names.iter().enumerate() {
                if !each(name, &mut self.grid.factors(|part| values.row(part, i)))? {
                    return Ok(false);
                }
            }
            Ok(true)
        };
        let progress = self.chosen.progress(observer);
        for part in self.chosen.parts().iter().filter(|part| !part.tiles().is_empty()) {
            let patches = part.archive.manifest().settings.patches();
            let replay = self.grid.replay(&part.site, ReplaySettings { patches, ..self.settings })?;
            let goes_on = part.each_tile(&replay, (observer, &progress), |names, values| match &mut means {
                Some(means) => {
                    means.add(values);
                    Ok(true)
                }
                None => tell(names, values),
            })?;
            if !goes_on {
                return Ok(());
            }
        }
        for (names, values, _) in means.iter().flat_map(GroupMeans::tiles) {
            if !tell(&names, &values)? {
                break;
            }
        }
        Ok(())
    }
}
