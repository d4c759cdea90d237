//! A feature, the same for every format. In: the records that readers find. Out: polygons in the
//! coordinates of the file, and attributes.

use glam::DVec3;
use heliotile_core::error::Result;
use serde_json::{Map, Value};

/// A polygon: its outline, followed by its holes. A ring may be closed by a repeated corner. x is
/// east or longitude.
pub(super) type FeaturePolygon = Vec<Vec<DVec3>>;

/// A record of a file of features.
#[derive(Clone, Debug, Default)]
pub(super) struct Feature {
    /// Identifier that the format has apart from the attributes.
    pub id: Option<String>,
    pub attributes: Map<String, Value>,
    pub polygons: Vec<FeaturePolygon>,
    /// True if the polygons are the faces of a body (a multipatch, a polyhedral surface), whatever
    /// their slope.
    pub is_body: bool,
    /// True if the feature has points or lines.
    pub has_others: bool,
    /// Reason why the geometry cannot be read, if it cannot.
    pub unreadable: Option<String>,
}

/// A function that takes features one by one.
pub(super) type TakeFeature<'a> = dyn FnMut(Feature) -> Result<()> + 'a;
