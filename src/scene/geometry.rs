//! Geometry of a file of any format: polygons with holes in input coordinates, each with a material
//! and an object. In: what a reader finds, one item after the other. Out: lists in which every
//! index is in range and every coordinate finite.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;
use std::path::Path;

use glam::DVec3;

use crate::footprint::Footprint;
use crate::geocentric::LocalFrame;
use crate::ground::model::ModelGround;
use crate::materials::select::MaterialTable;
use crate::placing::y_up::HeaderUp;
use crate::tree_point::TreePoint;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::scene_object::ObjectNote;
use heliotile_core::site::semantics::{FaceNote, SourceFace, SurfaceKind};
use heliotile_core::text::Message;
use heliotile_place::reference::Reference;

/// Polygons of one file, in the order of the file.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    /// Positions in input coordinates, metres; finite, at most
    /// [`MAX_COORDINATE_M`](crate::coordinate::MAX_COORDINATE_M) in size.
    pub vertices: Vec<DVec3>,
    /// Corners of all faces one after the other, outline before holes: indices into `vertices`, all
    /// in range.
    corners: Vec<u32>,
    faces: Vec<Face>,
    /// Number of each face in the file, from 1; empty if all faces are kept.
    numbers: Vec<u32>,
    /// Notes by face; shorter than the faces if nothing is known of the last ones.
    face_notes: Vec<FaceNote>,
    /// Beginnings of holes, in order: the face, and the place in `corners`.
    holes: Vec<(usize, usize)>,
    /// Material names, indexed by `Polygon::material`.
    pub materials: Names,
    /// Object names, indexed by `Polygon::object`: receivers on a face are named after its object.
    pub objects: Names,
    /// Notes on objects by the same numbers; objects without a note are missing.
    pub object_notes: HashMap<u32, ObjectNote>,
    /// Materials that the file itself describes.
    pub stated: MaterialTable,
    /// Names among `stated` whose optics are assumptions of the reader, not of the file.
    pub assumed: BTreeSet<String>,
    /// Place on Earth of the coordinates, if the file states it.
    pub reference: Option<Reference>,
    /// True if the reader converted plane coordinates to metres from the unit of their system.
    pub in_metres: bool,
    /// Frame that the coordinates are relative to, if the file's own are geocentric.
    pub local_frame: Option<LocalFrame>,
    /// Ground of a format that always has ground without a face for it.
    pub ground: Option<ModelGround>,
    /// Statement of the header on the up axis, of a format that has none.
    pub header_up: Option<HeaderUp>,
    pub warnings: Vec<Message>,
    /// Decisions that no user needs to question, one sentence each.
    pub notes: Vec<Message>,
    /// Sentences about faces, which begin with their count.
    pub doubts: Vec<Message>,
    /// Numbers of faces of buildings without semantics, ascending: their tilt decides their kind
    /// once their outside is known.
    pub by_tilt: Vec<usize>,
    /// Counts of faces (or other pieces) that the reader left out, by reason: "with fewer than
    /// three corners".
    pub left_out: BTreeMap<String, usize>,
    /// True if its faces were raised from footprints.
    pub is_raised: bool,
    /// Footprints of buildings, which become faces once the ground below is known.
    pub footprints: Vec<Footprint>,
    /// Trees, which get their hulls once the ground below is known.
    pub trees: Vec<TreePoint>,
}

#[derive(Debug)]
struct Face {
    end: usize,
    material: u32,
    object: u32,
    /// Line of the file, from 1; 0 if the format has none.
    line: usize,
}

/// A position between two faces of a list.
pub(super) struct FaceMark {
    corners: usize,
    faces: usize,
    holes: usize,
}

/// One face: an outline with its holes.
pub(super) struct Polygon<'a> {
    corners: &'a [u32],
    /// Beginnings of its holes: the face, and the place in the corners of all faces.
    holes: &'a [(usize, usize)],
    start: usize,
    pub material: u32,
    pub object: u32,
    pub line: usize,
    /// Index among the faces of the file.
    pub number: usize,
}

impl<'a> Polygon<'a> {
    /// Returns the corners of outline and holes together.
    pub(super) fn corners(&self) -> &'a [u32] {
        self.corners
    }

    /// Returns the rings: the outline, then each hole.
    pub(super) fn rings(&self) -> impl Iterator<Item = &'a [u32]> {
        let begin = |i: usize| self.holes.get(i).map_or(self.corners.len(), |hole| hole.1 - self.start);
        (0..=self.holes.len()).map(move |i| {
            let first = if i == 0 { 0 } else { begin(i - 1) };
            self.corners.get(first..begin(i)).unwrap_or_default()
        })
    }

    pub(super) fn has_holes(&self) -> bool {
        !self.holes.is_empty()
    }
}

impl Geometry {
    /// Adds a vertex and returns its index. The caller has checked the position with
    /// [`is_position`](crate::coordinate::is_position).
    pub(super) fn push_vertex(&mut self, file: &Path, position: DVec3) -> Result<u32> {
        debug_assert!(crate::coordinate::is_position(position));
        let index = u32::try_from(self.vertices.len()).ok().filter(|i| *i < u32::MAX).ok_or_else(|| Error::Limit {
            what: format!("the number of vertices of {}", file.display()).into(),
            value: self.vertices.len() as u64 + 1,
            max: u64::from(u32::MAX),
        })?;
        // + 0.0 turns -0.0 into 0.0.
        self.vertices.push(position + 0.0);
        Ok(index)
    }

    /// Adds one corner to the ring that is being written. The corner must be in range once the file
    /// is read.
    #[inline]
    pub(super) fn push_corner(&mut self, corner: u32) {
        self.corners.push(corner);
    }

    /// Begins a hole of the face that is being written: the corners that follow are the hole's.
    pub(super) fn begin_hole(&mut self) {
        self.holes.push((self.faces.len(), self.corners.len()));
    }

    /// Ends the face of the corners that were pushed since the last one.
    pub(super) fn end_face(&mut self, material: u32, object: u32, line: usize) {
        self.faces.push(Face { end: self.corners.len(), material, object, line });
    }

    /// Sets the note of the face that ended last.
    pub(super) fn note_face(&mut self, note: FaceNote) {
        self.face_notes.resize(self.faces.len(), FaceNote::default());
        if let Some(last) = self.face_notes.last_mut() {
            *last = note;
        }
    }

    /// Adds a whole face: its outline, then its holes.
    pub(super) fn push_face<'r>(
        &mut self,
        rings: impl IntoIterator<Item = &'r [u32]>,
        material: u32,
        object: u32,
        line: usize,
    ) {
        for (i, ring) in rings.into_iter().enumerate() {
            if i > 0 {
                self.begin_hole();
            }
            self.corners.extend_from_slice(ring);
        }
        self.end_face(material, object, line);
    }

    /// Returns a mark at the end of the faces read so far.
    pub(super) fn mark(&self) -> FaceMark {
        FaceMark { corners: self.corners.len(), faces: self.faces.len(), holes: self.holes.len() }
    }

    /// Removes all faces since a mark.
    pub(super) fn back_to(&mut self, mark: &FaceMark) {
        self.corners.truncate(mark.corners);
        self.faces.truncate(mark.faces);
        self.face_notes.truncate(mark.faces);
        self.holes.truncate(mark.holes);
    }

    /// Counts an item that is left out; `reason` completes "3 faces ...".
    pub(super) fn leave_out(&mut self, reason: &str) {
        *self.left_out.entry(reason.to_owned()).or_default() += 1;
    }

    /// Returns the faces as receivers on them name them, in the order of [`Geometry::faces`].
    pub(super) fn source_faces(&self) -> impl Iterator<Item = SourceFace> {
        let face = move |(i, face): (usize, &Face)| SourceFace {
            note: self.note_of(i),
            line: u32::try_from(face.line).unwrap_or(u32::MAX),
            number: self.number_in_file(i),
        };
        self.faces.iter().enumerate().map(face)
    }

    pub(super) fn face_count(&self) -> usize {
        self.faces.len()
    }

    pub(super) fn faces(&self) -> impl Iterator<Item = Polygon<'_>> {
        (0..self.faces.len()).filter_map(|number| self.polygon(number))
    }

    /// Returns the face of a number.
    pub(super) fn polygon(&self, number: usize) -> Option<Polygon<'_>> {
        let face = self.faces.get(number)?;
        let range = self.corners_of(number);
        let first_hole = self.holes.partition_point(|(of, _)| *of < number);
        let holes = self.holes.get(first_hole..).unwrap_or_default();
        let count = holes.iter().take_while(|(of, _)| *of == number).count();
        Some(Polygon {
            start: range.start,
            corners: self.corners.get(range).unwrap_or_default(),
            holes: holes.get(..count).unwrap_or_default(),
            material: face.material,
            object: face.object,
            line: face.line,
            number,
        })
    }

    /// Returns the range of a face's corners.
    fn corners_of(&self, number: usize) -> Range<usize> {
        let end = |number: usize| self.faces.get(number).map_or(0, |face| face.end);
        number.checked_sub(1).map_or(0, end)..end(number)
    }

    /// Returns the note of a face.
    pub(super) fn note_of(&self, number: usize) -> FaceNote {
        self.face_notes.get(number).copied().unwrap_or_default()
    }

    /// Turns a face over: reverses its outline and its holes.
    pub(super) fn turn_face(&mut self, number: usize) {
        let lengths: Vec<usize> =
            self.polygon(number).map(|face| face.rings().map(<[u32]>::len).collect()).unwrap_or_default();
        let range = self.corners_of(number);
        let mut corners = self.corners.get_mut(range).unwrap_or_default();
        for length in lengths {
            let (ring, rest) = corners.split_at_mut(length);
            ring.reverse();
            corners = rest;
        }
    }

    /// Puts the corners of a face's outline in another order.
    pub(super) fn reorder_outline(&mut self, number: usize, outline: &[u32]) {
        let range = self.corners_of(number);
        if let Some(corners) = self.corners.get_mut(range).and_then(|corners| corners.get_mut(..outline.len())) {
            corners.copy_from_slice(outline);
        }
    }

    /// Marks a face as one that no light reaches.
    pub(super) fn mark_inner(&mut self, number: usize) {
        self.face_notes.resize(self.faces.len(), FaceNote::default());
        if let Some(note) = self.face_notes.get_mut(number) {
            note.exposed = Some(false);
        }
    }

    /// Sets the material and the kind of a face.
    pub(super) fn name_face(&mut self, number: usize, material: u32, kind: Option<SurfaceKind>) {
        if let Some(face) = self.faces.get_mut(number) {
            face.material = material;
        }
        if let Some(note) = self.face_notes.get_mut(number) {
            note.kind = kind;
        }
    }

    /// Removes faces with their holes. The others keep their numbers in the file.
    pub(super) fn drop_faces(&mut self, dropped: &[bool]) {
        if !dropped.contains(&true) {
            return;
        }
        let mut kept = Geometry::default();
        for face in self.faces().filter(|face| dropped.get(face.number) != Some(&true)) {
            if self.by_tilt.binary_search(&face.number).is_ok() {
                kept.by_tilt.push(kept.face_count());
            }
            kept.push_face(face.rings(), face.material, face.object, face.line);
            kept.note_face(self.note_of(face.number));
            kept.numbers.push(self.number_in_file(face.number));
        }
        self.corners = kept.corners;
        self.faces = kept.faces;
        self.face_notes = kept.face_notes;
        self.holes = kept.holes;
        self.by_tilt = kept.by_tilt;
        self.numbers = kept.numbers;
    }

    /// Cuts holes out of faces; `holes` gives rings of positions by face. Nothing is cut if the
    /// vertices would exceed 32-bit indices.
    pub(super) fn cut_holes(&mut self, holes: BTreeMap<usize, Vec<Vec<DVec3>>>) {
        if holes.is_empty() {
            return;
        }
        let corners: usize = holes.values().flatten().map(Vec::len).sum();
        if self.vertices.len() + corners >= u32::MAX as usize {
            return;
        }
        let (faces, old) = (std::mem::take(&mut self.faces), std::mem::take(&mut self.corners));
        let mut old_holes = std::mem::take(&mut self.holes).into_iter().peekable();
        let mut start = 0;
        for (number, face) in faces.into_iter().enumerate() {
            while let Some((_, at)) = old_holes.next_if(|(of, _)| *of == number) {
                self.holes.push((number, at - start + self.corners.len()));
            }
            self.corners.extend_from_slice(old.get(start..face.end).unwrap_or_default());
            start = face.end;
            for ring in holes.get(&number).into_iter().flatten() {
                self.holes.push((number, self.corners.len()));
                for position in ring {
                    self.corners.push(self.vertices.len() as u32);
                    self.vertices.push(*position);
                }
            }
            self.faces.push(Face { end: self.corners.len(), ..face });
        }
    }

    /// Returns the number of a face in the file, from 1.
    fn number_in_file(&self, number: usize) -> u32 {
        let all = || u32::try_from(number + 1).unwrap_or(u32::MAX);
        self.numbers.get(number).copied().unwrap_or_else(all)
    }
}

/// Distinct names in the order of their first use.
#[derive(Debug, Default)]
pub(super) struct Names {
    names: Vec<String>,
    ids: HashMap<String, u32>,
}

impl Names {
    /// Returns the number of a name, a new one if the name was not seen before.
    pub(super) fn id(&mut self, name: &str) -> u32 {
        if let Some(&id) = self.ids.get(name) {
            return id;
        }
        // 4 billion names are more memory than any machine has.
        let id = self.names.len() as u32;
        self.names.push(name.to_owned());
        self.ids.insert(name.to_owned(), id);
        id
    }

    pub(super) fn into_vec(self) -> Vec<String> {
        self.names
    }

    pub(super) fn as_slice(&self) -> &[String] {
        &self.names
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Taking back one face with a hole and an unfinished one leaves the face before them with its
    /// three corners.
    #[test]
    fn a_face_taken_back_leaves_those_before_it() {
        let mut geometry = Geometry::default();
        geometry.push_face([&[0_u32, 1, 2][..]], 0, 0, 0);
        let mark = geometry.mark();
        geometry.push_face([&[3_u32, 4, 5][..], &[6, 7, 8]], 0, 0, 0);
        geometry.note_face(FaceNote::default());
        geometry.push_corner(3);
        geometry.begin_hole();
        geometry.back_to(&mark);
        let found: Vec<usize> = geometry.faces().map(|face| face.corners().len()).collect();
        assert_eq!((found, geometry.faces().any(|face| face.has_holes())), (vec![3], false));
    }

    /// Three faces with 0, 2 and 1 holes come back with 1, 3 and 2 rings, corner by corner.
    #[test]
    fn holes_come_back_corner_by_corner() {
        let mut geometry = Geometry::default();
        let faces: [&[&[u32]]; 3] =
            [&[&[0, 1, 2]], &[&[3, 4, 5, 6], &[7, 8, 9], &[1, 2, 3]], &[&[0, 1, 2], &[5, 6, 7]]];
        for (i, rings) in (0..).zip(faces) {
            geometry.push_face(rings.iter().copied(), i, 7, 0);
        }
        let found: Vec<Vec<Vec<u32>>> =
            geometry.faces().map(|face| face.rings().map(<[u32]>::to_vec).collect()).collect();
        let expected: Vec<Vec<Vec<u32>>> =
            faces.iter().map(|rings| rings.iter().map(|ring| ring.to_vec()).collect()).collect();
        assert_eq!(found, expected);
        assert_eq!(geometry.faces().map(|face| face.corners().len()).collect::<Vec<_>>(), [3, 10, 6]);
    }
}
