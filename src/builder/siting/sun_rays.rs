//! Rays of one receiver towards the sun. In: its position and normal, directions. Out: for each
//! direction true if the receiver sees the sky there.

use glam::DVec3;

use super::Siting;
use crate::trace::viewpoint::Viewpoint;
use crate::trace::{Ray, Tracer};

/// Receiver in a scene.
pub struct SunRays<'a> {
    tracer: &'a Tracer,
    origin: [f32; 3],
    normal: DVec3,
}

impl Siting<'_> {
    /// Returns the rays of a receiver, which start where those of a build do. `position` is in
    /// input coordinates.
    pub fn sun_rays(&self, position: DVec3, normal: DVec3) -> SunRays<'_> {
        let tracer = &self.prepared.tracer;
        SunRays { tracer, origin: Viewpoint { position, normal }.origin(tracer), normal }
    }
}

impl SunRays<'_> {
    /// Returns for each direction true if the receiver sees the sky there. Directions behind its
    /// surface give false.
    pub fn sees(&self, directions: &[DVec3]) -> Vec<bool> {
        let ray = |direction: &DVec3| Ray { origin: self.origin, direction: direction.as_vec3().to_array() };
        let rays: Vec<Ray> = directions.iter().map(ray).collect();
        let met = self.tracer.occluded_many(&rays);
        directions.iter().zip(met).map(|(direction, met)| !met && self.normal.dot(*direction) > 0.0).collect()
    }
}
