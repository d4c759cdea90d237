//! Estimate that a build made of its own error: a part of the manifest. In: numbers of a build.
//! Out: the error to expect of other hours.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Errors of the hourly total and its parts, from a sample of the receivers that was built with
/// finer settings, too. RMSE over receivers and conditions, in percent of the mean total.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// Target that the user gave, percent.
    pub target_percent: f64,
    /// Expectation when the settings were chosen, percent.
    pub predicted_percent: f64,
    /// RMSE that was found, percent; it includes the error of the finer settings.
    pub rmse_percent: f64,
    /// Mean error of the totals, percent of their mean: above 0 if they come out too large.
    pub bias_percent: f64,
    /// RMSE of the means over all conditions, percent.
    pub yearly_percent: f64,
    /// RMSE of each component, in percent of the mean total, by its column's name.
    pub components_percent: BTreeMap<String, f64>,
    /// Number of receivers that the figures rest on.
    pub sample: u64,
    /// Number of conditions.
    pub conditions: u64,
    /// Source of the conditions: the name of a weather file, or `suns from all sides`.
    pub weather: String,
    /// Mean total of the sample, W/m2.
    pub mean_w_m2: f64,
    /// RMSE of groups of the sample by the sky that they see, from little to much.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<GroupError>,
    /// RMSE in hours when the sun lights the surfaces that receivers see and not the receivers: `no
    /// direct sun`, and `mostly reflected`. Empty where there are hardly any such hours.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hours: Vec<HoursError>,
    /// RMSE of receivers of the sample by tiles; a tile without a value is like the nearest one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tiles: Vec<TileError>,
    /// Keys that this release does not know, kept unchanged.
    #[serde(flatten)]
    pub other: BTreeMap<String, Value>,
}

/// RMSE of the totals of receivers of the sample that see about as much of the sky.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GroupError {
    /// Smallest and largest share of their hemispheres that is sky, weighted by the cosine.
    pub sky_view: [f64; 2],
    /// Receivers of the sample in this group.
    pub receivers: u32,
    /// Mean of their totals, W/m2.
    pub mean_w_m2: f64,
    /// RMSE, W/m2.
    pub rmse_w_m2: f64,
}

/// RMSE of the totals of the sample in hours of one kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HoursError {
    /// Name of the kind of hours. `no direct sun`: the sun lights surfaces that a receiver sees and
    /// that give it more than 1 % of its total by way of this, while straight or by mirrors the sun
    /// gives less than 1 %. `mostly reflected`: of these hours, those in which more than half of
    /// the total comes from matt surfaces.
    pub hours: String,
    /// Share of these hours in all hours of all receivers of the sample.
    pub share_percent: f64,
    /// Receivers of the sample that have such hours.
    pub receivers: u32,
    /// Mean of their totals in these hours, W/m2.
    pub mean_w_m2: f64,
    /// RMSE of the totals, W/m2.
    pub rmse_w_m2: f64,
    /// Mean of the light that matt surfaces reflect in these hours, W/m2.
    pub reflected_mean_w_m2: f64,
    /// RMSE of the light that matt surfaces reflect, W/m2.
    pub reflected_w_m2: f64,
}

/// RMSE of the receivers of the sample that lie in one tile, W/m2.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TileError {
    /// Number of the tile in the archive.
    pub tile: u32,
    /// Receivers of the sample in this tile.
    pub receivers: u32,
    /// RMSE of the six components and the total, in the order of results.
    pub rmse_w_m2: [f64; 7],
}

impl Accuracy {
    /// Returns the RMSE of the totals, W/m2.
    pub fn rmse_w_m2(&self) -> f64 {
        self.rmse_percent / 100.0 * self.mean_w_m2
    }

    /// Returns the RMSE of totals to expect of other hours, W/m2. It assumes that in each kind of
    /// hours the percentages of the light from matt surfaces and of the other light stay. `mix`
    /// gives the share of each kind in the other hours; each kind holds the next. `mean_w_m2` is
    /// the mean of all.
    pub fn expected_w_m2(&self, mix: &[HoursMix], mean_w_m2: f64) -> f64 {
        if self.hours.is_empty() {
            return self.rmse_percent / 100.0 * mean_w_m2;
        }
        // All hours, then each kind that is stated, in the archive and in the mix.
        let mut stated = vec![Portion::new(1.0, [self.mean_w_m2, self.rmse_w_m2()], [0.0; 2])];
        let mut there = vec![Portion::new(1.0, [mean_w_m2, 0.0], [0.0; 2])];
        for hours in &self.hours {
            if let Some(mix) = mix.iter().find(|mix| mix.hours == hours.hours) {
                let matt = [hours.reflected_mean_w_m2, hours.reflected_w_m2];
                stated.push(Portion::new(hours.share_percent / 100.0, [hours.mean_w_m2, hours.rmse_w_m2], matt));
                there.push(Portion::new(mix.share, [mix.mean_w_m2, 0.0], [mix.reflected_mean_w_m2, 0.0]));
            }
        }
        let pairs = alone(&stated).into_iter().zip(alone(&there));
        pairs.map(|(stated, there)| stated.square_of(&there)).sum::<f64>().sqrt()
    }

    /// Returns the estimate without errors by tile, for an archive with other tiles.
    #[must_use]
    pub fn without_tiles(self) -> Self {
        Accuracy { tiles: Vec::new(), ..self }
    }
}

impl HoursError {
    /// Returns the RMSE of the totals in percent of their mean; 0 in the dark.
    pub fn rmse_percent(&self) -> f64 {
        if self.mean_w_m2 > 0.0 { self.rmse_w_m2 / self.mean_w_m2 * 100.0 } else { 0.0 }
    }

    /// Returns the RMSE of the light that matt surfaces reflect in percent of its mean; 0 in the
    /// dark.
    pub fn reflected_percent(&self) -> f64 {
        if self.reflected_mean_w_m2 > 0.0 { self.reflected_w_m2 / self.reflected_mean_w_m2 * 100.0 } else { 0.0 }
    }
}

/// Share of one kind of hours in some hours, with its means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoursMix<'a> {
    /// Name of the kind, as in [`HoursError::hours`].
    pub hours: &'a str,
    /// Share of all hours.
    pub share: f64,
    /// Mean of their totals, W/m2.
    pub mean_w_m2: f64,
    /// Mean of the light that matt surfaces reflect in them, W/m2.
    pub reflected_mean_w_m2: f64,
}

/// Contribution of some hours to a mean over all.
#[derive(Clone, Copy, Debug, Default)]
struct Portion {
    /// Share of all hours.
    share: f64,
    total: Part,
    /// Light that matt surfaces reflect; zero where that is not known.
    matt: Part,
}

/// A part of the light: its sum and its square error.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    /// Share of the hours times mean, W/m2.
    light: f64,
    /// Share of the hours times mean square error, (W/m2)^2.
    square: f64,
}

impl Part {
    fn without(self, other: Part) -> Self {
        Part { light: (self.light - other.light).max(0.0), square: (self.square - other.square).max(0.0) }
    }
}

/// Returns each portion without the next one, which it holds.
fn alone(portions: &[Portion]) -> Vec<Portion> {
    let next = portions.iter().skip(1).map(Some).chain([None]);
    portions.iter().zip(next).map(|(portion, next)| portion.without(next)).collect()
}

impl Portion {
    /// Returns a portion of mean and RMSE, W/m2, of the total and of the reflected light.
    fn new(share: f64, total: [f64; 2], matt: [f64; 2]) -> Self {
        let part = |[mean, rmse]: [f64; 2]| Part { light: share * mean, square: share * rmse * rmse };
        Portion { share, total: part(total), matt: part(matt) }
    }

    /// Returns the portion without the hours of an inner kind that it holds.
    fn without(self, inner: Option<&Portion>) -> Self {
        let inner = inner.copied().unwrap_or_default();
        Portion {
            share: (self.share - inner.share).max(0.0),
            total: self.total.without(inner.total),
            matt: self.matt.without(inner.matt),
        }
    }

    /// Returns the mean square error of other hours with equal percentages of error, times their
    /// share.
    fn square_of(&self, there: &Portion) -> f64 {
        let scaled = |part: Part, light: f64| match self.share * part.light > 0.0 && there.share > 0.0 {
            // (RMSE / mean)^2 as stated, times the mean there, squared.
            true => part.square * self.share / part.light.powi(2) * light.powi(2) / there.share,
            false => 0.0,
        };
        let other = self.total.without(self.matt);
        scaled(self.matt, there.matt.light) + scaled(other, there.total.without(there.matt).light)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An archive states 1 % of 200 W/m2, and for the half of its hours without direct sun 1.5 W/m2
    /// of 75, of which 1.2 W/m2 of 60 are reflected. For the same hours 2 W/m2 are expected. For
    /// hours without direct sun alone, in which 150 W/m2 are reflected and there is no sky, 3 W/m2
    /// are expected, 2 % as stated. An archive without kinds of hours expects 1 % of any mean.
    #[test]
    fn a_stated_error_scales_to_other_hours() {
        let stated = Accuracy {
            rmse_percent: 1.0,
            mean_w_m2: 200.0,
            hours: vec![HoursError {
                hours: "no direct sun".into(),
                share_percent: 50.0,
                mean_w_m2: 75.0,
                rmse_w_m2: 1.5,
                reflected_mean_w_m2: 60.0,
                reflected_w_m2: 1.2,
                ..HoursError::default()
            }],
            ..Accuracy::default()
        };
        let mix = |share: f64, mean_w_m2: f64, reflected_mean_w_m2: f64| {
            [HoursMix { hours: "no direct sun", share, mean_w_m2, reflected_mean_w_m2 }]
        };
        assert!((stated.expected_w_m2(&mix(0.5, 75.0, 60.0), 200.0) - 2.0).abs() < 1e-12);
        assert!((stated.expected_w_m2(&mix(1.0, 150.0, 150.0), 150.0) - 3.0).abs() < 1e-12);
        let bare = Accuracy { hours: Vec::new(), ..stated };
        assert!((bare.expected_w_m2(&mix(1.0, 150.0, 150.0), 150.0) - 1.5).abs() < 1e-12);
    }
}
