//! Export of an archive's contents for people and programs. In: the place of an archive or of an
//! atlas, a receiver or none. Out: the receiver's layers as a picture or as values; without a
//! receiver a table of the view factors of all receivers.

mod layers;
mod request;
mod sun_position;

use std::io::Write;
use std::path::Path;

use crate::sources;
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::opened::OpenSite;
use heliotile_files::writing::guards::guard_output;
use heliotile_results::outputs::sink::Sink;
use heliotile_results::outputs::tables::format::files_of;
use heliotile_results::outputs::view_factors::{ViewFactorTable, ViewFactors};
use heliotile_results::{GapFractions, Provenance, Resources, SkyComponents};
use layers::{Image, layers_of};

pub use request::ExportRequest;
pub use sun_position::SunPosition;

impl ExportRequest {
    /// Writes the file with its provenance `about`.
    pub fn write(&self, about: Provenance, resources: &Resources) -> Result<()> {
        self.check()?;
        if self.output != Path::new("-") {
            let inputs: Vec<&Path> =
                [Some(self.place.as_path()), self.weather.as_deref()].into_iter().flatten().collect();
            files_of(&self.output).iter().try_for_each(|file| guard_output(file, &inputs))?;
        }
        let Some(receiver) = &self.receiver else { return self.view_factors(about) };
        let bytes = layers_of(self, receiver, Image::by_ending(&self.output)?, about, resources)?;
        let mut sink = Sink::file(&self.output)?;
        sink.write_all(&bytes).map_err(Error::io(&self.output, "write to"))?;
        sink.finish().map(|_| ())
    }

    /// Writes the view factors of all receivers.
    fn view_factors(&self, about: Provenance) -> Result<()> {
        let sources = sources::open(&self.place, self.access)?;
        let archives = sources.borrowed();
        let count = archives.iter().map(|archive| archive.manifest().receivers.count).sum();
        let mut table = ViewFactorTable::create(&self.output, count, &archives.told_in(about, &self.place))?;
        for archive in archives.iter() {
            add_rows(&mut table, archive)?;
        }
        table.finish().map(drop)
    }
}

/// Adds the receivers of an archive to the table; stops if the reader of the table has closed it.
fn add_rows(table: &mut ViewFactorTable, archive: &Archive) -> Result<()> {
    let site = OpenSite::open(archive)?;
    let (overcast, gaps) = (SkyComponents::overcast(&site)?, GapFractions::new(&site)?);
    let has_leaves = site.materials().iter().any(|material| material.transmittance.is_some());
    let uniform = has_leaves.then(|| SkyComponents::uniform(&site)).transpose()?;
    for (tile, percent) in (0..site.tiles()).zip(overcast.tiles(0..site.tiles())) {
        let (receivers, percent) = (site.tile_receivers(tile)?, percent?);
        let seen = uniform.as_ref().and_then(|uniform| uniform.tiles([tile]).next()).transpose()?;
        let gaps = gaps.tile(tile, &receivers.normal)?;
        let rows = receivers.ids.iter().zip(receivers.views()).zip(percent).zip(gaps).enumerate();
        for (row, (((id, views), vsc_percent), gaps)) in rows {
            if table.is_closed() {
                return Ok(());
            }
            let through_leaves = seen.as_ref().and_then(|seen| seen.get(row)).map(|percent| 0.01 * percent);
            table.row(id, &ViewFactors { views, through_leaves, vsc_percent, gaps })?;
        }
    }
    Ok(())
}
