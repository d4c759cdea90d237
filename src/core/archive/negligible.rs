//! What a build left out because it brings little under some weather: a part of the manifest.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Why effects were left out: over the time of a weather file they bring no group of receivers more than was allowed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Negligible {
    /// What was allowed, of all that is left out, percent of the sum of a group of receivers.
    pub percent: f64,
    /// The weather file's name.
    pub weather: String,
    /// The most that each effect that was left out brings any group, percent of its sum.
    pub bound_percent: BTreeMap<String, f64>,
    /// Keys that this release does not know, kept as they are.
    #[serde(flatten)]
    pub other: BTreeMap<String, Value>,
}

/// What was left out and what it brings at most, as people read it.
impl fmt::Display for Negligible {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let each = self.bound_percent.iter().map(|(effect, percent)| format!("{effect} (at most {percent} %)"));
        let list = each.collect::<Vec<_>>().join(", ");
        write!(f, "{list} of any group's sum under {}", self.weather)
    }
}
