//! Orientation of faces: which side is the outside. In: the polygons of one file. Out: the polygons
//! as receivers and rays need them. An outline that crosses itself is put in order, one of two
//! equal faces is left out, and faces that look into their solid are turned.
//!
//! | file | what it does |
//! | --- | --- |
//! | `crossed` | puts the corners of outlines in order that cross themselves once |
//! | `twins` | finds faces and objects that occur twice |
//! | `copies` | finds solids that occur twice, cut into other faces |
//! | `shells` | finds faces connected by edges, sound shells, and faces of one orientation |
//! | `sides` | finds by rays within an object which side of a face is outside |
//!
//! # What never happens
//!
//! - A solid without faults stays as it is, corner by corner.
//! - A sheet, such as an overhang or terrain, is not turned: both of its sides are outside.
//! - The order of faces decides nothing.

mod copies;
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
use heliotile_core::site::material::Class;
use heliotile_core::site::morton::lexicographic;
use heliotile_core::site::semantics::SurfaceKind;
use heliotile_core::text::{Message, counted, message, with_list};
use shells::{Patch, Shell};
use sides::{Rule, Sides, Verdict};
use twins::Twin;

/// Largest number of objects named in the first line of a warning.
const MAX_NAMES: usize = 3;

/// Numbers of the faces that were changed, or whose outside could not be found.
#[derive(Default)]
struct Changes {
    uncrossed: Vec<usize>,
    repeated: Vec<usize>,
    turned: Vec<usize>,
    inner: Vec<usize>,
    unclear: Vec<usize>,
}

/// Puts the faces of a file in order and adds a sentence about each kind of change.
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
    /// Rank of each vertex's position, `[vertex]`.
    welded: Vec<u32>,
    /// True for faces that are left out, `[face]`.
    dropped: Vec<bool>,
    /// Faces that are kept for a pair of opposite faces.
    paired: BTreeSet<usize>,
    changes: Changes,
}

impl Settling<'_> {
    fn object(&mut self, faces: &[usize]) {
        let mut shells = shells::shells(self.geometry, &self.welded, faces);
        let copies = copies::second_copies(self.geometry, &self.welded, &shells);
        if !copies.is_empty() {
            copies.iter().for_each(|face| set(&mut self.dropped, *face, true));
            let kept: Vec<usize> = faces.iter().copied().filter(|face| copies.binary_search(face).is_err()).collect();
            shells = shells::shells(self.geometry, &self.welded, &kept);
            self.changes.repeated.extend(copies);
        }
        let near = Near::new(&shells, faces.len());
        let mut twins: Vec<Vec<Twin>> = Vec::new();
        for shell in doubtful(&shells) {
            let mut found = twins::within(self.geometry, &self.welded, &shell.faces);
            // The walls between houses that touch are such a pair, and both are needed.
            found.retain(|twin| !(twin.reversed && near.is_crowded(shell)));
            twins.push(found);
        }
        for twin in twins.iter().flatten() {
            set(&mut self.dropped, twin.face, true);
            // The order of the two in the file is no fault of the face that stays.
            if twin.reversed {
                self.paired.insert(twin.of);
            }
        }
        for shell in doubtful(&shells) {
            self.turn(shell, &near);
        }
        for (shell, twins) in doubtful(&shells).zip(twins) {
            self.settle_twins(&near, shell, twins);
        }
    }

    /// Leaves out one of two faces of the same orientation. Of two opposite faces one is left out
    /// only if one side is clearly outside and the other inside: the wall between two houses needs
    /// both, and so does a fence.
    fn settle_twins(&mut self, near: &Near, shell: &Shell, twins: Vec<Twin>) {
        if twins.is_empty() {
            return;
        }
        let sides = Sides::new(self.geometry, &self.around(near, shell));
        for twin in twins {
            match sides.verdict(&[(twin.of, false)], Rule::Most) {
                verdict if !twin.reversed || matches!(verdict, Verdict::Outward | Verdict::Inward) => {
                    self.changes.repeated.push(twin.face);
                }
                verdict => {
                    set(&mut self.dropped, twin.face, false);
                    if verdict == Verdict::Unclear {
                        self.changes.unclear.push(twin.face);
                    }
                }
            }
        }
    }

    /// Returns the faces that rays from a shell may meet.
    fn around(&self, near: &Near, shell: &Shell) -> Vec<usize> {
        let kept = |face: &usize| self.dropped.get(*face) == Some(&false);
        near.shells(shell).flat_map(|other| other.faces.iter().copied()).filter(kept).collect()
    }

    /// Turns the faces of a shell that look into it.
    fn turn(&mut self, shell: &Shell, near: &Near) {
        let kept = |face: &usize| self.dropped.get(*face) == Some(&false);
        let faces: Vec<usize> = shell.faces.iter().copied().filter(kept).collect();
        let around = self.around(near, shell);
        let sides = Sides::new(self.geometry, &around);
        let (agreeing, disagreeing): (Vec<Patch>, Vec<Patch>) =
            shells::patches(self.geometry, &self.welded, &faces).into_iter().partition(Patch::agrees);
        for patch in disagreeing {
            let verdict = if near.is_town { Verdict::Unclear } else { sides.verdict(&patch.faces, Rule::Most) };
            let inwards = match verdict {
                Verdict::Outward => false,
                Verdict::Inward => true,
                _ if patch.is_closed => patch.volume(self.geometry) < 0.0,
                // Few faces that contradict many are the faulty ones.
                _ => match patch.share_against(self.geometry) {
                    share if share < FEW => false,
                    share if share > 1.0 - FEW => true,
                    _ => {
                        self.changes.unclear.extend(patch.numbers());
                        continue;
                    }
                },
            };
            for (face, _) in patch.faces.iter().filter(|(_, against)| *against != inwards) {
                self.turn_face(*face);
            }
        }
        // Faces that agree are turned together, and only if rays leave no doubt: most such faces
        // are right.
        let is_closed = agreeing.iter().all(|patch| patch.is_closed);
        let volume: f64 = agreeing.iter().map(|patch| patch.volume(self.geometry)).sum();
        let block: Vec<(usize, bool)> = agreeing.iter().flat_map(|patch| patch.faces.iter().copied()).collect();
        let verdict = match near.is_crowded(shell) {
            true => Verdict::Sheet,
            false => sides.verdict(&block, Rule::All),
        };
        match verdict {
            Verdict::Inward => block.iter().for_each(|(face, _)| self.turn_face(*face)),
            Verdict::Outward => {}
            _ if is_closed && volume < 0.0 => block.iter().for_each(|(face, _)| self.turn_face(*face)),
            Verdict::Inner => self.changes.inner.extend(block.iter().map(|(face, _)| *face)),
            Verdict::Sheet => self.turn_roofs(&block),
            Verdict::Unclear => {
                self.turn_roofs(&block);
                // If most rays say inwards, a warning is given, but nothing is turned.
                if sides.verdict(&block, Rule::Most) == Verdict::Inward {
                    self.changes.unclear.extend(block.iter().map(|(face, _)| *face));
                }
            }
        }
    }

    /// Turns faces that the file calls a roof and that look down, for shells whose outside nothing
    /// else decides.
    fn turn_roofs(&mut self, faces: &[(usize, bool)]) {
        for face in faces.iter().map(|(face, _)| *face) {
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

fn doubtful(shells: &[Shell]) -> impl Iterator<Item = &Shell> {
    shells.iter().filter(|shell| !shell.is_sound)
}

/// Share of a patch's area below which faces count as few.
const FEW: f64 = 0.1;

fn set(flags: &mut [bool], face: usize, value: bool) {
    if let Some(slot) = flags.get_mut(face) {
        *slot = value;
    }
}

/// Index of the shells that rays from a shell may meet.
struct Near<'p> {
    /// Shells, sorted by the least x of their boxes.
    shells: Vec<&'p Shell>,
    /// Width of the widest shell along x, metres.
    width_m: f64,
    /// True if the object is more than a building: rays do not find the inside of houses that
    /// overlap.
    is_town: bool,
}

/// Most faces of an object that counts as a building.
const TOWN: usize = 1000;

/// Most shells around one that still count as a house.
const CROWDED: usize = 8;

/// Distance of shells that belong together, as a share of the size of one.
const APART: f64 = 0.1;

impl<'p> Near<'p> {
    fn new(shells: &'p [Shell], faces: usize) -> Near<'p> {
        let mut sorted: Vec<&Shell> = shells.iter().collect();
        sorted.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
        let width_m = shells.iter().map(|shell| shell.high.x - shell.low.x).fold(0.0, f64::max);
        Near { shells: sorted, width_m, is_town: faces > TOWN }
    }

    /// Returns true if the surroundings of a shell are too crowded for rays to find its inside: a
    /// town in one object, whose houses overlap.
    fn is_crowded(&self, shell: &Shell) -> bool {
        self.is_town || self.shells(shell).nth(CROWDED).is_some()
    }

    /// Returns a shell and the shells around it.
    fn shells(&self, shell: &Shell) -> impl Iterator<Item = &'p Shell> {
        let margin = APART * (shell.high - shell.low).length();
        let (low, high) = (shell.low - margin, shell.high + margin);
        let first = self.shells.partition_point(|other| other.low.x < low.x - self.width_m);
        let last = self.shells.partition_point(|other| other.low.x <= high.x);
        let some = self.shells.get(first..last).unwrap_or_default();
        some.iter().copied().filter(move |other| other.low.cmple(high).all() && other.high.cmpge(low).all())
    }
}

/// Returns the faces of each object that may be turned. Ground looks up, surfaces that only shade
/// have no inside, and inner faces get no light.
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

/// Returns the rank of each vertex's position, `[vertex]`; equal positions have equal ranks.
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

/// Adds one sentence for each kind of change.
fn report(geometry: &mut Geometry, changes: &Changes) {
    let said = |faces: &[usize], what: &str| {
        let (mut names, mut seen) = (Vec::new(), BTreeSet::new());
        for object in faces.iter().filter_map(|&face| geometry.polygon(face)).map(|face| face.object) {
            if seen.insert(object) {
                names.push(object_name(geometry, object));
            }
        }
        let (count, objects) = (counted(faces.len() as u64, "face"), names.len());
        let first = names.iter().take(MAX_NAMES).cloned().collect::<Vec<_>>().join(", ");
        match objects {
            0 => None,
            1..=MAX_NAMES => Some(message!("{count} of {first} {what}")),
            _ => Some(with_list(
                format!(
                    "{count} of {} ({first} and {} more) {what}",
                    counted(objects as u64, "object"),
                    objects - MAX_NAMES
                ),
                names,
            )),
        }
    };
    let sentences: Vec<Message> = [
        said(&changes.uncrossed, "had an outline that crossed itself: two swapped corners were put in order"),
        said(&changes.repeated, "appeared twice: one copy of each is left out"),
        said(&changes.turned, "pointed into their object: they were turned outwards"),
        said(&changes.inner, "lie inside of their object: they get no receivers"),
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
