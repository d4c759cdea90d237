//! Windows and doors that lie on walls. In: the faces of a city model. Out: the same faces; walls
//! and roofs have a hole where a window or door of their building lies in their plane. Otherwise a
//! model that draws a wall whole and its windows upon it would count the windows' area twice.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::formats::building::frame::Frame;
use crate::formats::building::holes::{Fit, ROUNDED_M, Wall, fit};
use crate::geometry::Geometry;
use heliotile_core::site::semantics::SurfaceKind;

/// A wall or a roof, and the holes that are cut out of it.
struct Panel {
    face: usize,
    outline: Vec<DVec3>,
    frame: Frame,
    normal: DVec3,
    holes: Vec<Vec<DVec3>>,
    /// Holes that are new.
    cut: Vec<Vec<DVec3>>,
    /// True if a window takes up the whole panel.
    is_whole: bool,
}

/// Walls and roofs of a building, and the outlines of its openings.
#[derive(Default)]
struct Facade {
    panels: Vec<Panel>,
    openings: Vec<Vec<DVec3>>,
}

/// Cuts windows and doors out of the walls and roofs of their building; returns the number of
/// openings that were cut.
pub(super) fn cut_openings(geometry: &mut Geometry) -> usize {
    let mut buildings: BTreeMap<&str, Facade> = BTreeMap::new();
    let has_openings = (0..geometry.face_count()).any(|face| is_opening(geometry, face));
    // Most models have no openings, and their outlines need not be copied.
    if !has_openings {
        return 0;
    }
    for face in geometry.faces() {
        let kind = geometry.note_of(face.number).kind;
        let mut rings = face.rings().map(|ring| corners(geometry, ring));
        let outline = rings.next().unwrap_or_default();
        let building = building_of(geometry, face.object);
        if is_opening(geometry, face.number) {
            buildings.entry(building).or_default().openings.push(outline);
        } else if matches!(kind, Some(SurfaceKind::Wall | SurfaceKind::Roof))
            && let Some(frame) = Frame::new(&outline)
        {
            let normal = frame.right().cross(frame.up());
            let (face, holes) = (face.number, rings.collect());
            let panel = Panel { face, outline, frame, normal, holes, cut: Vec::new(), is_whole: false };
            buildings.entry(building).or_default().panels.push(panel);
        }
    }
    let (mut count, mut cut, mut dropped) = (0, BTreeMap::new(), vec![false; geometry.face_count()]);
    for Facade { mut panels, openings } in buildings.into_values() {
        count += openings.iter().filter(|opening| take_from(&mut panels, opening)).count();
        for panel in panels {
            if let Some(slot) = dropped.get_mut(panel.face) {
                *slot = panel.is_whole;
            }
            if !panel.cut.is_empty() {
                cut.insert(panel.face, panel.cut);
            }
        }
    }
    geometry.cut_holes(cut);
    geometry.drop_faces(&dropped);
    count
}

/// Cuts an opening out of the first panel that holds it; returns true if one does.
fn take_from(panels: &mut [Panel], opening: &[DVec3]) -> bool {
    let lies_in =
        |panel: &Panel| opening.iter().all(|p| (*p - panel.frame.origin).dot(panel.normal).abs() <= ROUNDED_M);
    for panel in panels.iter_mut().filter(|panel| !panel.is_whole && lies_in(panel)) {
        let wall = Wall { outline: &panel.outline, holes: &panel.holes, frame: panel.frame, rounded_m: ROUNDED_M };
        match fit(&wall, &[opening]).pop() {
            Some(Fit::Hole(ring)) => {
                panel.holes.push(ring.clone());
                panel.cut.push(ring);
                return true;
            }
            Some(Fit::Whole) => {
                panel.is_whole = true;
                return true;
            }
            _ => {}
        }
    }
    false
}

fn is_opening(geometry: &Geometry, face: usize) -> bool {
    let name = geometry.polygon(face).and_then(|face| geometry.materials.as_slice().get(face.material as usize));
    geometry.note_of(face).kind == Some(SurfaceKind::Window) || name.is_some_and(|name| name == "Door")
}

fn building_of(geometry: &Geometry, object: u32) -> &str {
    let note = geometry.object_notes.get(&object).map(|note| note.building.as_str()).filter(|name| !name.is_empty());
    note.or_else(|| geometry.objects.as_slice().get(object as usize).map(String::as_str)).unwrap_or_default()
}

fn corners(geometry: &Geometry, ring: &[u32]) -> Vec<DVec3> {
    ring.iter().filter_map(|&corner| geometry.vertices.get(corner as usize).copied()).collect()
}
