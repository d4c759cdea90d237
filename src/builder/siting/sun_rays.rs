//! Rays of one receiver towards the sun. In: its place and normal, directions. Out: whether it sees the sky there.

use glam::DVec3;

use super::Siting;
use crate::trace::receiver::Viewpoint;
use crate::trace::{Ray, Tracer};

/// A receiver in a scene.
pub struct SunRays<'a> {
    tracer: &'a Tracer,
    origin: [f32; 3],
    normal: DVec3,
}

impl Siting<'_> {
    /// The rays of a receiver, which start where those of a build do; `position` in input coordinates.
    pub fn sun_rays(&self, position: DVec3, normal: DVec3) -> SunRays<'_> {
        let tracer = &self.prepared.tracer;
        SunRays { tracer, origin: Viewpoint { position, normal }.origin(tracer), normal }
    }
}

impl SunRays<'_> {
    /// Whether nothing stands in each of some directions; what lies behind the surface is not seen.
    pub fn sees(&self, directions: &[DVec3]) -> Vec<bool> {
        let ray = |direction: &DVec3| Ray { origin: self.origin, direction: direction.as_vec3().to_array() };
        let rays: Vec<Ray> = directions.iter().map(ray).collect();
        let met = self.tracer.occluded_many(&rays);
        directions.iter().zip(met).map(|(direction, met)| !met && self.normal.dot(*direction) > 0.0).collect()
    }
}
