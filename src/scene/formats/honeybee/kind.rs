//! Surfaces of a model without their geometry. In: kind, room and properties. Out: notes on the
//! face and on its object.

use crate::formats::honeybee::document::Room;
use crate::formats::honeybee::properties::ObjectProperties;
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
    pub(super) fn face_note(&self) -> FaceNote {
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
    pub(super) fn object_note(&self) -> ObjectNote {
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
