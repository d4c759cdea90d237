//! Writer of a city's faces. In: corners in plan with their heights. Out: geometry in scene
//! coordinates.

use std::path::Path;

use glam::DVec2;

use crate::geometry::Geometry;
use heliotile_core::error::Result;
use heliotile_core::site::scene_object::ObjectNote;
use heliotile_core::site::semantics::{FaceNote, FaceSource, SurfaceKind};

/// A corner of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corner {
    /// Place in plan, relative to the middle of the first cell, metres.
    pub place: DVec2,
    pub height: f64,
}

/// Properties of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceOf {
    pub material: u32,
    pub object: u32,
    pub kind: Option<SurfaceKind>,
    /// False if no receivers go on the face; `None` if that is not known.
    pub exposed: Option<bool>,
}

/// Geometry that is being written.
pub(super) struct Writer<'a> {
    pub file: &'a Path,
    /// Middle of the first cell.
    pub origin: DVec2,
    pub geometry: Geometry,
}

impl Writer<'_> {
    /// Returns the number of an object and adds its note.
    pub(super) fn object(&mut self, name: &str, note: &ObjectNote) -> u32 {
        let number = self.geometry.objects.id(name);
        if *note != ObjectNote::default() {
            self.geometry.object_notes.insert(number, note.clone());
        }
        number
    }

    /// Returns the number of a material.
    pub(super) fn material(&mut self, name: &str) -> u32 {
        self.geometry.materials.id(name)
    }

    /// Adds a vertex and returns its number.
    pub(super) fn vertex(&mut self, place: DVec2, height: f64) -> Result<u32> {
        self.geometry.push_vertex(self.file, (self.origin + place).extend(height))
    }

    /// Adds a face by the numbers of its corners, outline and holes.
    pub(super) fn face<'r>(&mut self, rings: impl IntoIterator<Item = &'r [u32]>, of: &FaceOf) {
        self.geometry.push_face(rings, of.material, of.object, 0);
        self.geometry.note_face(FaceNote { kind: of.kind, exposed: of.exposed, source: FaceSource::Order });
    }

    /// Adds the corners of a ring, without repeated ones, and returns their numbers.
    pub(super) fn ring(&mut self, corners: &[Corner]) -> Result<Vec<u32>> {
        let mut ring: Vec<Corner> = Vec::with_capacity(corners.len());
        for corner in corners {
            if ring.last() != Some(corner) {
                ring.push(*corner);
            }
        }
        if ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        ring.into_iter().map(|corner| self.vertex(corner.place, corner.height)).collect()
    }
}
