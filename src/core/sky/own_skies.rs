//! Skies and clouds of files, put before the sun and into the sky of conditions. In: numbers of patches, or pixels, with the rows that go with
//! conditions. Out: conditions that replays take like all others.
//!
//! The sky's radiances are those of the patches that a replay is made with ([`crate::sky::patches::Patches::radiances`]); the sun stays that of
//! the condition, with its DNI. Clouds dim each instant's sun by their mean over its disc, and each patch by their mean over it: the
//! covariance of radiance and clouds inside a patch is lost.

use std::sync::Arc;

use glam::DVec3;

use crate::dome::image::DomeImage;
use crate::dome::series::{PatchRow, PatchSeries};
use crate::error::Error;
use crate::named::NamedValues;
use crate::sky::disc::disc_directions;
use crate::weather::conditions::Condition;

/// What the light of a sky of one's own adds up to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SkyScale {
    /// DHI of each condition
    Dhi,
    /// The radiances as they are
    Given,
}

impl NamedValues for SkyScale {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("dhi", "each sky is scaled to the diffuse irradiance of its hour or condition", SkyScale::Dhi),
        ("given", "radiances count as they are, and their integral replaces the diffuse irradiance", SkyScale::Given),
    ];
}

/// The refusal of a model with light beside its patches, Perez' tilted surfaces of 1990, for conditions with a sky of their own or clouds.
pub fn no_parts() -> Error {
    let what =
        "`perez1990` has light at the sun and on the horizon, which are no patches that a file or clouds could change";
    Error::argument("sky", what, "choose another sky, such as `perez`")
}

/// A sky by row.
#[derive(Clone, Debug)]
pub struct OwnSky {
    series: Arc<PatchSeries>,
    scale: SkyScale,
}

/// What a sky of one's own and the conditions say of DHI.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SkyBalance {
    /// Sum of what the file's skies give an open horizontal surface, W/m2.
    pub own_w_m2: f64,
    /// Sum of DHI of the same conditions, W/m2.
    pub dhi_w_m2: f64,
    /// Sum of what the sun gives an open horizontal surface in them, W/m2.
    pub sun_w_m2: f64,
    /// Conditions with DHI whose sky is black in the file.
    pub black: usize,
}

impl OwnSky {
    /// Radiances by row, W/m2/sr, whose azimuths go by true north.
    pub fn new(series: PatchSeries, scale: SkyScale) -> Self {
        OwnSky { series: Arc::new(series), scale }
    }

    /// A condition under one of its rows.
    pub fn over(&self, condition: Condition, row: usize) -> Condition {
        let dhi_w_m2 = match self.scale {
            SkyScale::Dhi => condition.dhi_w_m2,
            SkyScale::Given => self.series.horizontal_w_m2(row),
        };
        Condition { dhi_w_m2, own_sky: Some(PatchRow::new(&self.series, row)), ..condition }
    }

    /// How its rows compare with conditions that were not lit by them yet.
    pub fn balance<'c>(&self, conditions: impl Iterator<Item = (&'c Condition, usize)>) -> SkyBalance {
        conditions.filter(|(condition, _)| condition.dhi_w_m2 > 0.0).fold(
            SkyBalance::default(),
            |sum, (condition, row)| {
                let own_w_m2 = self.series.horizontal_w_m2(row);
                let height: f64 = condition.suns.iter().map(|instant| instant.weight * instant.sun.z).sum();
                SkyBalance {
                    own_w_m2: sum.own_w_m2 + own_w_m2,
                    dhi_w_m2: sum.dhi_w_m2 + condition.dhi_w_m2,
                    sun_w_m2: sum.sun_w_m2 + condition.dni_w_m2 * height,
                    black: sum.black + usize::from(own_w_m2 <= 0.0),
                }
            },
        )
    }
}

impl SkyBalance {
    /// Whether the skies hold the sun as well: they give 30 % of its light or more beyond DHI, where it has a tenth of DHI or more. Of skies
    /// with the sun that have only what the eye sees of the light, 0.6 of it, that is true as well.
    pub fn holds_sun(&self) -> bool {
        self.sun_w_m2 > 0.1 * self.dhi_w_m2 && self.own_w_m2 > self.dhi_w_m2 + 0.3 * self.sun_w_m2
    }

    /// Light of the skies over DHI; none without DHI.
    pub fn ratio(&self) -> Option<f64> {
        (self.dhi_w_m2 > 0.0).then(|| self.own_w_m2 / self.dhi_w_m2)
    }
}

/// Clouds by row.
#[derive(Clone, Debug)]
pub struct CloudLayer {
    series: Arc<PatchSeries>,
    /// The pixels, where there are some: finer than patches.
    image: Option<DomeImage>,
}

impl CloudLayer {
    /// What comes through patches, 0 to 1, by row; azimuths go by true north.
    pub fn of_patches(series: PatchSeries) -> Self {
        CloudLayer { series: Arc::new(series), image: None }
    }

    /// What comes through pixels, 0 to 1, in one row.
    pub fn of_image(image: DomeImage) -> Option<Self> {
        Some(CloudLayer { series: Arc::new(image.on_patches()?), image: Some(image) })
    }

    /// A condition behind one of its rows; suns still go by true north.
    pub fn over(&self, mut condition: Condition, row: usize) -> Condition {
        for instant in &mut condition.suns {
            instant.unclouded *= self.before(instant.sun, row);
        }
        Condition { clouds: Some(PatchRow::new(&self.series, row)), ..condition }
    }

    /// Mean over the sun's disc of what comes through.
    fn before(&self, sun: DVec3, row: usize) -> f64 {
        let (grid, numbers) = (self.series.grid(), self.series.row(row));
        let through = |direction: DVec3| match &self.image {
            Some(image) => image.at(direction),
            None => numbers.get(grid.patch_of(direction)).copied().unwrap_or_default(),
        };
        let (sum, count) = disc_directions(sun)
            .fold((0.0, 0.0), |(sum, count), direction| (sum + f64::from(through(direction)), count + 1.0));
        if count > 0.0 { sum / count } else { f64::from(through(sun)) }
    }
}

#[cfg(test)]
#[path = "own_skies_tests.rs"]
mod tests;
