//! A feature, the same for every format. In: the records that readers find. Out: polygons in the
//! coordinates of the file, and attributes.

use std::path::Path;

use glam::DVec3;
use heliotile_core::error::Result;
use serde_json::{Map, Value};

use heliotile_files::input::budget::WorkBudget;

/// Memory that a feature takes besides its corners and texts, and that a corner and an attribute
/// take, bytes.
const FEATURE_BYTES: u64 = 256;
const CORNER_BYTES: u64 = 24;
const ATTRIBUTE_BYTES: u64 = 64;

/// A polygon: its outline, followed by its holes. A ring may be closed by a repeated corner. x is
/// east or longitude.
pub(in crate::formats) type FeaturePolygon = Vec<Vec<DVec3>>;

/// A record of a file of features.
#[derive(Clone, Debug, Default)]
pub(in crate::formats) struct Feature {
    /// Identifier that the format has apart from the attributes.
    pub id: Option<String>,
    pub attributes: Map<String, Value>,
    pub polygons: Vec<FeaturePolygon>,
    pub points: Vec<DVec3>,
    /// True if the polygons are the faces of a body (a multipatch, a polyhedral surface), whatever
    /// their slope.
    pub is_body: bool,
    /// True if the feature has points or lines.
    pub has_others: bool,
    /// Reason why the geometry cannot be read, if it cannot.
    pub unreadable: Option<String>,
}

impl Feature {
    /// Spends the memory that the feature takes: a dictionary or a damaged table may repeat it any
    /// number of times.
    pub(super) fn charge(&self, budget: &mut WorkBudget, file: &Path) -> Result<()> {
        let corners = self.polygons.iter().flatten().map(|ring| ring.len() as u64).sum::<u64>();
        let texts = self.attributes.values().filter_map(Value::as_str).map(|text| text.len() as u64).sum::<u64>();
        let attributes = self.attributes.len() as u64 * ATTRIBUTE_BYTES;
        budget.spend(1, FEATURE_BYTES + corners * CORNER_BYTES + attributes + texts, "features", file)
    }
}

/// A function that takes features one by one.
pub(in crate::formats) type TakeFeature<'a> = dyn FnMut(Feature) -> Result<()> + 'a;
