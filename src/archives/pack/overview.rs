//! Overview block of a tile's receivers. In: receivers with their patches, sky views and yearly
//! sums. Out: a block.

use glam::DVec3;

use crate::pack::COMPRESSION;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::tables::{NORMAL_STEPS, OverviewTable};
use heliotile_core::archive::{EncodedBlock, format};
use heliotile_core::error::Result;
use heliotile_core::site::receiver::Receiver;

/// Row of the overview of a tile. The patch is in [`Receiver::patch`].
pub struct OverviewRow<'a> {
    /// Receiver, of which position, normal, area and patch are stored.
    pub receiver: &'a Receiver,
    /// Sky view: cosine-weighted share of the hemisphere that sees sky.
    pub sky_view: f32,
    /// Irradiation of a clear year, kWh/m2; `None` if the place is unknown.
    pub clear_year: Option<f32>,
}

/// Encodes the overview of a tile, with positions relative to `origin`.
pub fn overview<'a>(
    tile: TileNumber,
    origin: DVec3,
    rows: impl IntoIterator<Item = OverviewRow<'a>>,
) -> Result<EncodedBlock> {
    let mut table = OverviewTable::default();
    for OverviewRow { receiver, sky_view, clear_year } in rows {
        table.position.push((receiver.position - origin).as_vec3().to_array());
        table.normal.push((receiver.normal * NORMAL_STEPS).round().to_array().map(|x| x as i16));
        table.area.push(receiver.area.unwrap_or_default() as f32);
        table.sky_view.push((sky_view * 255.0).round() as u8);
        table.clear_year.extend(clear_year);
        // A patch has at most 255 polygons of at most 255 corners.
        let polygons = receiver.patch.polygons();
        table.polygons.push(polygons.len() as u8);
        for polygon in polygons {
            table.corners.push(polygon.len() as u8);
            table.offset.extend_from_slice(polygon);
        }
    }
    table.encode(format::OVERVIEW, tile, COMPRESSION)
}
