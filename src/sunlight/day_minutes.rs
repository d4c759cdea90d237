//! Minutes of sun of all receivers of a tile on one day, for the web page, where the user chooses
//! the day. In: a site, a date. Out: minutes.

use crate::mirrored::{TileMirrors, in_any};
use crate::path::{SunDay, SunPasses};
use crate::seen::{SeenSky, SunSeen};
use heliotile_core::error::Result;
use heliotile_core::light::mirrors::MirrorTable;
use heliotile_core::opened::OpenSite;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::sun::Location;

/// A day over a site.
pub struct DayMinutes {
    day: SunDay,
    passes: SunPasses,
    mirrors: MirrorTable,
}

impl DayMinutes {
    /// Returns the day over a site at its location and clock.
    pub fn new(site: &OpenSite, location: &Location, date: Date) -> Self {
        let day = SunDay::new(location, date, site.north());
        DayMinutes { passes: day.passes(site.settings().sides()), day, mirrors: MirrorTable::new(site) }
    }

    /// Returns the minutes in which each receiver of a tile sees the sun.
    pub fn sun(&self, site: &OpenSite, tile: u32) -> Result<Vec<f32>> {
        let normals = site.tile_receivers(tile)?.receivers().into_iter().map(|receiver| receiver.normal);
        let skies = site.tile_sky(tile, normals.len())?;
        let of = |(normal, sky)| {
            let front = self.day.before(normal, 0.0).within(&self.day.up);
            minutes(&SeenSky::new(sky).sun(&self.passes, &front))
        };
        Ok(normals.zip(&skies).map(of).collect())
    }

    /// Returns the minutes in which mirrors reflect the sun to each receiver of a tile.
    pub fn glare(&self, site: &OpenSite, tile: u32) -> Result<Vec<f32>> {
        let normals = site.tile_receivers(tile)?.receivers().into_iter().map(|receiver| receiver.normal);
        let mirrors = TileMirrors::read(site, tile, normals.len(), &self.mirrors)?;
        let of = |(row, normal)| {
            let shown = mirrors.of_receiver(row, normal).on(&self.day, &self.passes, false);
            minutes(&in_any(shown.iter().map(|one| &one.seen)))
        };
        Ok(normals.enumerate().map(of).collect())
    }
}

fn minutes(seen: &SunSeen) -> f32 {
    seen.seen.minutes() as f32
}
