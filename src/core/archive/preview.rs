//! What an archive of a changed scene kept although the change alters it a little: a part of the manifest.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The bound of a preview.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Preview {
    /// Most by which the light of any receiver is off: under a uniform sky, or in the mean over suns everywhere in the sky, percent of what open
    /// ground gets.
    pub bound_percent: f64,
    /// Receivers whose reflected light is that of the scene before it was changed.
    pub kept_receivers: u64,
    /// Keys that this release does not know, kept as they are.
    #[serde(flatten)]
    pub other: BTreeMap<String, Value>,
}

/// As people read it.
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
