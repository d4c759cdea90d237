//! In: one surface of a model: its kind, room and corners. Out: a face of the scene.

use std::path::Path;

use glam::DVec3;

use crate::coordinate::is_position;
use crate::formats::building::frame::{Frame, area_vector};
use crate::formats::building::notes::Notes;
use crate::formats::building::reasons::{TOO_FAR, TOO_FEW};
use crate::formats::honeybee::document::{Face3D, Room};
use crate::formats::honeybee::materials::Materials;
use crate::formats::honeybee::properties::ObjectProperties;
use crate::geometry::Geometry;
use heliotile_core::error::Result;
use heliotile_core::site::scene_object::ObjectNote;
use heliotile_core::site::semantics::{FaceNote, FaceSource, SurfaceKind};

/// A surface of a model, without its geometry.
#[derive(Clone, Copy)]
pub(super) struct Surface<'d> {
    /// Identifier, after which receivers on the surface are named.
    pub identifier: &'d str,
    pub kind: Kind,
    /// Room of the surface; `None` for orphaned objects.
    pub room: Option<&'d Room>,
    pub properties: &'d ObjectProperties,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Wall(AdjacentSpace),
    Roof(AdjacentSpace),
    Floor(AdjacentSpace),
    Window { in_wall: bool, operable: bool },
    Door { in_wall: bool, glass: bool },
    Shade { detached: bool },
}

/// Space behind a face, seen from its room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AdjacentSpace {
    Outdoors,
    Ground,
    /// Adiabatic: the space is not stated.
    Adiabatic,
}

impl Surface<'_> {
    fn face_note(&self) -> FaceNote {
        let (kind, exposed) = match self.kind {
            Kind::Wall(behind) => (SurfaceKind::Wall, behind == AdjacentSpace::Outdoors),
            Kind::Roof(behind) => (SurfaceKind::Roof, behind == AdjacentSpace::Outdoors),
            Kind::Floor(behind) => (SurfaceKind::Floor, behind == AdjacentSpace::Outdoors),
            Kind::Window { .. } | Kind::Door { glass: true, .. } => (SurfaceKind::Window, true),
            Kind::Door { glass: false, .. } => (SurfaceKind::Wall, true),
            Kind::Shade { .. } => (SurfaceKind::Shade, true),
        };
        FaceNote { kind: Some(kind), exposed: Some(exposed), source: FaceSource::Named }
    }

    /// Returns the note on the object. Rooms are the objects; a surface outside all rooms stands
    /// for itself.
    fn object_note(&self) -> ObjectNote {
        let object_type = match self.kind {
            Kind::Wall(_) | Kind::Roof(_) | Kind::Floor(_) => "Face",
            Kind::Window { .. } => "Aperture",
            Kind::Door { .. } => "Door",
            Kind::Shade { .. } => "Shade",
        };
        let object = match self.kind {
            Kind::Shade { .. } => String::new(),
            _ => self.room.map_or_else(String::new, |room| room.identifier.clone()),
        };
        ObjectNote { object, object_type: object_type.to_owned(), ..ObjectNote::default() }
    }
}

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
