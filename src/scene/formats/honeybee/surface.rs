//! In: one surface of a model: its kind, room and corners. Out: a face of the scene.

use std::path::Path;

use glam::DVec3;

use crate::coordinate::is_position;
use crate::formats::building::frame::{Frame, area_vector};
use crate::formats::building::notes::Notes;
use crate::formats::building::notes::{TOO_FAR, TOO_FEW};
use crate::formats::honeybee::document::Face3D;
use crate::formats::honeybee::kind::Surface;
use crate::formats::honeybee::materials::Materials;
use crate::geometry::Geometry;
use heliotile_core::error::Result;

/// Rings of a surface in metres: outline and holes.
#[derive(Clone, Debug, Default)]
pub(super) struct Rings {
    pub outline: Vec<DVec3>,
    pub holes: Vec<Vec<DVec3>>,
}

impl Rings {
    /// Returns the rings of a geometry, scaled by `metres`; the normal points where `plane` says.
    pub(super) fn new(geometry: &Face3D, metres: f64) -> Rings {
        let ring = |points: &Vec<[f64; 3]>| points.iter().map(|&p| DVec3::from_array(p) * metres).collect();
        let mut outline: Vec<DVec3> = ring(&geometry.boundary);
        let normal = geometry.plane.as_ref().map_or(DVec3::ZERO, |plane| DVec3::from_array(plane.n));
        if area_vector(&outline).dot(normal) < 0.0 {
            outline.reverse();
        }
        Rings { outline, holes: geometry.holes.iter().flatten().map(ring).collect() }
    }

    /// Turns the surface over.
    pub(super) fn turn(&mut self) {
        self.outline.reverse();
    }

    /// Returns the rings, turned if necessary to look where `frame` does.
    pub(super) fn along(mut self, frame: Frame) -> Rings {
        if area_vector(&self.outline).dot(frame.right().cross(frame.up())) < 0.0 {
            self.turn();
        }
        self
    }

    pub(super) fn all(&self) -> impl Iterator<Item = &Vec<DVec3>> {
        std::iter::once(&self.outline).chain(&self.holes)
    }

    /// Returns true if the rings can be a face; otherwise counts the surface as left out.
    pub(super) fn check(&self, geometry: &mut Geometry) -> bool {
        let reason = if self.outline.len() < 3 {
            TOO_FEW
        } else if self.all().flatten().any(|&p| !is_position(p)) {
            TOO_FAR
        } else {
            return true;
        };
        geometry.leave_out(reason);
        false
    }
}

/// Output of the reader: faces, materials and notes.
pub(super) struct Writer<'w, 'd> {
    pub file: &'w Path,
    pub geometry: Geometry,
    pub materials: Materials<'d>,
    pub notes: Notes,
}

impl<'d> Writer<'_, 'd> {
    /// Adds a surface whose rings were checked.
    pub(super) fn push(&mut self, surface: &Surface<'d>, rings: &Rings) -> Result<()> {
        let material = self.materials.of(surface, &mut self.geometry, &mut self.notes);
        let object = self.geometry.objects.id(surface.identifier);
        let mut corners = Vec::new();
        for ring in rings.all() {
            let ring: Result<Vec<u32>> = ring.iter().map(|&p| self.geometry.push_vertex(self.file, p)).collect();
            corners.push(ring?);
        }
        self.geometry.push_face(corners.iter().map(Vec::as_slice), material, object, 0);
        self.geometry.note_face(surface.face_note());
        self.geometry.object_notes.insert(object, surface.object_note());
        Ok(())
    }
}
