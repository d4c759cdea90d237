//! Whether a receiver that was put on a surface gets light at all. In: a point some millimetres off its surface, the scene. Out: free,
//! covered by what lies upon the surface, or inside a solid or below the terrain.

use glam::DVec3;

use crate::trace::hidden::{is_reached, meets_inside};
use crate::trace::kernel::rays::{Ray, Tracer};
use crate::trace::receiver::Viewpoint;
use heliotile_scene::mesh::Mesh;

/// How a receiver that was put on a surface lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lying {
    /// Nothing covers it: light can arrive.
    Free,
    /// Another surface lies between it and its own, or as close in front of it.
    Covered,
    /// In a neighbour's walls or below the terrain.
    Inside,
}

/// Side of the hemisphere of rays that look for sky.
const SIDE: usize = 8;

/// A receiver that sees at most this share of sky, ...
const NEARLY_BLIND: f64 = 0.1;

/// ... and for the rest at least this share of inner sides of solids or terrain, is behind them. Crossings alone would not tell in a cellar:
/// with the terrain above it they are even; nor would darkness: flat rays get out below the edge of the terrain.
const INNER_SIDES: f64 = 0.9;

/// Looks where a receiver lies that is `offset_m` off its surface.
pub fn lying(view: &Viewpoint, offset_m: f64, mesh: &Mesh, tracer: &Tracer) -> Lying {
    let first = |direction: DVec3| {
        let ray = Ray {
            origin: tracer.grid().relative(view.position).as_vec3().into(),
            direction: direction.as_vec3().into(),
        };
        tracer.closest(ray).map_or(f64::INFINITY, |hit| f64::from(hit.t))
    };
    let rounding = 2.0 * tracer.grid().offset_m(view.position);
    if first(-view.normal) < offset_m - rounding || first(view.normal) < offset_m {
        return Lying::Covered;
    }
    let origin = view.origin(tracer);
    let up: Vec<DVec3> =
        (0..SIDE * SIDE).map(view.hit_directions(SIDE)).filter(|direction| direction.z > 0.0).collect();
    let rays: Vec<Ray> = up.iter().map(|direction| Ray { origin, direction: direction.as_vec3().into() }).collect();
    let hits = tracer.closest_many(&rays);
    let met = hits.iter().flatten().count() as f64;
    if met < (1.0 - NEARLY_BLIND) * rays.len() as f64 {
        return Lying::Free;
    }
    let met_inside =
        |(ray, hit): (&Ray, &Option<_>)| hit.as_ref().is_some_and(|hit| meets_inside(ray, hit, mesh, tracer));
    let inner = rays.iter().zip(&hits).filter(|pair| met_inside(*pair)).count() as f64;
    let behind = met > 0.0 && inner >= INNER_SIDES * met;
    let dark = hits.iter().all(Option::is_some);
    if behind || dark && is_enclosed(view, mesh, tracer) { Lying::Inside } else { Lying::Free }
}

/// Whether a receiver that sees no sky lies below terrain, inside a solid, or where no light comes to.
pub fn is_enclosed(view: &Viewpoint, mesh: &Mesh, tracer: &Tracer) -> bool {
    !is_reached(view.origin(tracer), view.normal, view.seed(), mesh, tracer) || view.crosses_out(mesh, tracer)
}
