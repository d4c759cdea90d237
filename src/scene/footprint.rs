//! The footprint of a building. In: what readers of features find. Out: its polygons in plan and
//! the heights of its foot and roof.

use glam::DVec2;

/// Corners of a ring; the first corner is not repeated at the end. Outlines run anticlockwise,
/// holes clockwise.
pub(crate) type PlanRing = Vec<DVec2>;

/// Heights of a building above its base, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StatedHeights {
    pub roof_m: f64,
    /// True if the height of the roof is in scene coordinates, not above the base.
    pub is_roof_absolute: bool,
    /// Height at which the building begins: 0 except for a part that begins higher.
    pub foot_m: f64,
    /// Height of the base in scene coordinates, if the feature states it.
    pub base_m: Option<f64>,
    /// False for a roof on posts.
    pub has_walls: bool,
}

/// A building, or a part of one, in plan.
#[derive(Clone, Debug)]
pub(crate) struct Footprint {
    /// Name that receivers on it bear; unique in its file.
    pub name: String,
    /// Name of the building that this part belongs to; empty for a whole building.
    pub building: String,
    /// True if this is a part of a building, whose outline may be another feature.
    pub is_part: bool,
    /// Number of its feature in the file, from 1.
    pub number: usize,
    /// Polygons in metres, each an outline followed by its holes.
    pub polygons: Vec<Vec<PlanRing>>,
    pub heights: StatedHeights,
    /// Attributes that the file states, as a JSON object.
    pub attributes: String,
}

impl Footprint {
    /// Returns the rings of all polygons.
    pub(crate) fn rings(&self) -> impl Iterator<Item = &PlanRing> {
        self.polygons.iter().flatten()
    }

    /// Returns the south-west and north-east corners of the bounding box.
    pub(crate) fn bounds(&self) -> [DVec2; 2] {
        let none = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        self.rings().flatten().fold(none, |[low, high], corner| [low.min(*corner), high.max(*corner)])
    }
}
