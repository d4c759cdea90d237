//! Errors that a halo makes, as plans state them. In: numbers of a comparison. Out: a sentence.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use heliotile_core::text::counted;

/// Errors that a halo makes, compared with a halo three times as wide: RMSE over receivers and over
/// suns from all sides, in percent of the mean total.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Seams {
    /// Receivers that were built twice.
    pub receivers: usize,
    /// Number of parts that these receivers lie in.
    pub parts: usize,
    /// RMSE of the total, percent.
    pub rmse_percent: f64,
    /// Upper end of the 95 % interval of `rmse_percent`, by resampling these receivers and these
    /// parts (Efron 1979). A few receivers carry most of the error, and a sample may have none of
    /// them.
    pub at_most_percent: f64,
    /// Mean error of the totals, percent: above 0 if they are too large.
    pub bias_percent: f64,
    /// RMSE of each component, percent, by column name.
    pub components_percent: BTreeMap<String, f64>,
}

impl Seams {
    /// Describes the errors in the words of `partition` and `info`.
    pub fn words(&self) -> String {
        format!(
            "a halo three times as wide changes the light of {} in {} by {} % RMSE of the mean total (95 %: at most {} %), {:+} % on average",
            counted(self.receivers as u64, "receiver"),
            counted(self.parts as u64, "part"),
            self.rmse_percent,
            self.at_most_percent,
            self.bias_percent
        )
    }
}
