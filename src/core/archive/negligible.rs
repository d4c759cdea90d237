//! Effects that a build left out because they bring little under some weather: a part of the
//! manifest. In: effects and bounds. Out: a record and its text.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Reason why effects were left out: over the time of a weather file they bring no group of
/// receivers more than the allowed share.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Negligible {
    /// Allowed share of all that is left out, percent of the sum of a group of receivers.
    pub percent: f64,
    /// Name of the weather file.
    pub weather: String,
    /// Largest contribution of each effect to any group, percent of its sum.
    pub bound_percent: BTreeMap<String, f64>,
    /// Keys that this release does not know, kept unchanged.
    #[serde(flatten)]
    pub other: BTreeMap<String, Value>,
}

/// Text for people: each effect that was left out with its largest contribution.
impl fmt::Display for Negligible {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let each = self.bound_percent.iter().map(|(effect, percent)| format!("{effect} (at most {percent} %)"));
        let list = each.collect::<Vec<_>>().join(", ");
        write!(f, "{list} of any group's sum under {}", self.weather)
    }
}
