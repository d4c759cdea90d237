//! Receivers of a tile, for display: ids, places, and the parts of the model that they stand for.
//! In: blocks. Out: rows.

use heliotile_core::units::tilt_and_azimuth;
use serde_json::json;

use crate::Answered;
use crate::answer::Answer;
use crate::open::Opened;

/// Answers the rows of a tile.
pub fn receivers(opened: &Opened, tile: u32) -> Answered {
    let (site, north) = (&opened.site, opened.site.north());
    let table = site.tile_receivers(opened.tile(tile)?)?;
    let parts = site.tile_parts(tile, &table)?;
    let rows = parts.iter().zip(table.views()).map(|(receiver, views)| {
        let [object, building, kind, object_type, face] = receiver.part.texts();
        json!({
            "id": receiver.id,
            "position": receiver.position.to_array(),
            "normal": receiver.normal.to_array(),
            "area": receiver.area,
            "surface": receiver.surface,
            "object": object,
            "building": building,
            "kind": kind,
            "objectType": object_type,
            "face": face,
            "tilt": tilt_and_azimuth(receiver.normal).0,
            "azimuth": north.azimuth_deg(receiver.normal),
            "views": views,
        })
    });
    Ok(Answer::of(rows.collect::<Vec<_>>()))
}
