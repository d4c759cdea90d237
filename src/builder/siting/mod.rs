//! Siting: queries about places in a scene before anything is traced from them. In: a prepared
//! scene, points. Out: the surface below a point, a test whether light can reach it, and its
//! horizon. Rays only; no textures, cells or archives.

mod enclosed;
mod horizon;
mod mirror_rays;
#[cfg(test)]
mod siting_tests;
mod sun_rays;

use glam::DVec3;

use crate::pipeline::PreparedScene;
use heliotile_core::site::material::Class;

pub use crate::pipeline::Below;
pub use enclosed::Enclosed;
pub use horizon::HorizonLine;
pub use mirror_rays::{MirrorObserver, MirrorRays};
pub use sun_rays::SunRays;

/// Scene for queries about places.
pub struct Siting<'a> {
    prepared: &'a PreparedScene<'a>,
}

impl<'a> Siting<'a> {
    /// Creates the queries of a prepared scene. Leaves and screens are ignored.
    pub fn new(prepared: &'a PreparedScene<'a>) -> Self {
        Siting { prepared }
    }

    /// Returns the highest surface at a place in plan; `None` if there is none.
    pub fn top(&self, x: f64, y: f64) -> Option<Below> {
        self.prepared.top(x, y)
    }

    /// Returns the highest ground at or below a point, whatever lies between them; `None` if there
    /// is none.
    pub fn ground_below(&self, point: DVec3) -> Option<Below> {
        self.prepared.below(point, |class| class == Class::Ground)
    }
}
