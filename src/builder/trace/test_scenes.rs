//! Scenes for the tests of this module.

use glam::DVec3;

use heliotile_core::site::material::{Class, Material};
use heliotile_scene::Scene;

/// Returns a scene of matt faces of one material, each given by a corner and two sides.
pub fn matt(faces: &[[DVec3; 3]]) -> Scene {
    let halves = |&[p, a, b]: &[DVec3; 3]| [([p, p + a, p + a + b], 0), ([p, p + a + b, p + b], 0)];
    let triangles: Vec<_> = faces.iter().flat_map(halves).collect();
    Scene::from_triangles(&triangles, vec![Material::matt("all", 0.3, Class::Obstruction)]).expect("a scene")
}
