//! Viewpoints: places on surfaces that face some way. In: a position, a normal. Out: the origin of
//! rays, the seed of their jitter.

use glam::DVec3;

use crate::trace::kernel::rays::Tracer;
use crate::trace::probe::lifted;
use heliotile_core::site::cells::receiver_seed;

/// Position and normal of a receiver.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// Position in input coordinates, metres.
    pub position: DVec3,
    /// Unit normal.
    pub normal: DVec3,
}

impl Viewpoint {
    /// Returns the origin of the rays, relative to the origin of the scene.
    pub(crate) fn origin(&self, tracer: &Tracer) -> [f32; 3] {
        lifted(self.position, self.normal, tracer)
    }

    /// Returns the seed of the jitter of this viewpoint's hit rays.
    pub fn seed(&self) -> u64 {
        receiver_seed(self.position, self.normal)
    }
}
