//! A scene while it is edited. In: a scene as an archive holds it, one edit after the other. Out:
//! its triangles in input coordinates, and the fate of each object.

use std::collections::BTreeSet;
use std::path::Path;

use glam::DVec3;

use super::NewHeight;
use super::names::proposed;
use crate::Scene;
use crate::change::TracedScene;
use crate::ground::endless;
use crate::mesh::bounds;
use crate::mesh_objects::MeshObjects;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::site::material::Material;
use heliotile_core::site::scene_object::SceneObject;
use heliotile_core::text::message;

/// Fate of an object in an edited scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Fate {
    /// The object's surfaces are where they were.
    #[default]
    Stands,
    /// The object is removed.
    Removed,
    /// The object is moved by this vector, metres.
    Moved(DVec3),
    /// The object's surfaces have other shapes.
    Reshaped,
}

/// A scene after some edits, in input coordinates.
#[derive(Clone, Debug)]
pub struct EditedScene {
    /// Corners and material of each triangle.
    pub triangles: Vec<([DVec3; 3], u16)>,
    /// Materials, not sorted.
    pub materials: Vec<Material>,
    /// Objects that the triangles are parts of.
    pub objects: Vec<SceneObject>,
    /// Object of each triangle, an index into `objects`.
    pub of_triangle: Vec<u32>,
    /// Fates of the objects that the scene had before the edits, `[object]`.
    pub fates: Vec<Fate>,
    /// True if any triangle or material has changed.
    pub changed: bool,
}

/// Least height that must remain of a lowered object, metres.
const MIN_M: f64 = 0.1;

/// Height over the foot of an object below which a face that looks up is no roof, metres.
const FOOT_M: f64 = 1.0;

/// Least z of the unit normal of a face that looks up; faces below it are walls.
const LOOKS_UP: f64 = 0.05;

impl EditedScene {
    /// Returns a scene as an archive holds it, without edits.
    pub fn new(scene: &TracedScene) -> Self {
        let absolute = |corners: &[DVec3; 3]| corners.map(|corner| scene.grid.origin + corner);
        let triangles = scene.triangles.iter().map(absolute).zip(scene.triangle_material.iter().copied()).collect();
        EditedScene {
            triangles,
            materials: scene.materials.clone(),
            objects: scene.objects.list.clone(),
            of_triangle: scene.objects.of_triangle.clone(),
            fates: vec![Fate::Stands; scene.objects.list.len()],
            changed: false,
        }
    }

    /// Adds a scene and returns the new numbers of its materials. Materials of one name that differ
    /// are told apart by `called`. Fails if the scene already has one of the added objects.
    pub fn add(&mut self, scene: &Scene, called: &str, file: &Path) -> Result<Vec<u16>> {
        let own: BTreeSet<&str> = self.objects.iter().map(|object| object.name.as_str()).collect();
        let there = |object: &&SceneObject| own.contains(object.name.as_str()) && object.name != endless::NAME;
        if let Some(twice) = scene.objects.list.iter().find(there) {
            let what = format!("the scene has an object `{}` already", twice.name);
            return Err(Error::input(
                file,
                None,
                what,
                "give the object in the file another name, or remove the other one",
            )
            .because(Problem::duplicate(twice.name.to_string())));
        }
        let materials: Vec<u16> =
            scene.materials.iter().map(|material| self.own_material(material, called)).collect::<Result<_>>()?;
        let first = self.objects.len() as u32;
        let origin = scene.mesh.origin;
        for (i, material) in scene.mesh.triangle_material.iter().enumerate() {
            let corners = scene.mesh.triangle_points(i).map(|corner| origin + corner);
            self.triangles.push((corners, materials.get(usize::from(*material)).copied().unwrap_or(u16::MAX)));
        }
        self.of_triangle.extend(scene.objects.of_triangle.iter().map(|object| first + object));
        self.objects.extend(scene.objects.list.iter().cloned());
        self.changed = true;
        Ok(materials)
    }

    /// Returns the edited scene, in the frame of the scene before.
    pub fn scene(&self, before: &TracedScene) -> Result<Scene> {
        let objects = match self.objects.is_empty() {
            true => MeshObjects::default(),
            false => MeshObjects { list: self.objects.clone(), of_triangle: self.of_triangle.clone() },
        };
        Scene::from_objects(&self.triangles, self.materials.clone(), &objects, Some(before.grid.origin))
    }

    /// Returns the triangles of an object.
    fn own(&mut self, object: u32) -> impl Iterator<Item = &mut ([DVec3; 3], u16)> {
        self.triangles.iter_mut().zip(&self.of_triangle).filter(move |(_, of)| **of == object).map(|pair| pair.0)
    }

    pub(super) fn set_fate(&mut self, object: u32, fate: Fate) {
        self.changed = true;
        if let Some(place) = self.fates.get_mut(object as usize) {
            *place = fate;
        }
    }

    /// Returns the fate of an object.
    pub fn fate(&self, object: u32) -> Fate {
        self.fates.get(object as usize).copied().unwrap_or_default()
    }

    pub(super) fn shift(&mut self, object: u32, by: DVec3) {
        if by == DVec3::ZERO {
            return;
        }
        self.own(object).flat_map(|(corners, _)| corners).for_each(|corner| *corner += by);
        if self.fate(object) != Fate::Reshaped {
            self.set_fate(object, Fate::Moved(by));
        }
    }

    /// Raises or lowers all corners at or above the lowest roof of some objects, which may be the
    /// parts of one building.
    pub(super) fn raise(&mut self, name: &str, objects: &[u32], height: NewHeight) -> Result<()> {
        let refuse =
            |what: String, hint: &'static str| Err(Error::argument("height", format!("`{name}` {what}"), hint));
        let all: Vec<[DVec3; 3]> = objects
            .iter()
            .flat_map(|object| self.own(*object).map(|(corners, _)| *corners).collect::<Vec<_>>())
            .collect();
        let (low, high) = bounds(all.iter().flatten().copied());
        let by = match height {
            NewHeight::By(by) => by,
            NewHeight::To(to) => to - (high.z - low.z),
        };
        if !by.is_finite() || matches!(height, NewHeight::To(to) if to <= 0.0) {
            return refuse(format!("by {by} m"), "give metres, such as +3m, -3m or 12m");
        }
        let looks_up = |[a, b, c]: &&[DVec3; 3]| (*b - *a).cross(*c - *a).normalize_or_zero().z > LOOKS_UP;
        let lowest = |corners: &[DVec3; 3]| corners.iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
        let roofs = all.iter().filter(looks_up).map(lowest).filter(|z| *z > low.z + FOOT_M);
        let from = roofs.fold(f64::INFINITY, f64::min);
        if !from.is_finite() {
            return refuse(
                "has no roof, which is a face that looks up and lies more than 1 m above the foot".to_owned(),
                "remove it with {remove} and add another one with {add}",
            )
            .map_err(|error| error.because(Problem::Lacks("roof")));
        }
        if from + by < low.z + MIN_M {
            let what = format!(
                "would be lowered by {:.2} m, but its lowest roof is only {:.2} m above its foot",
                -by,
                from - low.z
            );
            return refuse(what, "lower it less, or remove it with {remove}");
        }
        if by == 0.0 {
            return Ok(());
        }
        // Corners below the lowest roof stay: walls stretch, and the foot keeps its place.
        for object in objects {
            let above = |corner: &&mut DVec3| corner.z >= from;
            self.own(*object).flat_map(|(corners, _)| corners).filter(above).for_each(|corner| corner.z += by);
            self.set_fate(*object, Fate::Reshaped);
        }
        Ok(())
    }

    pub(super) fn paint(&mut self, object: u32, number: u16) {
        let mut changed = false;
        for (_, material) in self.own(object) {
            changed |= *material != number;
            *material = number;
        }
        self.changed |= changed;
    }

    /// Returns the number of a material by its name: one of the scene's, or one that is described.
    pub(super) fn material(&mut self, name: &str, described: &[Material]) -> Result<u16> {
        let number = |materials: &[Material]| materials.iter().position(|material| material.name == name);
        match (number(&self.materials), described.iter().find(|material| material.name == name)) {
            (Some(number), _) => Ok(number as u16),
            (None, Some(material)) => self.push_material(material.clone()),
            (None, None) => {
                let known = self.materials.iter().chain(described).map(|material| material.name.as_str());
                let hint = message!("known materials: {}; {{materials}} may describe others", proposed(name, known));
                Err(Error::argument("material", format!("there is no material `{name}`"), hint)
                    .because(Problem::unknown(name, [])))
            }
        }
    }

    /// Returns the number that a material of an added file gets in this scene.
    fn own_material(&mut self, material: &Material, called: &str) -> Result<u16> {
        if let Some(number) = self.materials.iter().position(|own| own == material) {
            return Ok(number as u16);
        }
        let mut material = material.clone();
        let mut tries = 0;
        while self.materials.iter().any(|own| own.name == material.name) {
            tries += 1;
            let number = if tries > 1 { format!(" {tries}") } else { String::new() };
            let first = material.name.split(" (").next().unwrap_or_default();
            material.name = format!("{first} ({called}{number})");
        }
        self.push_material(material)
    }

    fn push_material(&mut self, material: Material) -> Result<u16> {
        let number = self.materials.len();
        self.materials.push(material);
        u16::try_from(number).map_err(|_| Error::Limit {
            what: "the number of materials in use".into(),
            value: number as u64,
            max: u64::from(u16::MAX),
        })
    }

    /// Removes the triangles of removed objects, and the objects' names, so that added objects may
    /// have them.
    pub(super) fn drop_removed(&mut self) {
        let gone: Vec<bool> = self.of_triangle.iter().map(|of| self.fate(*of) == Fate::Removed).collect();
        let mut each = gone.iter();
        self.triangles.retain(|_| each.next() != Some(&true));
        let mut each = gone.iter();
        self.of_triangle.retain(|_| each.next() != Some(&true));
        let removed = self.objects.iter_mut().zip(&self.fates).filter(|(_, fate)| **fate == Fate::Removed);
        removed.for_each(|(object, _)| *object = SceneObject::default());
    }
}
