//! A tree as a file states it. In: place, height and width. Out: the rings of its crown's hull.
//!
//! A broadleaved crown is an ellipsoid, one of needles a cone. Hulls are polyhedra of the same
//! volume as these bodies.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

/// Number of sides of a crown, and of rings from its base to its top.
pub(crate) const SIDES: usize = 8;
const RINGS: usize = 6;

/// Leaves of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LeafKind {
    Broad,
    Needle,
}

impl LeafKind {
    /// Returns the name of the material of crowns.
    pub(crate) fn material(self) -> &'static str {
        match self {
            LeafKind::Broad => "broadleaved crown",
            LeafKind::Needle => "needleleaved crown",
        }
    }
}

/// Tree that a file states.
#[derive(Clone, Debug)]
pub(crate) struct TreePoint {
    /// Name of the object; unique in its file.
    pub name: String,
    /// Number of its feature in the file, from 1.
    pub number: usize,
    /// Place of its trunk.
    pub at: DVec2,
    pub crown: Crown,
    pub leaves: LeafKind,
    /// Attributes that the file states, as a JSON object.
    pub attributes: String,
}

/// Crown of a tree, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crown {
    /// Heights of its top and its base above the ground.
    pub top_m: f64,
    pub base_m: f64,
    /// Largest width.
    pub width_m: f64,
}

impl Crown {
    /// Returns the radius at a height from 0 (base) to 1 (top).
    fn radius(self, leaves: LeafKind, height: f64) -> f64 {
        let share = match leaves {
            LeafKind::Broad => (1.0 - (2.0 * height - 1.0).powi(2)).max(0.0).sqrt(),
            LeafKind::Needle => 1.0 - height,
        };
        0.5 * self.width_m * share
    }

    /// Returns the volume of the body, m3.
    fn volume(self, leaves: LeafKind) -> f64 {
        let shape = if leaves == LeafKind::Broad { 6.0 } else { 12.0 };
        PI / shape * self.width_m.powi(2) * (self.top_m - self.base_m)
    }

    /// Returns the rings of the hull, from the base upwards, each a radius and a height above the
    /// ground; a ring of radius 0 is one point.
    pub(crate) fn rings(self, leaves: LeafKind) -> Vec<(f64, f64)> {
        let height = |share: f64| self.base_m + share * (self.top_m - self.base_m);
        let rings: Vec<(f64, f64)> = match leaves {
            // Equal steps of the angle from pole to pole.
            LeafKind::Broad => (0..=RINGS)
                .map(|i| 0.5 - 0.5 * (PI * i as f64 / RINGS as f64).cos())
                .map(|share| (self.radius(leaves, share), height(share)))
                .collect(),
            LeafKind::Needle => vec![(0.0, self.base_m), (self.radius(leaves, 0.0), self.base_m), (0.0, self.top_m)],
        };
        let of_polygon = 0.5 * SIDES as f64 * (TAU / SIDES as f64).sin();
        let frustum = |[(a, low), (b, high)]: &[(f64, f64); 2]| (high - low) / 3.0 * (a * a + a * b + b * b);
        let inside: f64 = of_polygon * rings.array_windows().map(frustum).sum::<f64>();
        let wider = (self.volume(leaves) / inside).sqrt();
        rings.into_iter().map(|(radius, height)| (if radius > 1e-9 { radius * wider } else { 0.0 }, height)).collect()
    }
}
