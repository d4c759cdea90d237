//! What a file of any format says: polygons with holes in input coordinates, each of a material and an object. In: what a reader
//! finds, one thing after the other. Out: lists whose every index is in range and every coordinate finite.

use std::collections::BTreeMap;
use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use crate::geocentric::LocalFrame;
use crate::ground::model::ModelGround;
use crate::materials::select::MaterialTable;
use crate::reference::Reference;
use crate::semantics::{FaceNote, ObjectNote, SourceFace};
use heliotile_core::error::{Error, Result};

/// Polygons of one file, in its order.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    /// Input coordinates, metres; finite, at most [`MAX_COORDINATE_M`](crate::coordinate::MAX_COORDINATE_M) in size.
    pub vertices: Vec<DVec3>,
    /// Corners of all faces one after the other, outline before holes: indices into `vertices`, all in range.
    corners: Vec<u32>,
    faces: Vec<Face>,
    /// `[face]`; short where nothing is known of the last faces.
    notes: Vec<FaceNote>,
    /// Face and place in `corners` where one of its holes begins, in order.
    holes: Vec<(usize, usize)>,
    /// Indexed by `Polygon::material`.
    pub materials: Names,
    /// Indexed by `Polygon::object`: what receivers on a face are named after.
    pub objects: Names,
    /// What is known of objects besides, by the same numbers; of others nothing is.
    pub object_notes: HashMap<u32, ObjectNote>,
    /// Materials that the file itself describes.
    pub stated: MaterialTable,
    /// Where on Earth the coordinates lie, if the file says so.
    pub reference: Option<Reference>,
    /// Whether the reader made metres of plane coordinates, whatever the unit of the system that they are in.
    pub in_metres: bool,
    /// Where the coordinates are metres about, if the file's own are geocentric.
    pub local_frame: Option<LocalFrame>,
    /// Of a format that always has ground, which is no face of the file.
    pub ground: Option<ModelGround>,
    pub warnings: Vec<String>,
    /// Faces (or other pieces) that the reader left out, by reason: "with fewer than three corners".
    pub left_out: BTreeMap<String, usize>,
}

#[derive(Debug)]
struct Face {
    end: usize,
    material: u32,
    object: u32,
    /// 1-based line of the file; 0 where the format has none.
    line: usize,
}

/// A place between two faces of a list.
pub(super) struct FaceMark {
    corners: usize,
    faces: usize,
    holes: usize,
}

/// One face: an outline and its holes.
pub(super) struct Polygon<'a> {
    corners: &'a [u32],
    /// Face and place in all corners.
    holes: &'a [(usize, usize)],
    start: usize,
    pub material: u32,
    pub object: u32,
    pub line: usize,
    /// Place among the faces of the file.
    pub number: usize,
}

impl<'a> Polygon<'a> {
    /// Corners of outline and holes together.
    pub(super) fn corners(&self) -> &'a [u32] {
        self.corners
    }

    /// The outline, then each hole.
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
    /// Adds a vertex and gives its index. The caller has checked it with [`is_position`].
    pub(super) fn push_vertex(&mut self, file: &Path, position: DVec3) -> Result<u32> {
        debug_assert!(crate::coordinate::is_position(position));
        let index = u32::try_from(self.vertices.len()).ok().filter(|i| *i < u32::MAX).ok_or_else(|| Error::Limit {
            what: format!("the number of vertices of {}", file.display()),
            value: self.vertices.len() as u64 + 1,
            max: u64::from(u32::MAX),
        })?;
        // + 0.0 turns -0.0 into 0.0.
        self.vertices.push(position + 0.0);
        Ok(index)
    }

    /// Adds one corner to the ring that is being written. It must be in range when the file is read.
    #[inline]
    pub(super) fn push_corner(&mut self, corner: u32) {
        self.corners.push(corner);
    }

    /// The corners that follow are those of a hole of the face that is being written.
    pub(super) fn begin_hole(&mut self) {
        self.holes.push((self.faces.len(), self.corners.len()));
    }

    /// Ends the face whose corners were pushed since the last one.
    pub(super) fn end_face(&mut self, material: u32, object: u32, line: usize) {
        self.faces.push(Face { end: self.corners.len(), material, object, line });
    }

    /// Notes what is known of the face that ended last.
    pub(super) fn note_face(&mut self, note: FaceNote) {
        self.notes.resize(self.faces.len(), FaceNote::default());
        if let Some(last) = self.notes.last_mut() {
            *last = note;
        }
    }

    /// Adds a whole face: its outline and then its holes.
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

    /// How far the faces are read.
    pub(super) fn mark(&self) -> FaceMark {
        FaceMark { corners: self.corners.len(), faces: self.faces.len(), holes: self.holes.len() }
    }

    /// Takes back all faces since a mark.
    pub(super) fn back_to(&mut self, mark: &FaceMark) {
        self.corners.truncate(mark.corners);
        self.faces.truncate(mark.faces);
        self.notes.truncate(mark.faces);
        self.holes.truncate(mark.holes);
    }

    /// Counts something that is left out; `reason` completes "3 faces ...".
    pub(super) fn leave_out(&mut self, reason: &str) {
        *self.left_out.entry(reason.to_owned()).or_default() += 1;
    }

    /// The faces as receivers on them name them, in the order of [`Geometry::faces`].
    pub(super) fn source_faces(&self) -> impl Iterator<Item = SourceFace> {
        let cut = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
        let face = move |(i, face): (usize, &Face)| SourceFace {
            note: self.notes.get(i).copied().unwrap_or_default(),
            line: cut(face.line),
            number: cut(i + 1),
        };
        self.faces.iter().enumerate().map(face)
    }

    pub(super) fn face_count(&self) -> usize {
        self.faces.len()
    }

    pub(super) fn faces(&self) -> impl Iterator<Item = Polygon<'_>> {
        let (mut start, mut hole) = (0, 0);
        self.faces.iter().enumerate().map(move |(i, face)| {
            let first_hole = hole;
            while self.holes.get(hole).is_some_and(|(of, _)| *of == i) {
                hole += 1;
            }
            let polygon = Polygon {
                corners: self.corners.get(start..face.end).unwrap_or_default(),
                holes: self.holes.get(first_hole..hole).unwrap_or_default(),
                start,
                material: face.material,
                object: face.object,
                line: face.line,
                number: i,
            };
            start = face.end;
            polygon
        })
    }
}

/// Names in the order of their first use, each once.
#[derive(Debug, Default)]
pub(super) struct Names {
    names: Vec<String>,
    ids: HashMap<String, u32>,
}

impl Names {
    /// The number of a name, a new one if it was not seen before.
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

    /// A face and a half with a hole that are taken back leave the one face before them with its three corners.
    #[test]
    fn faces_are_taken_back() {
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
    fn holes() {
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
