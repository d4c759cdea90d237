//! Preview: parts that an archive of a changed scene kept although the change alters them a little.
//! A part of the manifest. In: a bound. Out: a record and its text.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The bound of a preview.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Preview {
    /// Largest error of the light of any receiver, percent of the light on open ground: under a
    /// uniform sky, or in the mean over suns everywhere in the sky.
    pub bound_percent: f64,
    /// Number of receivers whose reflected light is that of the scene before the change.
    pub kept_receivers: u64,
    /// Keys that this release does not know, kept unchanged.
    #[serde(flatten)]
    pub other: BTreeMap<String, Value>,
}

/// Text for people.
impl fmt::Display for Preview {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Preview { bound_percent, kept_receivers, .. } = self;
        write!(
            f,
            "light is off by at most {bound_percent} % of that on open ground, in the mean over the sky; reflected light of {kept_receivers} \
             receivers is from before the change"
        )
    }
}
