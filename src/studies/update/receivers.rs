//! Receivers after edits of the scene. In: the receivers of an archive, the edits of the objects
//! that they stand on. Out: the receivers that stay, moved with their objects, and new ones on new
//! objects or objects with another shape.

use std::collections::{BTreeSet, HashMap};

use glam::DVec3;
use rayon::prelude::*;

use super::request::UpdateRequest;
use crate::covering::{CoverRequest, Density, cover_scene, save};
use heliotile_builder::trace::canopy::Canopies;
use heliotile_builder::trace::placement::{Placement, placement_of};
use heliotile_builder::trace::viewpoint::Viewpoint;
use heliotile_builder::trace::{Ray, Tracer};
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::Observer;
use heliotile_core::site::receiver::Receiver;
use heliotile_files::writing::copy::folder_of;
use heliotile_scene::Scene;
use heliotile_scene::change::TracedScene;
use heliotile_scene::edit::{EditedScene, Fate};
use heliotile_scene::load::ObjectTriangles;
use heliotile_scene::mesh::{Mesh, bounds};
use heliotile_scene::points::receivers::read_receivers;

/// Receivers of an edited scene, with counts by what became of them.
#[derive(Default)]
pub struct UpdatedReceivers {
    /// All receivers.
    pub receivers: Vec<Receiver>,
    /// Number of receivers that stay where they were.
    pub kept: usize,
    /// Number of receivers that moved with their object.
    pub moved: usize,
    /// Number of receivers that were removed with their object, or with its old shape.
    pub gone: usize,
    /// Names of receivers that no longer get light.
    pub buried: Vec<String>,
    /// Number of new receivers.
    pub new: usize,
}

/// Scene before and after edits.
pub struct SceneStates<'a> {
    /// Scene before, as the archive holds it.
    pub held: &'a TracedScene,
    /// Edited scene, with the edits of each object.
    pub edited: &'a EditedScene,
    /// Scene after the edits.
    pub scene: &'a Scene,
}

/// Largest distance of the surface behind a receiver, metres, at which a receiver without a named
/// object counts as standing on it.
const NEAR_M: f64 = 0.1;

/// Distance in front of a receiver, metres, within which a surface covers it. The surface it stands
/// on may be nearer.
const CONTACT_M: f64 = 0.02;

/// Spacing of receivers, metres, for an archive without areas.
const USUAL_SPACING_M: f64 = 2.0;

impl SceneStates<'_> {
    /// Returns the receivers of the archive that still get light, at their new positions.
    pub fn stay(&self, receivers: Vec<Receiver>) -> Result<UpdatedReceivers> {
        let owners = Owners::new(self);
        let mut found = UpdatedReceivers::default();
        let mut before: Vec<Viewpoint> = Vec::with_capacity(receivers.len());
        for mut receiver in receivers {
            let view = viewpoint(&receiver);
            match owners.fate(&receiver) {
                Fate::Removed | Fate::Reshaped => {
                    found.gone += 1;
                    continue;
                }
                Fate::Moved(by) => {
                    receiver.position = as_tables_hold(receiver.position + by);
                    found.moved += 1;
                }
                Fate::Stands => found.kept += 1,
            }
            before.push(view);
            found.receivers.push(receiver);
        }
        if self.edited.changed {
            self.leave_out_buried(&before, &mut found)?;
        }
        Ok(found)
    }

    /// Removes receivers that get no light since the edits; `before` are their positions before.
    fn leave_out_buried(&self, before: &[Viewpoint], found: &mut UpdatedReceivers) -> Result<()> {
        let now: Vec<Viewpoint> = found.receivers.iter().map(viewpoint).collect();
        let is_free = free(&now, self.scene);
        if !is_free.contains(&false) {
            return Ok(());
        }
        let in_doubt: Vec<usize> = (0..now.len()).filter(|&i| is_free.get(i) == Some(&false)).collect();
        let then: Vec<Viewpoint> = in_doubt.iter().filter_map(|&i| before.get(i)).copied().collect();
        let old = EditedScene::new(self.held).scene(self.held)?;
        // Receivers without light before the edits stay in the archive.
        let was_free = free(&then, &old);
        let buried: BTreeSet<usize> = in_doubt.iter().zip(was_free).filter(|(_, was)| *was).map(|(i, _)| *i).collect();
        let moved = |i: usize| before.get(i).zip(now.get(i)).is_some_and(|(a, b)| a.position != b.position);
        let of_moved = buried.iter().filter(|i| moved(**i)).count();
        found.moved -= of_moved;
        found.kept -= buried.len() - of_moved;
        let mut rows = 0..;
        let all = std::mem::take(&mut found.receivers);
        let (left_out, stay): (Vec<Receiver>, Vec<Receiver>) =
            all.into_iter().partition(|_| rows.next().is_some_and(|row| buried.contains(&row)));
        found.receivers = stay;
        found.buried = left_out.into_iter().map(|receiver| receiver.id).collect();
        Ok(())
    }

    /// Returns the triangles of the objects that have another shape.
    pub fn reshaped(&self) -> ObjectTriangles {
        let mut soup = ObjectTriangles::default();
        let EditedScene { triangles, of_triangle, objects, materials, .. } = self.edited;
        let numbers = self.numbers(materials.iter().map(|material| material.name.as_str()));
        for ((corners, material), &object) in triangles.iter().zip(of_triangle) {
            if self.edited.fate(object) == Fate::Reshaped {
                let first = soup.positions.len() as u32;
                soup.positions.extend(corners);
                soup.triangles.push([first, first + 1, first + 2]);
                soup.materials.push(numbers.get(usize::from(*material)).copied().unwrap_or(u16::MAX));
                soup.objects.push(object);
            }
        }
        soup.object_names = objects.iter().map(|object| object.name.clone()).collect();
        soup.object_notes = objects.iter().map(|object| object.note.clone()).collect();
        soup
    }

    /// Returns the indices in the scene of materials with these names.
    pub fn numbers<'n>(&self, names: impl Iterator<Item = &'n str>) -> Vec<u16> {
        let row = |name: &str| self.scene.materials.iter().position(|material| material.name == name);
        names.map(|name| row(name).map_or(u16::MAX, |row| row as u16)).collect()
    }
}

/// Returns receivers on triangles of a scene, rounded as in a table of receivers; empty if the
/// request covers none of these surfaces.
pub fn cover(
    request: &UpdateRequest,
    density: Density,
    scene: &Scene,
    soup: ObjectTriangles,
    observer: &dyn Observer,
) -> Result<Vec<Receiver>> {
    if soup.triangles.is_empty() {
        return Ok(Vec::new());
    }
    let asked = CoverRequest { density, may_be_none: true, ..request.cover.clone() };
    let covered = cover_scene(scene, soup, &asked, observer)?;
    if covered.free().next().is_none() {
        return Ok(Vec::new());
    }
    let folder = folder_of(&request.output);
    let beside = tempfile::Builder::new().prefix(".receivers").tempdir_in(folder);
    let beside = beside.map_err(Error::io(folder, "make a folder in"))?;
    let table = beside.path().join("receivers.csv");
    save(&table, &covered, asked.offset_m)?;
    read_receivers(&table, scene.table_north())
}

/// Returns the approximate spacing of receivers: the side of the mean square that they stand for,
/// rounded up to a multiple of half its power of ten.
pub fn usual_spacing(receivers: &[Receiver]) -> Density {
    let areas: Vec<f64> = receivers.iter().filter_map(|receiver| receiver.area).collect();
    if areas.is_empty() {
        return Density::Spacing(USUAL_SPACING_M);
    }
    let side = (areas.iter().sum::<f64>() / areas.len() as f64).sqrt();
    let step = 0.5 * 10_f64.powf(side.log10().floor());
    Density::Spacing((side / step).ceil() * step)
}

/// Rounds a position to 0.1 mm, as tables of receivers do.
fn as_tables_hold(place: DVec3) -> DVec3 {
    (place * 1e4).round() / 1e4
}

fn viewpoint(receiver: &Receiver) -> Viewpoint {
    Viewpoint { position: receiver.position, normal: receiver.normal }
}

/// Returns true for each receiver that gets light.
fn free(views: &[Viewpoint], scene: &Scene) -> Vec<bool> {
    let (tracer, _) = Canopies::split(scene);
    let offset = |view: &Viewpoint| behind(view, &tracer).map_or(CONTACT_M, |(metres, _)| metres.min(CONTACT_M));
    let is_free = |view: &Viewpoint| placement_of(view, offset(view), &scene.mesh, &tracer) == Placement::Free;
    views.par_iter().map(is_free).collect()
}

/// Returns the distance of the first triangle behind a receiver, metres, and its index.
fn behind(view: &Viewpoint, tracer: &Tracer) -> Option<(f64, u32)> {
    let origin = tracer.grid().relative(view.position).as_vec3().into();
    let hit = tracer.closest(Ray { origin, direction: (-view.normal).as_vec3().into() })?;
    Some((f64::from(hit.t), hit.triangle))
}

/// Finder of the objects that receivers stand on.
struct Owners<'a> {
    edited: &'a EditedScene,
    /// Indices of objects by the names that surfaces and tables use.
    by_name: HashMap<&'a str, u32>,
    /// Triangles of objects that do not stay where they were, with the index of each one's object;
    /// `None` if there are none.
    near: Option<(Tracer, Vec<u32>)>,
}

impl<'a> Owners<'a> {
    fn new(states: &SceneStates<'a>) -> Self {
        let (edited, held) = (states.edited, states.held);
        let mut by_name = HashMap::new();
        for (number, object) in (0..).zip(&held.objects.list) {
            by_name.entry(object.note.object.as_str()).or_insert(number);
            by_name.insert(object.name.as_str(), number);
        }
        by_name.remove("");
        let touched =
            held.triangles.iter().zip(&held.objects.of_triangle).filter(|(_, of)| edited.fate(**of) != Fate::Stands);
        let (triangles, objects): (Vec<[DVec3; 3]>, Vec<u32>) = touched.map(|(corners, of)| (*corners, *of)).unzip();
        let around = bounds(held.triangles.iter().flatten().copied());
        let near = (!triangles.is_empty()).then(|| {
            let mesh = Mesh::loose(held.grid, &triangles, around);
            let all: Vec<u32> = (0..triangles.len() as u32).collect();
            (Tracer::of_triangles(&mesh, &all), objects)
        });
        Owners { edited, by_name, near }
    }

    /// Returns what the edits did to the object that a receiver stands on, found by the name of its
    /// surface or object, or else by the surface behind it.
    fn fate(&self, receiver: &Receiver) -> Fate {
        let Some((tracer, objects)) = &self.near else { return Fate::Stands };
        let surface = receiver.surface.as_deref().unwrap_or_default();
        let of_surface = surface.rsplit_once('/').map_or(surface, |(object, _)| object);
        let named = [surface, of_surface, &receiver.part.object].into_iter().find_map(|name| self.by_name.get(name));
        if let Some(&object) = named {
            return self.edited.fate(object);
        }
        let found = behind(&viewpoint(receiver), tracer).filter(|(metres, _)| *metres <= NEAR_M);
        let object = found.and_then(|(_, triangle)| objects.get(triangle as usize));
        object.map_or(Fate::Stands, |object| self.edited.fate(*object))
    }
}
