//! Scene ready for rays. In: a scene. Out: its tree, its mirrors and its canopies.

use std::time::Instant;

use glam::DVec3;

use crate::settings::{BuildSettings, Effect};
use crate::trace::canopy::Canopies;
use crate::trace::volume::Volumes;
use crate::trace::{Ray, Tracer};
use heliotile_core::error::Result;
use heliotile_core::site::material::Class;
use heliotile_scene::Scene;
use heliotile_scene::mirrors::Mirrors;

/// Scene with all that does not depend on settings.
pub struct PreparedScene<'a> {
    /// Scene as it was loaded.
    pub scene: &'a Scene,
    /// Tracer of the opaque triangles.
    pub(crate) tracer: Tracer,
    pub(crate) canopies: Option<Canopies<'a>>,
    pub(crate) mirrors: Mirrors,
    pub(super) seconds: f64,
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

impl<'a> PreparedScene<'a> {
    /// Builds the tree and finds the mirrors.
    pub fn new(scene: &'a Scene) -> Result<Self> {
        let start = Instant::now();
        Volumes::check(scene)?;
        let (tracer, canopies) = Canopies::split(scene);
        let mirrors = Mirrors::find(&scene.mesh, &scene.materials)?;
        Ok(PreparedScene { scene, tracer, canopies, mirrors, seconds: start.elapsed().as_secs_f64() })
    }

    /// Returns the highest surface at a place in plan; `None` if there is none.
    pub fn top(&self, x: f64, y: f64) -> Option<Below> {
        let mesh = &self.scene.mesh;
        let highest = mesh.bounds().1.z + mesh.origin.z + ABOVE_M;
        self.below(DVec3::new(x, y, highest), |_| true)
    }

    /// Returns the first surface of a wanted class below a point. Leaves and screens are ignored.
    pub(crate) fn below(&self, from: DVec3, wanted: impl Fn(Class) -> bool) -> Option<Below> {
        let (scene, tracer) = (self.scene, &self.tracer);
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

    /// Returns true if there are mirrors and they are to be traced.
    pub(super) fn reflects(&self, settings: &BuildSettings) -> bool {
        !self.mirrors.is_empty() && !settings.left_out.contains(Effect::Mirrors)
    }
}
