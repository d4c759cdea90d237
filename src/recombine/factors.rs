//! Factors of receivers or groups. In: an archive, a grid of suns. Out: name after name, five factors for each sun.

use super::{Chosen, ChosenPart};
use crate::outputs::groups::{GroupMeans, Groups};
use crate::outputs::tables::layout::By;
use heliotile_builder::observer::Observer;
use heliotile_core::error::{Error, Result};
use heliotile_core::light::scratch::ScratchSpace;
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::replay::factors::{Factors, PARTS, SunGrid};
use heliotile_core::replay::run::ReplaySettings;
use heliotile_core::replay::values::TileValues;

/// Factors of an archive, ready to be computed.
pub struct FactorRows<'a> {
    factors: Factors<'a>,
    part: &'a ChosenPart<'a>,
    chosen: &'a Chosen<'a>,
    means: Option<GroupMeans>,
}

impl<'a> FactorRows<'a> {
    /// Of receivers, or of what they are parts of; steps in degrees. An error: steps that divide no circle, groups that do not fit.
    pub fn new(
        chosen: &'a Chosen<'a>,
        steps_deg: (f64, f64),
        by: By,
        (memory, storage): (MemoryBudget, &dyn ScratchSpace),
    ) -> Result<Self> {
        let hint = "give divisors of 360 and 90, such as 10 and 5";
        let grid = SunGrid::new(steps_deg.0, steps_deg.1)
            .map_err(|what| Error::argument("--azimuth-step, --altitude-step", what, hint))?;
        let [part] = chosen.parts() else {
            let what = format!("{} archives are no one place, and factors are of one", chosen.parts().len());
            return Err(Error::argument("SITE", what, "name the site.helio of one part of the atlas"));
        };
        let patches = part.archive.manifest().settings.patches();
        let settings = ReplaySettings { patches, memory, storage, ..ReplaySettings::default() };
        let factors = Factors::new(&part.site, grid, settings)?;
        let means = match by {
            By::Receiver => None,
            by => {
                let groups = Groups::new(chosen.receivers(), by, part.archive.path())?;
                Some(GroupMeans::new(groups, &PARTS, factors.labels(), memory.share(Use::SurfaceSums))?)
            }
        };
        Ok(FactorRows { factors, part, chosen, means })
    }

    /// The suns.
    pub fn grid(&self) -> &SunGrid {
        self.factors.grid()
    }

    /// Hands on names and their factors, sun by sun, until `each` gives false.
    pub fn each(
        mut self,
        observer: &dyn Observer,
        mut each: impl FnMut(&str, &mut dyn Iterator<Item = [f64; 5]>) -> Result<bool>,
    ) -> Result<()> {
        let factors = &self.factors;
        let mut tell = |names: &[String], values: &TileValues| {
            for (i, name) in names.iter().enumerate() {
                if !each(name, &mut factors.of(|part| values.row(part, i)))? {
                    return Ok(false);
                }
            }
            Ok(true)
        };
        let means = &mut self.means;
        let progress = self.chosen.progress(observer);
        self.part.each_tile(factors.irradiances(), (observer, &progress), |names, values| match means {
            Some(means) => {
                means.add(values);
                Ok(true)
            }
            None => tell(names, values),
        })?;
        for (names, values, _) in means.iter().flat_map(GroupMeans::tiles) {
            if !tell(&names, &values)? {
                break;
            }
        }
        Ok(())
    }
}
