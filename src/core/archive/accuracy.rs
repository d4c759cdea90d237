//! What a build estimated of its own error: a part of the manifest.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Errors of the hourly total and its parts, from a sample of the receivers built with finer settings, too. RMSE over receivers and
/// conditions, in percent of the mean total.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Accuracy {
    /// What was asked for.
    pub target_percent: f64,
    /// What was expected when the settings were chosen.
    pub predicted_percent: f64,
    /// What was found, the finer settings' own error included.
    pub rmse_percent: f64,
    /// Mean error of the totals, percent of their mean: above 0 if they come out too large.
    pub bias_percent: f64,
    /// Of the means over all conditions.
    pub yearly_percent: f64,
    /// RMSE of each component, in percent of the mean total, by its column's name.
    pub components_percent: BTreeMap<String, f64>,
    /// Number of receivers that the figures rest on.
    pub sample: u64,
    /// Number of conditions.
    pub conditions: u64,
    /// Where they come from: the name of a weather file, or `suns from all sides`.
    pub weather: String,
    /// Mean total of the sample, W/m2.
    pub mean_w_m2: f64,
    /// RMSE of groups of the sample by the sky that they see, from little to much.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<GroupError>,
    /// RMSE of receivers of the sample by tiles; tiles between two are like the nearest.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tiles: Vec<TileError>,
    /// Keys that this release does not know, kept as they are.
    #[serde(flatten)]
    pub other: BTreeMap<String, Value>,
}

/// RMSE of the totals of receivers of the sample that see about as much of the sky.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct GroupError {
    /// Smallest and largest share of their hemispheres that is sky, weighted by the cosine.
    pub sky_view: [f64; 2],
    /// Receivers of the sample in this group.
    pub receivers: u32,
    /// Mean of their totals, W/m2.
    pub mean_w_m2: f64,
    /// W/m2.
    pub rmse_w_m2: f64,
}

/// RMSE of the receivers of the sample that lie in one tile, W/m2.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct TileError {
    /// Number of the tile in the archive.
    pub tile: u32,
    /// Receivers of the sample in this tile.
    pub receivers: u32,
    /// The six components and the total, in the order of results.
    pub rmse_w_m2: [f64; 7],
}

impl Accuracy {
    /// For other tiles.
    #[must_use]
    pub fn without_tiles(self) -> Self {
        Accuracy { tiles: Vec::new(), ..self }
    }
}
