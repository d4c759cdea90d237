//! Files that stand for one kind of fault each, for tests. In: their names. Out: scenes and areas.

use std::path::Path;

use crate::Scene;
use crate::covering::surfaces::Surfaces;
use crate::load::ObjectTriangles;
use crate::site::{Part, SceneFiles};
use heliotile_core::site::semantics::SurfaceKind;

/// Reads a file of `tests/data`.
pub fn load(name: &str) -> Result<(Scene, ObjectTriangles), String> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data")).join(name);
    let site = SceneFiles { parts: vec![Part::plain(&path, None)], ..SceneFiles::default() };
    Scene::load_with_objects(&site).map_err(|error| error.to_string())
}

/// Returns the areas of roofs and walls, m2.
pub fn areas_m2(scene: &Scene, soup: &ObjectTriangles) -> [f64; 2] {
    let surfaces = Surfaces::find(soup, &scene.materials);
    [SurfaceKind::Roof, SurfaceKind::Wall].map(|kind| {
        let own = surfaces.list.iter().filter(|surface| surface.kind == kind);
        own.map(|surface| surface.area_m2).sum()
    })
}
