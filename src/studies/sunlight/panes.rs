//! Panes: the surfaces of a scene that reflect like mirrors. In: the scene in an archive. Out:
//! panes with names and outlines, and the pane of each triangle.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;

use heliotile_core::site::material::Material;
use heliotile_core::site::patch::Patch;
use heliotile_core::site::receiver::Receiver;
use heliotile_scene::Scene;
use heliotile_scene::covering::surfaces::{Surface, Surfaces};
use heliotile_scene::load::ObjectTriangles;

/// Name of the object in a scene without objects.
const SCENE: &str = "scene";

/// Surface that reflects like a mirror.
#[derive(Clone, Debug)]
pub struct Pane {
    /// Name of its object, with a number behind it if the object has several panes.
    pub name: String,
    /// Name of its material.
    pub material: String,
    surface: Surface,
}

/// Panes of a scene.
pub struct ScenePanes {
    panes: Vec<Arc<Pane>>,
    /// Index into `panes`, by triangle of the mesh.
    of_triangle: BTreeMap<usize, usize>,
}

/// Panes of all archives of a request, by name.
#[derive(Default)]
pub struct PaneList(Mutex<BTreeMap<String, Arc<Pane>>>);

impl ScenePanes {
    /// Finds the panes of a scene.
    pub fn new(scene: &Scene) -> Self {
        let mut of_triangle = BTreeMap::new();
        let Surfaces { list, objects, .. } = Surfaces::find(&soup_of(scene), &scene.materials);
        let mut panes = Vec::new();
        for of_object in list.chunk_by(|a, b| a.object == b.object) {
            for (number, surface) in (1..).zip(of_object) {
                let object = objects.get(surface.object).map_or("", |(name, _)| name.as_str());
                // Archives do not hold the kinds that a model states, so these names differ from
                // those of surfaces.
                let name = match of_object {
                    [_] => object.to_owned(),
                    _ => format!("{object}/pane{number}"),
                };
                of_triangle.extend(surface.faces.iter().map(|triangle| (*triangle as usize, panes.len())));
                let material = material_of(scene, surface.material).map_or(String::new(), |one| one.name.clone());
                panes.push(Arc::new(Pane { name, material, surface: surface.clone() }));
            }
        }
        ScenePanes { panes, of_triangle }
    }

    /// Returns the pane that a triangle of the mesh belongs to.
    pub fn of_triangle(&self, triangle: usize) -> Option<&Arc<Pane>> {
        self.panes.get(*self.of_triangle.get(&triangle)?)
    }
}

impl PaneList {
    /// Adds the panes of a scene; of panes with equal names the first one counts.
    pub fn add(&self, scene: &ScenePanes) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for pane in &scene.panes {
            all.entry(pane.name.clone()).or_insert_with(|| Arc::clone(pane));
        }
    }

    /// Returns all panes, in the order of names.
    pub fn all(&self) -> Vec<Arc<Pane>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).values().cloned().collect()
    }
}

impl Pane {
    /// Returns a receiver that stands for all of the pane, for drawing.
    pub fn drawn(&self) -> Receiver {
        let Surface { triangles, area_m2, normal, .. } = &self.surface;
        let corners = triangles.len() * 3;
        let middle = triangles.iter().flatten().sum::<DVec3>() / corners.max(1) as f64;
        let patch = Patch::of_triangles(middle, *normal, triangles);
        Receiver { area: Some(*area_m2), patch, ..Receiver::new(self.name.clone(), middle, *normal) }
    }
}

fn material_of(scene: &Scene, number: u16) -> Option<&Material> {
    scene.materials.get(usize::from(number))
}

/// Returns the mirrors of a scene, with a face for each triangle.
fn soup_of(scene: &Scene) -> ObjectTriangles {
    let (mesh, objects) = (&scene.mesh, &scene.objects);
    let mut soup = ObjectTriangles::default();
    for triangle in 0..mesh.triangles.len() {
        let number = mesh.triangle_material.get(triangle).copied().unwrap_or_default();
        if !material_of(scene, number).is_some_and(Material::mirrors) {
            continue;
        }
        let first = soup.positions.len() as u32;
        soup.positions.extend(mesh.triangle_points(triangle).map(|corner| mesh.origin + corner));
        soup.triangles.push([first, first + 1, first + 2]);
        soup.materials.push(number);
        soup.objects.push(objects.of_triangle.get(triangle).copied().unwrap_or_default());
        soup.faces.push(triangle as u32);
    }
    soup.object_names = objects.list.iter().map(|object| object.name.clone()).collect();
    soup.object_notes = objects.list.iter().map(|object| object.note.clone()).collect();
    if soup.object_names.is_empty() {
        soup.object_names.push(SCENE.to_owned());
    }
    soup
}
