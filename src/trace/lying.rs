//! Whether a receiver that was put on a surface gets light at all. In: a point some millimetres off its surface, the scene. Out: free,
//! covered by what lies upon the surface, or inside a solid or below the terrain.

use glam::DVec3;

use super::rays::{Ray, Tracer};
use super::receiver::Viewpoint;

/// How a receiver lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lying {
    Free,
    /// Another surface lies between it and its own, or as close in front of it.
    Covered,
    /// In a neighbour's walls or below the terrain.
    Inside,
}

/// Side of the hemisphere of rays that look for sky.
const SIDE: usize = 8;

/// Looks where a receiver lies that is `offset_m` off its surface.
pub fn lying(view: &Viewpoint, offset_m: f64, tracer: &Tracer) -> Lying {
    let first = |direction: DVec3| {
        let ray = Ray { origin: view.position.as_vec3().into(), direction: direction.as_vec3().into() };
        tracer.closest(ray).map_or(f64::INFINITY, |hit| f64::from(hit.t))
    };
    let rounding = 2.0 * tracer.offset_m(view.position);
    if first(-view.normal) < offset_m - rounding || first(view.normal) < offset_m {
        return Lying::Covered;
    }
    let origin = view.origin(tracer);
    let up: Vec<Ray> = (0..SIDE * SIDE)
        .map(view.hit_directions(SIDE))
        .filter(|direction| direction.z > 0.0)
        .map(|direction| Ray { origin, direction: direction.as_vec3().into() })
        .collect();
    let blind = tracer.occluded_many(&up).into_iter().all(|met| met);
    if blind && view.enclosed(tracer) { Lying::Inside } else { Lying::Free }
}
