//! Surfaces of a model that light reaches. In: a whole model. Out: the hull of its rooms with
//! windows and doors cut out, and its shades.

use std::collections::HashSet;
use std::path::Path;

use glam::DVec3;

use crate::coordinate::is_position;
use crate::formats::building::back_to_back::back_to_back;
use crate::formats::building::frame::{Frame, area_vector};
use crate::formats::building::holes::ROUNDED_M;
use crate::formats::building::notes::Notes;
use crate::formats::building::notes::{ALL_WINDOW, BEYOND, INSIDE, TOO_FAR, TURNED_OPENINGS};
use crate::formats::building::outwards::facing_inwards;
use crate::formats::honeybee::cut::cut;
use crate::formats::honeybee::document::{Boundary, Face, FaceType, Model, Opening, Room, Shade, ShadeMesh};
use crate::formats::honeybee::kind::{AdjacentSpace, Kind, Surface};
use crate::formats::honeybee::materials::Materials;
use crate::formats::honeybee::surface::{Rings, Writer};
use crate::geometry::Geometry;
use heliotile_core::error::{Error, Result};

/// Reason for leaving out shades at the inner side of something.
const INDOORS: &str = "because they are indoor shades";
const INWARDS: &str = "faces of closed rooms look inwards and are turned";
/// Largest tolerance that is used, metres: a larger one says nothing about which points coincide.
const MAX_ROUNDED_M: f64 = 0.1;

/// Reads all surfaces of a model.
pub(super) fn write<'d>(model: &'d Model, file: &Path) -> Result<(Geometry, Materials<'d>)> {
    let metres = model.units.metres();
    let writer =
        Writer { file, geometry: Geometry::default(), materials: Materials::new(model), notes: Notes::default() };
    let tolerance_m = model.tolerance.unwrap_or(0.0) * metres;
    let mut reader = Reader { metres, rounded_m: tolerance_m.clamp(ROUNDED_M, MAX_ROUNDED_M), writer };
    reader.read(model)?;
    let Writer { mut geometry, materials, notes, .. } = reader.writer;
    notes.say(file, &mut geometry.warnings);
    Ok((geometry, materials))
}

/// Rings of a face, of its apertures and of its doors.
struct FaceRings {
    own: Rings,
    openings: Vec<Rings>,
}

struct Reader<'w, 'd> {
    /// Length of a unit of the model, metres.
    metres: f64,
    rounded_m: f64,
    writer: Writer<'w, 'd>,
}

impl<'d> Reader<'_, 'd> {
    fn read(&mut self, model: &'d Model) -> Result<()> {
        let rooms = model.rooms.iter().flatten();
        let faces: Vec<(Option<&Room>, &Face)> = rooms
            .clone()
            .flat_map(|room| room.faces.iter().map(move |face| (Some(room), face)))
            .chain(model.orphaned_faces.iter().flatten().map(|face| (None, face)))
            .collect();
        let mut rings: Vec<Rings> = faces.iter().map(|(_, face)| Rings::new(&face.geometry, self.metres)).collect();
        let turned = self.turn_outwards(model, &mut rings);
        // Adiabatic faces back to back separate two rooms: they lie inside.
        let open = faces.iter().zip(&rings).enumerate();
        let open = open.filter(|(_, ((_, face), _))| face.boundary_condition.kind == Boundary::Adiabatic);
        let pairs: HashSet<usize> = back_to_back(open.map(|(i, (_, rings))| (i, rings.outline.as_slice())));
        for (i, ((room, face), rings)) in faces.iter().zip(rings).enumerate() {
            match kind_of(face) {
                Some(kind) if !pairs.contains(&i) => {
                    let rings = self.openings_along(face, rings, turned.contains(&i));
                    self.face(*room, face, kind, rings)?;
                }
                _ => self.inside(face),
            }
        }
        for room in rooms {
            if room.multiplier.is_some_and(|count| count > 1.0) {
                self.writer.notes.add("rooms have a multiplier above 1 and are drawn once", &room.identifier);
            }
            self.shades(room.outdoor_shades.as_ref(), Some(room))?;
            self.indoors(room.indoor_shades.as_ref().map_or(0, Vec::len));
        }
        for window in model.orphaned_apertures.iter().flatten() {
            let rings = Rings::new(&window.geometry, self.metres);
            self.opening(None, window, window_of(window, true), &rings, true)?;
        }
        for door in model.orphaned_doors.iter().flatten() {
            let rings = Rings::new(&door.geometry, self.metres);
            self.opening(None, door, door_of(door, true), &rings, true)?;
        }
        self.shades(model.orphaned_shades.as_ref(), None)?;
        model.shade_meshes.iter().flatten().try_for_each(|mesh| self.mesh(mesh))
    }

    /// Turns the faces that look into their room; returns their indices. `rings` begins with the
    /// faces of all rooms.
    fn turn_outwards(&mut self, model: &Model, rings: &mut [Rings]) -> HashSet<usize> {
        let mut turned = HashSet::new();
        let mut first = 0;
        for room in model.rooms.iter().flatten() {
            let own = rings.get(first..first + room.faces.len()).unwrap_or_default();
            let faces: Vec<Vec<&[DVec3]>> = own.iter().map(|rings| rings.all().map(Vec::as_slice).collect()).collect();
            for i in facing_inwards(&faces) {
                if let (Some(rings), Some(face)) = (rings.get_mut(first + i), room.faces.get(i)) {
                    self.writer.notes.add(INWARDS, &face.identifier);
                    rings.turn();
                    turned.insert(first + i);
                }
            }
            first += room.faces.len();
        }
        turned
    }

    /// Returns the rings of a face, its apertures and its doors, which are turned to look where the
    /// face does. Openings of a face that was turned get no note.
    fn openings_along(&mut self, face: &Face, rings: Rings, is_turned: bool) -> FaceRings {
        let outwards = area_vector(&rings.outline);
        let mut outlines = Vec::new();
        for opening in face.apertures.iter().chain(&face.doors).flatten() {
            let mut own = Rings::new(&opening.geometry, self.metres);
            if area_vector(&own.outline).dot(outwards) < 0.0 {
                if !is_turned {
                    self.writer.notes.add(TURNED_OPENINGS, &opening.identifier);
                }
                own.turn();
            }
            outlines.push(own);
        }
        FaceRings { own: rings, openings: outlines }
    }

    /// Counts a face that no light reaches, and all that belongs to it.
    fn inside(&mut self, face: &Face) {
        let openings = face.apertures.iter().chain(&face.doors).flatten();
        let of_openings = openings.clone().map(|opening| opening.outdoor_shades.as_ref().map_or(0, Vec::len));
        let others = of_openings.sum::<usize>() + face.outdoor_shades.as_ref().map_or(0, Vec::len);
        for _ in 0..1 + openings.clone().count() + others {
            self.writer.geometry.leave_out(INSIDE);
        }
        let of_openings = openings.map(|opening| opening.indoor_shades.as_ref().map_or(0, Vec::len));
        self.indoors(of_openings.sum::<usize>() + face.indoor_shades.as_ref().map_or(0, Vec::len));
    }

    fn indoors(&mut self, count: usize) {
        for _ in 0..count {
            self.writer.geometry.leave_out(INDOORS);
        }
    }

    /// Writes a face of the hull with its openings cut out, and its shades.
    fn face(&mut self, room: Option<&'d Room>, face: &'d Face, kind: Kind, rings: FaceRings) -> Result<()> {
        let FaceRings { own: rings, openings: outlines } = rings;
        let in_wall = face.face_type == FaceType::Wall;
        let windows = face.apertures.iter().flatten().map(|window| (window, window_of(window, in_wall)));
        let doors = face.doors.iter().flatten().map(|door| (door, door_of(door, in_wall)));
        let openings: Vec<(&Opening, Kind)> = windows.chain(doors).collect();
        let frame = if rings.check(&mut self.writer.geometry) { Frame::new(&rings.outline) } else { None };
        let Some(frame) = frame else {
            // A degenerate face is left out, but its openings are kept.
            for ((opening, kind), rings) in openings.iter().zip(&outlines) {
                self.opening(room, opening, *kind, rings, true)?;
            }
            return self.shades_of(face, room);
        };
        let left = cut(rings, frame, &outlines, self.rounded_m);
        for (((opening, kind), rings), fits) in openings.iter().zip(&outlines).zip(left.fits) {
            if !fits {
                self.writer.notes.add(BEYOND, &opening.identifier);
            }
            self.opening(room, opening, *kind, rings, fits)?;
        }
        if left.is_whole {
            self.writer.geometry.leave_out(ALL_WINDOW);
        }
        let surface = Surface { identifier: &face.identifier, kind, room, properties: &face.properties };
        left.pieces.iter().try_for_each(|piece| self.writer.push(&surface, piece))?;
        self.shades_of(face, room)
    }

    /// Writes the shades of a face.
    fn shades_of(&mut self, face: &'d Face, room: Option<&'d Room>) -> Result<()> {
        self.shades(face.outdoor_shades.as_ref(), room)?;
        self.indoors(face.indoor_shades.as_ref().map_or(0, Vec::len));
        Ok(())
    }

    /// Writes a window or a door to the outside, and its shades.
    fn opening(
        &mut self,
        room: Option<&'d Room>,
        opening: &'d Opening,
        kind: Kind,
        rings: &Rings,
        fits: bool,
    ) -> Result<()> {
        if room.is_none() && opening.boundary_condition.kind == Boundary::Surface {
            self.writer.geometry.leave_out(INSIDE);
            return Ok(());
        }
        if fits && rings.check(&mut self.writer.geometry) {
            let surface = Surface { identifier: &opening.identifier, kind, room, properties: &opening.properties };
            self.writer.push(&surface, rings)?;
        }
        self.shades(opening.outdoor_shades.as_ref(), room)?;
        self.indoors(opening.indoor_shades.as_ref().map_or(0, Vec::len));
        Ok(())
    }

    fn shades(&mut self, shades: Option<&'d Vec<Shade>>, room: Option<&'d Room>) -> Result<()> {
        for shade in shades.into_iter().flatten() {
            let rings = Rings::new(&shade.geometry, self.metres);
            if rings.check(&mut self.writer.geometry) {
                let kind = Kind::Shade { detached: shade.is_detached };
                let surface = Surface { identifier: &shade.identifier, kind, room, properties: &shade.properties };
                self.writer.push(&surface, &rings)?;
            }
        }
        Ok(())
    }

    fn mesh(&mut self, mesh: &'d ShadeMesh) -> Result<()> {
        let writer = &mut self.writer;
        let refuse = |what: String| {
            let what = format!("shade mesh `{}`: {what}", crate::text::excerpt(mesh.identifier.as_bytes()));
            Error::input(writer.file, None, what, "export the model again, or check it with `honeybee validate`")
        };
        let far = |p: &[f64; 3]| !is_position(DVec3::from_array(*p) * self.metres);
        if mesh.geometry.vertices.iter().any(far) {
            writer.geometry.leave_out(TOO_FAR);
            return Ok(());
        }
        let kind = Kind::Shade { detached: mesh.is_detached };
        let surface = Surface { identifier: &mesh.identifier, kind, room: None, properties: &mesh.properties };
        let mut faces = Vec::with_capacity(mesh.geometry.faces.len());
        for (i, face) in mesh.geometry.faces.iter().enumerate() {
            if !(3..=4).contains(&face.len()) {
                return Err(refuse(format!("face {i} has {} corners, not 3 or 4", face.len())));
            }
            let vertex = |&index: &u64| {
                let found = usize::try_from(index).ok().and_then(|index| mesh.geometry.vertices.get(index));
                found.map(|&p| DVec3::from_array(p) * self.metres).ok_or_else(|| {
                    let count = mesh.geometry.vertices.len();
                    refuse(format!("face {i} names vertex {index}, but the {count} vertices are numbered from 0"))
                })
            };
            let outline: Result<Vec<DVec3>> = face.iter().map(vertex).collect();
            faces.push(Rings { outline: outline?, holes: Vec::new() });
        }
        faces.iter().try_for_each(|rings| writer.push(&surface, rings))
    }
}

/// Returns the kind of a face of the hull; `None` for a face inside.
fn kind_of(face: &Face) -> Option<Kind> {
    let behind = match face.boundary_condition.kind {
        Boundary::Outdoors | Boundary::OtherSideTemperature => AdjacentSpace::Outdoors,
        Boundary::Ground => AdjacentSpace::Ground,
        Boundary::Adiabatic => AdjacentSpace::Adiabatic,
        Boundary::Surface => return None,
    };
    match face.face_type {
        FaceType::Wall => Some(Kind::Wall(behind)),
        FaceType::RoofCeiling => Some(Kind::Roof(behind)),
        FaceType::Floor => Some(Kind::Floor(behind)),
        FaceType::AirBoundary => None,
    }
}

fn window_of(window: &Opening, in_wall: bool) -> Kind {
    Kind::Window { in_wall, operable: window.is_operable }
}

fn door_of(door: &Opening, in_wall: bool) -> Kind {
    Kind::Door { in_wall, glass: door.is_glass }
}
