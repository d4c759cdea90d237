//! A feature as every format has it. In: what readers find. Out: polygons in the coordinates of the file, and attributes.

use glam::DVec3;
use heliotile_core::error::Result;
use serde_json::{Map, Value};

/// A polygon: its outline, then its holes; rings may be closed by a repeated corner. x is east or longitude.
pub(super) type FeaturePolygon = Vec<Vec<DVec3>>;

/// A row of a table of features.
#[derive(Clone, Debug, Default)]
pub(super) struct Feature {
    /// What the format calls it, apart from its attributes.
    pub id: Option<String>,
    pub attributes: Map<String, Value>,
    pub polygons: Vec<FeaturePolygon>,
    /// Whether the polygons are the faces of a body (a multipatch, a polyhedral surface), whatever their slope.
    pub is_body: bool,
    /// Whether it has points or lines.
    pub has_others: bool,
}

/// What takes features one by one.
pub(super) type TakeFeature<'a> = dyn FnMut(Feature) -> Result<()> + 'a;
