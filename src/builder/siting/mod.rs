//! Siting: what a scene says of a place before anything is traced from it. In: a prepared scene, points. Out: what lies below a point,
//! whether light can come to it, and its horizon. Rays only; no textures, cells or archives.

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

/// A scene that is asked about places.
pub struct Siting<'a> {
    prepared: &'a PreparedScene<'a>,
}

/// What lies below a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Below {
    /// Its height, input coordinates, metres.
    pub z: f64,
    /// Index into the scene's materials.
    pub material: u16,
    /// Whether it is ground.
    pub class: Class,
}

/// Rays from above start so far over the scene, metres.
const ABOVE_M: f64 = 10.0;

impl<'a> Siting<'a> {
    /// Of a prepared scene; leaves and screens are not met.
    pub fn new(prepared: &'a PreparedScene<'a>) -> Self {
        Siting { prepared }
    }

    /// What is met first from high above a place in plan; `None` where there is nothing.
    pub fn top(&self, x: f64, y: f64) -> Option<Below> {
        let mesh = &self.prepared.scene.mesh;
        let highest = mesh.bounds().1.z + mesh.origin.z + ABOVE_M;
        self.below(DVec3::new(x, y, highest), |_| true)
    }

    /// The highest ground at or below a point, whatever else lies between them; `None` where there is none.
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
        // By the plane of what is met: f32 rays lose millimetres from high above.
        let normal = scene.mesh.normal(triangle);
        let z = if normal.z.abs() > 1e-6 {
            a.z - (normal.x * (from.x - a.x) + normal.y * (from.y - a.y)) / normal.z
        } else {
            a.z
        };
        Some(Below { z: z + scene.mesh.origin.z, material, class })
    }
}
