//! Test whether a point is enclosed. In: a point. Out: the ground or solid that encloses it, if no
//! light can reach it.

use glam::{DVec2, DVec3};

use super::Siting;
use crate::trace::Ray;
use crate::trace::hidden::{is_reached, meets_inside};
use heliotile_core::hemisphere::{cosine_direction_of, mix};
use heliotile_core::site::material::Class;

/// Number of rays to each side of the horizon.
const RAYS: usize = 256;

/// Cosine-weighted share of sky above which a point is in the open. Less remains at the rim of
/// terrain that ends somewhere.
const OPEN: f64 = 0.02;

/// Share of inner sides among the hits above which a point is inside a solid.
const OTHER_SIDES: f64 = 0.5;

/// Enclosure of a point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Enclosed {
    /// The point is below the ground.
    BelowGround,
    /// The point is inside a solid, or in a space that no light reaches. Holds the name of the
    /// material that most rays hit.
    Inside(String),
}

impl Siting<'_> {
    /// Returns what encloses a point (input coordinates): the point sees hardly any sky and mostly
    /// backs of surfaces, or no light path reaches it. `None` in the open, and inside a room with
    /// open windows.
    pub fn enclosed(&self, point: DVec3) -> Option<Enclosed> {
        let (scene, tracer) = (self.prepared.scene, &self.prepared.tracer);
        let origin = tracer.grid().relative(point).as_vec3().to_array();
        // The sequence R2 (Roberts 2018): even however many rays are cast.
        let even = |i: usize| DVec2::new(i as f64 * 0.754_877_666, i as f64 * 0.569_840_291).fract();
        let up = (1..=RAYS).map(|i| cosine_direction_of(even(i)));
        let rays: Vec<Ray> =
            up.flat_map(|d| [d, -d]).map(|d| Ray { origin, direction: d.as_vec3().to_array() }).collect();
        let hits = tracer.closest_many(&rays);
        let (mut sky, mut met, mut backs) = (0, 0, 0);
        let mut of_material = vec![0_usize; scene.materials.len()];
        for (ray, hit) in rays.iter().zip(&hits) {
            let Some(hit) = hit else {
                sky += usize::from(ray.direction[2] > 0.0);
                continue;
            };
            met += 1;
            backs += usize::from(meets_inside(ray, hit, &scene.mesh, tracer));
            of_material[usize::from(scene.mesh.triangle_material[hit.triangle as usize])] += 1;
        }
        let sees_sky = sky as f64 > OPEN * RAYS as f64;
        let is_inside = backs as f64 > OTHER_SIDES * met as f64;
        // A closure, because paths cost more than the rays above.
        let dark = || !is_reached(origin, DVec3::Z, mix(0x7369_7465, 0), &scene.mesh, tracer);
        if sees_sky || !is_inside && (sky > 0 || !dark()) {
            return None;
        }
        let overhead = tracer.closest(Ray { origin, direction: [0.0, 0.0, 1.0] });
        let class = |triangle: u32| {
            let material = scene.mesh.triangle_material[triangle as usize];
            scene.materials[usize::from(material)].class
        };
        if overhead.is_some_and(|hit| class(hit.triangle) == Class::Ground) {
            return Some(Enclosed::BelowGround);
        }
        // The ground below a building is not what encloses the point.
        let rank = |i: &usize| (scene.materials[*i].class == Class::Obstruction, of_material[*i]);
        let most = (0..of_material.len()).filter(|i| of_material[*i] > 0).max_by_key(rank);
        Some(Enclosed::Inside(most.map_or_else(String::new, |i| scene.materials[i].name.clone())))
    }
}
