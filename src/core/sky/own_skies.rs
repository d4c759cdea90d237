//! Skies and clouds from files. In: numbers of patches or pixels, and the row for each condition.
//! Out: conditions with this sky, behind these clouds, for any replay.
//!
//! Radiances are resampled to the patches of the replay
//! ([`crate::sky::patches::Patches::radiances`]). The sun and its DNI stay those of the condition.
//! Clouds dim each instant's sun by their mean over its disc, and each patch by their mean over it.
//! The covariance of radiance and clouds inside a patch is lost.

use std::sync::Arc;

use glam::DVec3;

use crate::dome::image::DomeImage;
use crate::dome::series::{PatchRow, PatchSeries};
use crate::error::{Error, Problem};
use crate::named::NamedValues;
use crate::sky::disc::disc_directions;
use crate::weather::conditions::Condition;

/// Level of the radiances of a sky from a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SkyScale {
    /// Scaled to the DHI of each condition.
    Dhi,
    /// Radiances as given in the file.
    Given,
}

impl NamedValues for SkyScale {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("dhi", "Each sky is scaled to the diffuse irradiance of its hour or condition", SkyScale::Dhi),
        ("given", "Radiances count as they are, and their integral replaces the diffuse irradiance", SkyScale::Given),
    ];
}

/// Returns the error for conditions with a sky from a file or clouds under a model with light
/// beside its patches, Perez' tilted surfaces of 1990.
pub fn no_parts() -> Error {
    let what = "`perez1990` adds light at the sun and on the horizon, which a file of skies or clouds cannot change";
    Error::argument("sky", what, "choose another sky, such as `perez`").because(Problem::excludes("sky"))
}

/// Skies from a file, one a row.
#[derive(Clone, Debug)]
pub struct OwnSky {
    series: Arc<PatchSeries>,
    scale: SkyScale,
}

/// Light of the skies of a file, compared with the DHI of the conditions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SkyBalance {
    /// Irradiance of an open horizontal surface from the file's skies, summed over conditions,
    /// W/m2.
    pub own_w_m2: f64,
    /// DHI, summed over the same conditions, W/m2.
    pub dhi_w_m2: f64,
    /// Irradiance of an open horizontal surface from the sun, summed over the same conditions,
    /// W/m2.
    pub sun_w_m2: f64,
    /// Number of conditions with DHI whose sky is black in the file.
    pub black: usize,
}

impl OwnSky {
    /// Takes radiances by row, W/m2/sr, whose azimuths are from true north.
    pub fn new(series: PatchSeries, scale: SkyScale) -> Self {
        OwnSky { series: Arc::new(series), scale }
    }

    /// Returns the condition under the sky of a row.
    pub fn over(&self, condition: Condition, row: usize) -> Condition {
        let dhi_w_m2 = match self.scale {
            SkyScale::Dhi => condition.dhi_w_m2,
            SkyScale::Given => self.series.horizontal_w_m2(row),
        };
        Condition { dhi_w_m2, own_sky: Some(PatchRow::new(&self.series, row)), ..condition }
    }

    /// Compares the rows with conditions that do not have these skies yet.
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
    /// Returns true if the skies seem to hold the sun as well: they give more than DHI and 30 % of
    /// the sun's light, and the sun's light is more than a tenth of DHI. The bound of 30 % also
    /// finds skies with the sun whose radiances cover visible light only, 0.6 of all.
    pub fn holds_sun(&self) -> bool {
        self.sun_w_m2 > 0.1 * self.dhi_w_m2 && self.own_w_m2 > self.dhi_w_m2 + 0.3 * self.sun_w_m2
    }

    /// Returns the light of the skies over DHI, or `None` without DHI.
    pub fn ratio(&self) -> Option<f64> {
        (self.dhi_w_m2 > 0.0).then(|| self.own_w_m2 / self.dhi_w_m2)
    }
}

/// Clouds from a file, one layer a row.
#[derive(Clone, Debug)]
pub struct CloudLayer {
    series: Arc<PatchSeries>,
    /// Pixels of an image, finer than patches, if the clouds come from one.
    image: Option<DomeImage>,
}

impl CloudLayer {
    /// Takes the transmittance of patches, 0 to 1, by row; azimuths are from true north.
    pub fn of_patches(series: PatchSeries) -> Self {
        CloudLayer { series: Arc::new(series), image: None }
    }

    /// Takes the transmittance of pixels, 0 to 1, in one row.
    pub fn of_image(image: DomeImage) -> Option<Self> {
        Some(CloudLayer { series: Arc::new(image.on_patches()?), image: Some(image) })
    }

    /// Returns the condition behind the clouds of a row; its suns must still be in axes along true
    /// north.
    pub fn over(&self, mut condition: Condition, row: usize) -> Condition {
        for instant in &mut condition.suns {
            instant.unclouded *= self.before(instant.sun, row);
        }
        Condition { clouds: Some(PatchRow::new(&self.series, row)), ..condition }
    }

    /// Returns the mean transmittance over the sun's disc.
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

crate::parse_by_name!(SkyScale);

#[cfg(test)]
#[path = "own_skies_tests.rs"]
mod tests;
