//! The footprint of a building. In: what readers of features find. Out: its polygons in plan, with the heights between which it stands.

use glam::DVec2;

/// Corners of a ring, which is not closed by a repeated one: outlines run anticlockwise, holes clockwise.
pub(crate) type PlanRing = Vec<DVec2>;

/// Heights of a building above its base, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StatedHeights {
    pub roof_m: f64,
    /// 0 unless it is a part that begins higher.
    pub foot_m: f64,
    /// Height of the base in the scene, if the feature states it.
    pub base_m: Option<f64>,
}

/// A building, or a part of one, in plan.
#[derive(Clone, Debug)]
pub(crate) struct Footprint {
    /// What receivers on it are named after; of its file no other has the name.
    pub name: String,
    /// The building that it is a part of; empty for a whole one.
    pub building: String,
    /// Whether it is a part of a building which other features may be the outline of.
    pub is_part: bool,
    /// 1-based number of its feature in the file.
    pub number: usize,
    /// Polygons, each an outline and its holes; metres.
    pub polygons: Vec<Vec<PlanRing>>,
    pub heights: StatedHeights,
    /// What the file states of it, a JSON object.
    pub attributes: String,
}

impl Footprint {
    /// All rings.
    pub(crate) fn rings(&self) -> impl Iterator<Item = &PlanRing> {
        self.polygons.iter().flatten()
    }

    /// South-west and north-east corner of its box.
    pub(crate) fn bounds(&self) -> [DVec2; 2] {
        let none = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        self.rings().flatten().fold(none, |[low, high], corner| [low.min(*corner), high.max(*corner)])
    }
}
