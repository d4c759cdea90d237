//! Form factors from the rays of a hemisphere map. In: a tracer, a viewpoint that lies on no
//! surface, and rays about its normal. Out: the sum of the weights of rays that hit anything.

use glam::DVec3;

use crate::study::mapping::MappedRay;
use crate::trace::kernel::rays::{Ray, Tracer};
use crate::trace::receiver::Viewpoint;
use heliotile_core::hemisphere::Frame;

impl Viewpoint {
    /// Returns the form factor of everything in the scene.
    pub fn form_factor(&self, rays: &[MappedRay], tracer: &Tracer) -> f64 {
        let origin = tracer.grid().relative(self.position).as_vec3().to_array();
        let frame = Frame::of(self.normal);
        let cast = |direction: DVec3| Ray { origin, direction: frame.to_world(direction).as_vec3().to_array() };
        let cast: Vec<Ray> = rays.iter().map(|ray| cast(ray.direction)).collect();
        let met = tracer.occluded_many(&cast).into_iter();
        rays.iter().zip(met).filter(|(_, met)| *met).map(|(ray, _)| ray.weight).sum()
    }
}
