//! What is missing below the horizon. In: the shares of the hemisphere that an archive holds. Out: a sentence, if light is lost there.

use heliotile_core::archive::{Archive, Blocks, format, tables};
use heliotile_core::error::Result;

/// Less than this is the rim of the ground and of textures.
const LEAST: f64 = 0.01;
/// Normals closer to the horizontal than this are of walls (sine of the tilt off the vertical).
const UPRIGHT: f64 = 0.5;

/// Mean shares of the hemisphere, by area, in which receivers meet nothing.
#[derive(Default)]
struct Lost {
    walls: Mean,
    all: Mean,
}

#[derive(Default)]
struct Mean {
    sum: f64,
    weight: f64,
}

impl Mean {
    fn add(&mut self, value: f64, weight: f64) {
        self.sum += weight * value;
        self.weight += weight;
    }

    fn value(&self) -> Option<f64> {
        (self.weight > 0.0).then(|| self.sum / self.weight)
    }
}

/// Says how much of their hemisphere walls see nothing in, or receivers where there are no walls; `None` where that is next to nothing.
pub fn nothing_seen(archive: &Archive) -> Result<Option<String>> {
    let mut lost = Lost::default();
    for tile in 0..archive.tiles() {
        let table = tables::ReceiversTable::from_block(&Blocks::block(archive, format::RECEIVERS, tile)?)?;
        for ((views, normal), area) in table.views().zip(&table.normal).zip(&table.area) {
            let nothing = (1.0 - views.into_iter().map(f64::from).sum::<f64>()).max(0.0);
            // 0 is "not given".
            let weight = if *area > 0.0 { *area } else { 1.0 };
            lost.all.add(nothing, weight);
            if normal[2].abs() <= UPRIGHT {
                lost.walls.add(nothing, weight);
            }
        }
    }
    let (who, share) = match (lost.walls.value(), lost.all.value()) {
        (Some(share), _) => ("walls", share),
        (None, Some(share)) => ("receivers", share),
        (None, None) => return Ok(None),
    };
    let percent = 100.0 * share;
    Ok((share >= LEAST).then(|| {
        format!(
            "{who} see nothing in {percent:.1} % of their hemisphere: below the horizon nothing reflects there (more terrain, or an \
             [endless_ground] in --materials)"
        )
    }))
}
