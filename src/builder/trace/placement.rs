//! Placement of receivers that were put on a surface. In: a point some millimetres off its surface,
//! the scene. Out: free, covered by another surface, or inside a solid or below the terrain.

use glam::DVec3;

use crate::trace::hidden::{is_reached, meets_inside};
use crate::trace::kernel::ray::Ray;
use crate::trace::kernel::rays::Tracer;
use crate::trace::viewpoint::Viewpoint;
use heliotile_scene::mesh::Mesh;

/// Placement of a receiver on a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// Nothing covers the receiver: light can arrive.
    Free,
    /// Another surface lies between the receiver and its own surface, or as close in front of it.
    Blocked,
    /// The receiver lies in a neighbour's walls or below the terrain.
    Inside,
}

/// Side of the texture of rays that look for sky.
const SIDE: usize = 8;

/// Share of sky at or below which a receiver may be inside.
const NEARLY_BLIND: f64 = 0.1;

/// Share of inner sides of solids or terrain among the hits of a nearly blind receiver from which
/// on it is inside. Crossings alone would not tell in a cellar, where the terrain above makes their
/// number even. Darkness alone would not tell either, because flat rays get out below the edge of
/// the terrain.
const INNER_SIDES: f64 = 0.9;

/// Returns the placement of a receiver that is `offset_m` off its surface.
pub fn placement_of(view: &Viewpoint, offset_m: f64, mesh: &Mesh, tracer: &Tracer) -> Placement {
    let first = |direction: DVec3| {
        let ray = Ray {
            origin: tracer.grid().relative(view.position).as_vec3().into(),
            direction: direction.as_vec3().into(),
        };
        tracer.closest(ray).map_or(f64::INFINITY, |hit| f64::from(hit.t))
    };
    let rounding = 2.0 * tracer.grid().offset_m(view.position);
    if first(-view.normal) < offset_m - rounding || first(view.normal) < offset_m {
        return Placement::Blocked;
    }
    let origin = view.origin(tracer);
    // Only rays that go up can see sky.
    let up: Vec<DVec3> =
        (0..SIDE * SIDE).map(view.hit_directions(SIDE)).filter(|direction| direction.z > 0.0).collect();
    let rays: Vec<Ray> = up.iter().map(|direction| Ray { origin, direction: direction.as_vec3().into() }).collect();
    let hits = tracer.closest_many(&rays);
    let met = hits.iter().flatten().count() as f64;
    if met < (1.0 - NEARLY_BLIND) * rays.len() as f64 {
        return Placement::Free;
    }
    let met_inside =
        |(ray, hit): (&Ray, &Option<_>)| hit.as_ref().is_some_and(|hit| meets_inside(ray, hit, mesh, tracer));
    let inner = rays.iter().zip(&hits).filter(|pair| met_inside(*pair)).count() as f64;
    let behind = met > 0.0 && inner >= INNER_SIDES * met;
    let dark = hits.iter().all(Option::is_some);
    if behind || dark && is_enclosed(view, mesh, tracer) { Placement::Inside } else { Placement::Free }
}

/// Returns true if a receiver that sees no sky is below terrain, inside a solid, or where no light
/// arrives.
pub fn is_enclosed(view: &Viewpoint, mesh: &Mesh, tracer: &Tracer) -> bool {
    !is_reached(view.origin(tracer), view.normal, view.seed(), mesh, tracer) || view.crosses_out(mesh, tracer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::site::material::{Class, Material};
    use heliotile_scene::Scene;

    /// Returns a scene with a wall of 8 x 3 m on a plane, below an overhang of 4 m depth that is
    /// drawn upwards or downwards, and a closed box of 2 m behind the wall.
    fn porch(upwards: bool) -> Scene {
        let mut triangles = Vec::new();
        let mut quad = |p: DVec3, a: DVec3, b: DVec3| {
            triangles.push(([p, p + a, p + a + b], 0));
            triangles.push(([p, p + a + b, p + b], 0));
        };
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        quad(DVec3::new(-50.0, -50.0, 0.0), 100.0 * x, 100.0 * y);
        quad(DVec3::ZERO, 8.0 * x, 3.0 * z);
        let (a, b) = (8.0 * x, 4.0 * y);
        let [a, b] = if upwards { [a, b] } else { [b, a] };
        quad(DVec3::new(0.0, -4.0, 3.0), a, b);
        let p = DVec3::new(3.0, 4.0, 0.5);
        quad(p, 2.0 * y, 2.0 * x);
        quad(p + 2.0 * z, 2.0 * x, 2.0 * y);
        quad(p, 2.0 * x, 2.0 * z);
        quad(p + 2.0 * x, 2.0 * y, 2.0 * z);
        quad(p + 2.0 * x + 2.0 * y, -2.0 * x, 2.0 * z);
        quad(p + 2.0 * y, -2.0 * y, 2.0 * z);
        Scene::from_triangles(&triangles, vec![Material::matt("all", 0.3, Class::Obstruction)]).expect("a scene")
    }

    /// All 60 receivers on a wall below an overhang are free, whichever way the overhang is drawn.
    /// 6 of 6 receivers in a closed box are inside.
    #[test]
    fn an_overhang_hides_nothing_and_a_sealed_box_all() {
        for upwards in [true, false] {
            let scene = porch(upwards);
            let tracer = Tracer::new(&scene.mesh).expect("a tree");
            let how = |position: DVec3, normal: DVec3| {
                placement_of(&Viewpoint { position, normal }, 0.02, &scene.mesh, &tracer)
            };
            for (i, k) in (0..10).flat_map(|i| (0..6).map(move |k| (i, k))) {
                let at = DVec3::new(0.4 + 0.8 * f64::from(i), -0.02, 0.25 + 0.5 * f64::from(k));
                assert_eq!(how(at, DVec3::NEG_Y), Placement::Free, "{at} {upwards}");
            }
            for normal in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
                assert_eq!(how(DVec3::new(4.0, 5.0, 1.5), normal), Placement::Inside, "{normal}");
            }
        }
    }
}
