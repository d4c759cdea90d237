//! Light that is missing below the horizon. In: the view shares of receivers that an archive holds.
//! Out: a sentence, if light is lost there.

use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::{Archive, Blocks, format, tables};
use heliotile_core::error::Result;
use heliotile_core::text::{Message, message};

/// Least lost share that is reported. Smaller shares come from the rim of the ground and of
/// textures.
const MIN: f64 = 0.01;
/// Largest vertical part of a wall's normal (sine of the tilt off the vertical).
const UPRIGHT: f64 = 0.5;

/// Mean shares of the hemisphere, by area, in which receivers meet nothing.
#[derive(Default)]
struct HorizonGaps {
    walls: Mean,
    all: Mean,
}

/// Mean by area, or a plain mean if a receiver has no area.
#[derive(Default)]
struct Mean {
    by_area: f64,
    area_m2: f64,
    plain: f64,
    receivers: f64,
    is_whole: bool,
}

impl Mean {
    /// Adds a value; an area of 0 means "not given".
    fn add(&mut self, value: f64, area_m2: f64) {
        self.is_whole = area_m2 > 0.0 && (self.is_whole || self.receivers == 0.0);
        self.by_area += area_m2 * value;
        self.area_m2 += area_m2;
        self.plain += value;
        self.receivers += 1.0;
    }

    fn value(&self) -> Option<f64> {
        let (sum, weight) = if self.is_whole { (self.by_area, self.area_m2) } else { (self.plain, self.receivers) };
        (weight > 0.0).then(|| sum / weight)
    }
}

/// Returns a sentence with the share of their hemisphere in which walls, or receivers if there are
/// no walls, see nothing; `None` if that share is below 1 %.
pub fn black_below_horizon(archive: &Archive) -> Result<Option<Message>> {
    let mut lost = HorizonGaps::default();
    archive.expect_all(format::RECEIVERS);
    for tile in 0..archive.tiles() {
        let table = tables::ReceiversTable::from_block(&Blocks::block(archive, format::RECEIVERS, TileNumber(tile))?)?;
        for ((views, normal), area) in table.views().zip(&table.normal).zip(&table.area) {
            let nothing = (1.0 - views.into_iter().map(f64::from).sum::<f64>()).max(0.0);
            lost.all.add(nothing, *area);
            if normal[2].abs() <= UPRIGHT {
                lost.walls.add(nothing, *area);
            }
        }
    }
    let (who, share) = match (lost.walls.value(), lost.all.value()) {
        (Some(share), _) => ("walls", share),
        (None, Some(share)) => ("receivers", share),
        (None, None) => return Ok(None),
    };
    let percent = 100.0 * share;
    Ok((share >= MIN).then(|| {
        message!(
            "{who} see no surface in {percent:.1} % of their hemisphere, below the horizon: nothing reflects there (add terrain, or an \
             [endless_ground] to {{materials}})"
        )
    }))
}
