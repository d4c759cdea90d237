//! Errors that a halo makes, as plans state them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use heliotile_core::text::counted;

/// Errors that a halo makes, beside three times as wide a one: RMSE over receivers and suns from all sides, in percent of the mean total.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Seams {
    /// Receivers that were built twice.
    pub receivers: usize,
    /// Parts that they lie in.
    pub parts: usize,
    /// Of the total.
    pub rmse_percent: f64,
    /// Upper end of the interval of 95 % of that, by other draws of these receivers and of these parts (Efron 1979): a few receivers
    /// carry most of the error, and a sample may have none of them.
    pub at_most_percent: f64,
    /// Mean error of the totals: above 0 if they come out too large.
    pub bias_percent: f64,
    /// By column name.
    pub components_percent: BTreeMap<String, f64>,
}

impl Seams {
    /// As `partition` and `info` say it.
    pub fn words(&self) -> String {
        format!(
            "three times the halo changes the light of {} in {} by {} % RMSE of the mean total (95 %: at most {} %), {:+} % on average",
            counted(self.receivers as u64, "receiver"),
            counted(self.parts as u64, "part"),
            self.rmse_percent,
            self.at_most_percent,
            self.bias_percent
        )
    }
}
