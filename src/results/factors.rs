//! Factors of receivers or groups by position of the sun. In: archives, a grid of suns. Out: five
//! factors for each sun, name after name.

use std::path::{Path, PathBuf};

use super::buildings::check_table;
use super::receivers::ReceiverSet;
use super::resources::Resources;
use crate::outputs::factors::FactorTable;
use crate::outputs::groups::{GroupMeans, Groups};
use crate::outputs::provenance::Provenance;
use crate::outputs::tables::format::table_help;
use crate::outputs::tables::layout::By;
use heliotile_core::error::{Error, Result, check_ranges};
use heliotile_core::memory::Use;
use heliotile_core::observer::Observer;
use heliotile_core::replay::factors::{PARTS, SunGrid};
use heliotile_core::replay::run::ReplaySettings;
use heliotile_core::replay::values::TileValues;
use heliotile_core::text::Message;
use heliotile_requests::{DefaultRequest, Request};

/// Request for a table of the light that surroundings reflect on receivers, by position of the sun.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct FactorsRequest {
    /// Table, in a format by the ending of its name; `-`: CSV on standard output.
    #[field(short = 'o', default = "-", help = output_help, output = Table)]
    pub output: PathBuf,
    /// Grouping of rows: what each row stands for.
    #[field(default = "receiver")]
    pub by: By,
    /// Step of the sun's azimuth, degrees, from 0 to 360: a divisor of 360.
    #[field(metavar = "DEGREES", default = 10.0)]
    pub azimuth_step_deg: f64,
    /// Step of the sun's altitude, degrees, from 0.5 to 90: a divisor of 90.
    #[field(metavar = "DEGREES", default = 5.0)]
    pub altitude_step_deg: f64,
}

impl FactorsRequest {
    /// Refuses a table of an unknown ending, and one that would replace an input.
    pub fn check(&self, inputs: &[&Path]) -> Result<()> {
        check_ranges(self)?;
        check_table(&self.output, inputs)
    }

    /// Writes the table for `receivers`.
    pub fn write(&self, receivers: &ReceiverSet, about: Provenance, resources: &Resources) -> Result<()> {
        let steps_deg = (self.azimuth_step_deg, self.altitude_step_deg);
        let rows = FactorRows::new(receivers, steps_deg, self.by, resources)?;
        let mut to = FactorTable::create(&self.output, self.by.name(), rows.grid(), rows.count(), &about)?;
        rows.each(resources.observer, |name, factors| {
            to.write(name, factors)?;
            Ok(!to.is_closed())
        })?;
        to.finish().map(drop)
    }
}

/// Factors of receivers or groups, ready to be computed.
pub struct FactorRows<'a> {
    receivers: &'a ReceiverSet<'a>,
    grid: SunGrid,
    settings: ReplaySettings<'a>,
    means: Option<GroupMeans>,
}

impl<'a> FactorRows<'a> {
    /// Prepares the factors of receivers or of groups of them; steps in degrees. Errors: steps that
    /// divide no circle, groups that do not fit.
    pub fn new(
        receivers: &'a ReceiverSet<'a>,
        steps_deg: (f64, f64),
        by: By,
        resources: &Resources<'a>,
    ) -> Result<Self> {
        let hint = "give divisors of 360 and 90, such as 10 and 5";
        let grid = SunGrid::new(steps_deg.0, steps_deg.1)
            .map_err(|what| Error::argument("azimuth_step, altitude_step", what, hint))?;
        let Resources { memory, storage, .. } = *resources;
        let settings = ReplaySettings { memory, storage, ..ReplaySettings::default() };
        let means = match (by, receivers.parts()) {
            (By::Receiver, _) | (_, []) => None,
            (by, [first, ..]) => {
                let groups = Groups::new(receivers.receivers(), by, first.archive.path())?;
                Some(GroupMeans::new(groups, &PARTS, grid.bins(), memory.share(Use::SurfaceSums))?)
            }
        };
        Ok(FactorRows { receivers, grid, settings, means })
    }

    /// Returns the grid of suns.
    pub fn grid(&self) -> &SunGrid {
        &self.grid
    }

    /// Returns the number of receivers or groups.
    pub fn count(&self) -> u64 {
        self.means.as_ref().map_or(self.receivers.count(), |means| means.groups().names().len() as u64)
    }

    /// Computes the factors and hands each name with them, sun by sun, to `each`, until `each`
    /// returns false.
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
        let progress = self.receivers.progress(observer);
        for part in self.receivers.parts().iter().filter(|part| !part.tiles().is_empty()) {
            let patches = part.archive.manifest().settings.patches();
            let replay = self.grid.replay(&part.site, ReplaySettings { patches, ..self.settings })?;
            let goes_on = part.each_tile(&replay, observer, &progress, |tile| match &mut means {
                Some(means) => {
                    means.add(tile.values)?;
                    Ok(true)
                }
                None => tell(tile.ids, tile.values),
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

/// Returns the help of the output.
fn output_help() -> Message {
    table_help("Table to write")
}
