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
use crate::trace::Ray;
use heliotile_core::site::material::Class;

pub use enclosed::Enclosed;
pub use horizon::HorizonLine;
pub use mirror_rays::{MirrorObserver, MirrorRays};
pub use sun_rays::SunRays;

/// Scene for queries about places.
pub struct Siting<'a> {
    prepared: &'a PreparedScene<'a>,
}

/// Surface below a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Below {
    /// Height, input coordinates, metres.
    pub z: f64,
    /// Index into the scene's materials.
    pub material: u16,
    /// Class of the material.
    pub class: Class,
}

/// Height above the scene from which rays downwards start, metres.
const ABOVE_M: f64 = 10.0;

impl<'a> Siting<'a> {
    /// Creates the queries of a prepared scene. Leaves and screens are ignored.
    pub fn new(prepared: &'a PreparedScene<'a>) -> Self {
        Siting { prepared }
    }

    /// Returns the highest surface at a place in plan; `None` if there is none.
    pub fn top(&self, x: f64, y: f64) -> Option<Below> {
        let mesh = &self.prepared.scene.mesh;
        let highest = mesh.bounds().1.z + mesh.origin.z + ABOVE_M;
        self.below(DVec3::new(x, y, highest), |_| true)
    }

    /// Returns the highest ground at or below a point, whatever lies between them; `None` if there
    /// is none.
    pub fn ground_below(&self, point: DVec3) -> Option<Below> {
        self.below(point, |class| class == Class::Ground)
    }

    fn below(&self, from: DVec3, wanted: impl Fn(Class) -> bool) -> Option<Below> {
        let (scene, tracer) = (self.prepared.scene, &self.prepared.tracer);
        let from = from - scene.mesh.origin;
        let ray = Ray { origin: from.as_vec3().to_array(), direction: [0.0, 0.0, -1.0] };
        let met = tracer.crossed(ray).into_iter().find_map(|hit| {
            let triangle = hit.triangle as usize;
            let material = *scene.mesh.triangle_material.get(triangle)?;
            let class = scene.materials.get(usize::from(material))?.class;
            let [a, b, c] = scene.mesh.triangle_points(triangle);
            wanted(class).then_some((triangle, material, class, [a, b, c]))
        });
        let (triangle, material, class, [a, ..]) = met?;
        // Use the plane of the triangle, because f32 rays from high above lose millimetres.
        let normal = scene.mesh.normal(triangle);
        let z = if normal.z.abs() > 1e-6 {
            a.z - (normal.x * (from.x - a.x) + normal.y * (from.y - a.y)) / normal.z
        } else {
            a.z
        };
        Some(Below { z: z + scene.mesh.origin.z, material, class })
    }
}
