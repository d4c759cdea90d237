//! Which side of a face is the outside. In: the polygons of one file. Out: the same polygons as receivers and rays can take them: an outline
//! that crosses itself is put in order, of faces that stand twice one is left out, and faces that look into their solid are turned.
//!
//! | file | what it does |
//! | --- | --- |
//! | `crossed` | puts the corners of outlines in order that cross themselves once |
//! | `twins` | finds faces and objects that stand twice |
//! | `shells` | finds what hangs together by its edges, what of it is sound, and which faces turn one way |
//! | `sides` | tells by rays within an object which side of a face is outside |
//!
//! # What never happens
//!
//! - A solid without faults stays as it is, corner by corner.
//! - A sheet, such as an overhang or terrain, is not turned: both of its sides are outside.
//! - The order of faces decides nothing.

mod crossed;
mod shells;
mod sides;
#[cfg(test)]
mod tests;
mod twins;

use std::collections::BTreeSet;

use glam::DVec3;

use crate::geometry::Geometry;
use crate::materials::select::class_of_name;
use crate::polygon::{area_vector_of, object_name};
use crate::semantics::SurfaceKind;
use heliotile_core::site::material::Class;
use heliotile_core::site::morton::lexicographic;
use heliotile_core::text::{counted, with_list};
use shells::{Patch, Shell};
use sides::{Sides, Verdict};
use twins::Twin;

/// Objects named in the first line of a warning.
const MOST_NAMES: usize = 3;

/// What was changed, or could not be told: numbers of faces.
#[derive(Default)]
struct Changes {
    uncrossed: Vec<usize>,
    repeated: Vec<usize>,
    turned: Vec<usize>,
    inner: Vec<usize>,
    unclear: Vec<usize>,
}

/// Puts the faces of a file in order and says what was changed.
pub(crate) fn settle(geometry: &mut Geometry) {
    let mut settling = Settling {
        changes: Changes { uncrossed: crossed::uncross(geometry), ..Changes::default() },
        welded: welded(&geometry.vertices),
        dropped: vec![false; geometry.face_count()],
        paired: BTreeSet::new(),
        geometry,
    };
    for faces in faces_by_object(settling.geometry) {
        settling.object(&faces);
    }
    let Settling { geometry, welded, mut dropped, mut changes, .. } = settling;
    for face in twins::whole_objects(geometry, &welded, &dropped) {
        set(&mut dropped, face, true);
        changes.repeated.push(face);
    }
    report(geometry, &changes);
    for face in changes.inner {
        geometry.mark_inner(face);
    }
    geometry.drop_faces(&dropped);
}

/// A file whose faces are put in order.
struct Settling<'g> {
    geometry: &'g mut Geometry,
    /// `[vertex]`: rank of its position.
    welded: Vec<u32>,
    /// `[face]`: whether it is left out.
    dropped: Vec<bool>,
    /// Faces that stand for two which look apart.
    paired: BTreeSet<usize>,
    changes: Changes,
}

impl Settling<'_> {
    fn object(&mut self, faces: &[usize]) {
        let shells = shells::shells(self.geometry, &self.welded, faces);
        let doubtful = shells.iter().filter(|shell| !shell.is_sound);
        let twins: Vec<Vec<Twin>> =
            doubtful.map(|shell| twins::within(self.geometry, &self.welded, &shell.faces)).collect();
        for twin in twins.iter().flatten() {
            set(&mut self.dropped, twin.face, true);
            // Which of two the file has first is no fault.
            if twin.reversed {
                self.paired.insert(twin.of);
            }
        }
        let near = Near::of(&shells);
        let (mut told, mut unclear) = (BTreeSet::new(), Vec::new());
        for shell in shells.iter().filter(|shell| !shell.is_sound) {
            for patch in self.turn(shell, &near, &mut told) {
                unclear.push((shell, patch));
            }
        }
        // Two walls in a corner or across a street need not be a solid. A warning is due where faces disagree, or lie beside those of a solid.
        let disagree = |patch: &Patch| patch.faces.iter().any(|(_, against)| *against);
        let beside_solid = |shell: &Shell| near.shells(shell).any(|other| other.is_sound || other.has_any(&told));
        for (_, patch) in unclear.iter().filter(|(shell, patch)| disagree(patch) || beside_solid(shell)) {
            self.changes.unclear.extend(patch.numbers());
        }
        for twin in twins.into_iter().flatten() {
            // Of two that look apart both are needed where both of their sides are outside.
            if twin.reversed && !told.contains(&twin.of) {
                set(&mut self.dropped, twin.face, false);
            } else {
                self.changes.repeated.push(twin.face);
            }
        }
    }

    /// Turns the faces of a shell that look into it, and adds those whose outside is known to `told`; returns patches of which rays tell nothing.
    fn turn(&mut self, shell: &Shell, near: &Near, told: &mut BTreeSet<usize>) -> Vec<Patch> {
        let kept = |face: &usize| self.dropped.get(*face) == Some(&false);
        let faces: Vec<usize> = shell.faces.iter().copied().filter(kept).collect();
        let around: Vec<usize> =
            near.shells(shell).flat_map(|other| other.faces.iter().copied()).filter(kept).collect();
        let sides = Sides::new(self.geometry, &around);
        let mut unclear = Vec::new();
        for patch in shells::patches(self.geometry, &self.welded, &faces) {
            let inwards = match sides.verdict(&patch.faces) {
                Verdict::Outward => false,
                Verdict::Inward => true,
                // A closed one that rays do not tell, such as one of solids that overlap.
                _ if patch.is_closed => patch.volume(self.geometry) < 0.0,
                Verdict::Inner => {
                    self.changes.inner.extend(patch.numbers());
                    continue;
                }
                Verdict::Sheet => {
                    self.turn_roofs(&patch);
                    continue;
                }
                Verdict::Unclear => {
                    self.turn_roofs(&patch);
                    unclear.push(patch);
                    continue;
                }
            };
            told.extend(patch.numbers());
            for (face, _) in patch.faces.iter().filter(|(_, against)| *against != inwards) {
                self.turn_face(*face);
            }
        }
        unclear
    }

    /// Turns what the file calls a roof and draws downwards, where nothing else says which side is outside.
    fn turn_roofs(&mut self, patch: &Patch) {
        for face in patch.numbers() {
            let is_roof = self.geometry.note_of(face).kind == Some(SurfaceKind::Roof);
            let polygon = self.geometry.polygon(face).filter(|_| is_roof);
            if polygon.is_some_and(|polygon| area_vector_of(&polygon, &self.geometry.vertices).z < 0.0) {
                self.turn_face(face);
            }
        }
    }

    fn turn_face(&mut self, face: usize) {
        self.geometry.turn_face(face);
        if !self.paired.contains(&face) {
            self.changes.turned.push(face);
        }
    }
}

fn set(flags: &mut [bool], face: usize, value: bool) {
    if let Some(slot) = flags.get_mut(face) {
        *slot = value;
    }
}

/// Finds the shells that rays from a shell may meet.
struct Near<'p> {
    /// By the least x of their boxes.
    shells: Vec<&'p Shell>,
    /// Of the widest one along x, metres.
    width_m: f64,
}

/// Shells further apart than this share of the size of one do not belong together.
const APART: f64 = 0.1;

impl<'p> Near<'p> {
    fn of(shells: &'p [Shell]) -> Near<'p> {
        let mut sorted: Vec<&Shell> = shells.iter().collect();
        sorted.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
        let width_m = shells.iter().map(|shell| shell.high.x - shell.low.x).fold(0.0, f64::max);
        Near { shells: sorted, width_m }
    }

    /// The shells around one, and itself.
    fn shells(&self, shell: &Shell) -> impl Iterator<Item = &'p Shell> {
        let margin = APART * (shell.high - shell.low).length();
        let (low, high) = (shell.low - margin, shell.high + margin);
        let first = self.shells.partition_point(|other| other.low.x < low.x - self.width_m);
        let last = self.shells.partition_point(|other| other.low.x <= high.x);
        let some = self.shells.get(first..last).unwrap_or_default();
        some.iter().copied().filter(move |other| other.low.cmple(high).all() && other.high.cmpge(low).all())
    }
}

/// Faces of each object of which something can be turned: ground looks up, what only shades has no inside, and no light comes to inner faces.
fn faces_by_object(geometry: &Geometry) -> Vec<Vec<usize>> {
    let is_ground: Vec<bool> =
        geometry.materials.as_slice().iter().map(|name| class_of_name(name) == Class::Ground).collect();
    let mut by_object: Vec<(u32, usize)> = Vec::with_capacity(geometry.face_count());
    for (face, source) in geometry.faces().zip(geometry.source_faces()) {
        let ground = match source.note.kind {
            Some(kind) => {
                matches!(kind, SurfaceKind::Ground | SurfaceKind::Shade) || source.note.exposed == Some(false)
            }
            None if source.note.exposed == Some(false) => true,
            None => {
                is_ground.get(face.material as usize) == Some(&true)
                    && geometry.by_tilt.binary_search(&face.number).is_err()
            }
        };
        if !ground {
            by_object.push((face.object, face.number));
        }
    }
    by_object.sort_unstable();
    by_object.chunk_by(|a, b| a.0 == b.0).map(|faces| faces.iter().map(|(_, face)| *face).collect()).collect()
}

/// `[vertex]`: the rank of its position: equal for equal positions.
fn welded(vertices: &[DVec3]) -> Vec<u32> {
    // Vertices are counted in 32 bits.
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    let at = |vertex: u32| vertices.get(vertex as usize).copied().unwrap_or_default();
    order.sort_unstable_by(|&a, &b| lexicographic(at(a), at(b)));
    let (mut ranks, mut rank) = (vec![0; vertices.len()], 0);
    let mut before = None;
    for vertex in order {
        let position = at(vertex);
        rank += u32::from(before.is_some_and(|before| before != position));
        before = Some(position);
        if let Some(slot) = ranks.get_mut(vertex as usize) {
            *slot = rank;
        }
    }
    ranks
}

/// One sentence for each sort of change.
fn report(geometry: &mut Geometry, changes: &Changes) {
    let said = |faces: &[usize], what: &str| {
        let (mut names, mut seen) = (Vec::new(), BTreeSet::new());
        for object in faces.iter().filter_map(|&face| geometry.polygon(face)).map(|face| face.object) {
            if seen.insert(object) {
                names.push(object_name(geometry, object));
            }
        }
        let (count, objects) = (counted(faces.len() as u64, "face"), names.len());
        let first = names.iter().take(MOST_NAMES).cloned().collect::<Vec<_>>().join(", ");
        match objects {
            0 => None,
            1..=MOST_NAMES => Some(format!("{count} of {first} {what}")),
            _ => Some(with_list(
                &format!(
                    "{count} of {} ({first} and {} more) {what}",
                    counted(objects as u64, "object"),
                    objects - MOST_NAMES
                ),
                names,
            )),
        }
    };
    let sentences: Vec<String> = [
        said(&changes.uncrossed, "had an outline that crossed itself: two corners changed places"),
        said(&changes.repeated, "stood twice: one of each is left out"),
        said(&changes.turned, "looked into their object: turned"),
        said(&changes.inner, "lie inside of their object: no receivers there"),
        said(
            &changes.unclear,
            "have no clear outside: receivers may be on the wrong side, or missing; close the object or turn its faces outwards",
        ),
    ]
    .into_iter()
    .flatten()
    .collect();
    geometry.doubts.extend(sentences);
}
