//! Walls, roofs and floors with their windows and doors. In: objects of a model. Out: faces of the
//! outer hull, openings cut out.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use crate::coordinate::is_position;
use crate::formats::building::back_to_back::back_to_back;
use crate::formats::building::frame::{Frame, area_vector};
use crate::formats::building::holes;
use crate::formats::building::holes::{Fit, ROUNDED_M};
use crate::formats::building::notes::Notes;
use crate::formats::building::notes::{ALL_WINDOW, BEYOND, INSIDE, TOO_FAR, TOO_FEW};
use crate::formats::energyplus::materials::Materials;
use crate::formats::energyplus::model::{AdjacentSpace, Surface};
use crate::formats::energyplus::model::{Model, Object, same};
use crate::formats::energyplus::place::{Of, PlaceObject};
use crate::formats::energyplus::turned::turn_outwards;
use crate::geometry::Geometry;
use heliotile_core::error::Result;
use heliotile_core::site::scene_object::ObjectNote;
use heliotile_core::site::semantics::{FaceNote, FaceSource, SurfaceKind};

pub(super) const NO_SIZE: &str = "with a length, height or depth that is not above 0";
const NO_BASE: &str = "because the surface that they name is not in the file";

/// Properties of a surface, as its class and fields state them.
struct Said {
    base: usize,
    behind: AdjacentSpace,
    kind: SurfaceKind,
    exposed: bool,
}

pub(super) struct Surfaces<'m> {
    pub list: Vec<Surface<'m>>,
    /// Index of each surface, by its name in lower case.
    by_name: HashMap<String, usize>,
    /// Openings of each wall.
    openings: HashMap<usize, Vec<usize>>,
}

impl<'m> Surfaces<'m> {
    pub(super) fn read(
        model: &'m Model,
        file: &Path,
        place: &PlaceObject,
        geometry: &mut Geometry,
        notes: &mut Notes,
    ) -> Result<Surfaces<'m>> {
        let mut surfaces = Surfaces { list: Vec::new(), by_name: HashMap::new(), openings: HashMap::new() };
        for object in &model.objects {
            if let Some(kind) = Kind::new(object) {
                surfaces.add_base(object, &kind, file, place, geometry, notes)?;
            }
        }
        // Openings come second, because they may stand before their wall in the file.
        for object in &model.objects {
            match object.layout.class {
                "FenestrationSurface:Detailed" | "Window" | "GlazedDoor" | "Door" => {
                    surfaces.add_opening(object, file, place, geometry, notes)?;
                }
                "Window:Interzone" | "GlazedDoor:Interzone" | "Door:Interzone" => geometry.leave_out(INSIDE),
                _ => {}
            }
        }
        surfaces.pair_up();
        turn_outwards(&mut surfaces.list, notes);
        Ok(surfaces)
    }

    pub(super) fn find(&self, name: &str) -> Option<&Surface<'m>> {
        self.by_name.get(&same(name)).and_then(|&index| self.list.get(index))
    }

    fn add_base(
        &mut self,
        object: &'m Object,
        kind: &Kind,
        file: &Path,
        place: &PlaceObject,
        geometry: &mut Geometry,
        notes: &mut Notes,
    ) -> Result<()> {
        let zone = object.text("zone_name");
        if !place.has_zone(zone) {
            notes.add(
                "surfaces belong to a zone that is not in the file; the zone is assumed to lie at the origin",
                &object.name,
            );
        }
        let (mut vertices, mut frame);
        if object.layout.has_vertices {
            vertices = place.vertices(stated_vertices(object, file, notes)?, Of::Zone(zone));
            let up = area_vector(&vertices).z;
            // EnergyPlus turns such surfaces over, too.
            if (kind.kind == SurfaceKind::Floor && up > 0.0) || (kind.kind == SurfaceKind::Roof && up < 0.0) {
                notes.add("floors or roofs face the wrong way and are turned over", &object.name);
                vertices.reverse();
            }
            frame = Frame::new(&vertices);
        } else {
            let rectangle = place.rectangle(object, file, Of::Zone(zone), kind.tilt_deg)?;
            vertices = rectangle.corners();
            frame = Some(rectangle);
            if !(rectangle.width > 0.0 && rectangle.height > 0.0) {
                geometry.leave_out(NO_SIZE);
                frame = None;
            }
        }
        let index = self.list.len();
        let exposed =
            kind.behind == AdjacentSpace::Outdoors && !object.text("sun_exposure").eq_ignore_ascii_case("NoSun");
        let said = Said { base: index, behind: kind.behind, kind: kind.kind, exposed };
        self.push(object, vertices, frame, said, geometry, notes);
        Ok(())
    }

    fn add_opening(
        &mut self,
        object: &'m Object,
        file: &Path,
        place: &PlaceObject,
        geometry: &mut Geometry,
        notes: &mut Notes,
    ) -> Result<()> {
        let found = self.by_name.get(&same(object.text("building_surface_name"))).copied();
        let Some((base, wall)) = found.and_then(|index| Some((index, self.list.get(index)?))) else {
            geometry.leave_out(NO_BASE);
            return Ok(());
        };
        if object.number_or(file, "multiplier", 1.0)? > 1.0 {
            notes.add("windows or doors have a multiplier above 1 and are drawn once", &object.name);
        }
        let (vertices, frame);
        if object.layout.class == "FenestrationSurface:Detailed" {
            let corners = corners_of_four(object, file)?;
            vertices = place.vertices(&corners, Of::Zone(wall.object.text("zone_name")));
            frame = Frame::new(&vertices);
        } else {
            let number = |key| object.number_or(file, key, 0.0);
            let (x, z) = (number("starting_x_coordinate")?, number("starting_z_coordinate")?);
            let rectangle = Frame {
                origin: wall.frame.origin + x * wall.frame.right() + z * wall.frame.up(),
                width: number("length")?,
                height: number("height")?,
                ..wall.frame
            };
            if !(rectangle.width > 0.0 && rectangle.height > 0.0) {
                geometry.leave_out(NO_SIZE);
                return Ok(());
            }
            (vertices, frame) = (rectangle.corners(), Some(rectangle));
        }
        let said = Said { base, behind: wall.behind, kind: opening_kind(object), exposed: wall.exposed };
        if let Some(index) = self.push(object, vertices, frame, said, geometry, notes) {
            self.openings.entry(base).or_default().push(index);
        }
        Ok(())
    }

    fn push(
        &mut self,
        object: &'m Object,
        vertices: Vec<DVec3>,
        frame: Option<Frame>,
        Said { base, behind, kind, exposed }: Said,
        geometry: &mut Geometry,
        notes: &mut Notes,
    ) -> Option<usize> {
        let Some(frame) = frame else {
            if vertices.len() < 3 {
                geometry.leave_out(TOO_FEW);
            }
            return None;
        };
        if !vertices.iter().all(|&p| is_position(p)) {
            geometry.leave_out(TOO_FAR);
            return None;
        }
        let index = self.list.len();
        if self.by_name.insert(same(&object.name), index).is_some() {
            notes.add("surfaces have the name of another surface", &object.name);
        }
        self.list.push(Surface { object, vertices, frame, base, behind, kind, exposed });
        Some(index)
    }

    /// Marks adiabatic surfaces that lie back to back as inside: they separate two zones.
    fn pair_up(&mut self) {
        let open = self.list.iter().enumerate().filter(|(_, surface)| surface.behind == AdjacentSpace::Adiabatic);
        let inside = back_to_back(open.map(|(i, surface)| (i, surface.vertices.as_slice())));
        for i in 0..self.list.len() {
            let base = self.list.get(i).map_or(i, |surface| surface.base);
            if inside.contains(&base)
                && let Some(surface) = self.list.get_mut(i)
            {
                surface.behind = AdjacentSpace::Inside;
            }
        }
    }

    /// Writes the faces of the hull.
    pub(super) fn write(
        &self,
        file: &Path,
        geometry: &mut Geometry,
        materials: &mut Materials,
        notes: &mut Notes,
    ) -> Result<()> {
        for (index, surface) in self.list.iter().enumerate() {
            if surface.behind == AdjacentSpace::Inside {
                geometry.leave_out(INSIDE);
            } else if surface.base == index {
                let openings = self.openings.get(&index).map_or(&[][..], Vec::as_slice);
                let openings: Vec<&Surface> = openings.iter().filter_map(|&i| self.list.get(i)).collect();
                write_wall(surface, &openings, file, geometry, materials, notes)?;
            }
        }
        Ok(())
    }
}

/// Writes a wall and its openings, which are cut out of it.
fn write_wall(
    wall: &Surface,
    openings: &[&Surface],
    file: &Path,
    geometry: &mut Geometry,
    materials: &mut Materials,
    notes: &mut Notes,
) -> Result<()> {
    let outlines: Vec<&[DVec3]> = openings.iter().map(|opening| opening.vertices.as_slice()).collect();
    let whole = holes::Wall { outline: &wall.vertices, holes: &[], frame: wall.frame, rounded_m: ROUNDED_M };
    let fits = holes::fit(&whole, &outlines);
    let mut rings = vec![wall.vertices.as_slice()];
    let zone = wall.object.text("zone_name");
    for ((opening, &outline), fit) in openings.iter().zip(&outlines).zip(&fits) {
        match fit {
            Fit::Hole(ring) => rings.push(ring),
            Fit::Whole => rings.clear(),
            Fit::Beyond => {
                notes.add(BEYOND, &opening.object.name);
                continue;
            }
        }
        let material = materials.of_construction(opening.object, false, geometry, notes)?;
        write_face(&[outline], material, &opening.title(zone), file, geometry)?;
    }
    if fits.contains(&Fit::Whole) {
        geometry.leave_out(ALL_WINDOW);
        return Ok(());
    }
    let on_ground = wall.behind == AdjacentSpace::Ground && wall.kind == SurfaceKind::Floor;
    let material = materials.of_construction(wall.object, on_ground, geometry, notes)?;
    write_face(&rings, material, &wall.title(zone), file, geometry)
}

/// Name and properties of a face.
pub(super) struct Title<'t> {
    pub name: &'t str,
    pub line: usize,
    pub class: &'static str,
    /// Zone that the face bounds; empty for shades, which are objects of their own.
    pub zone: &'t str,
    pub kind: SurfaceKind,
    pub exposed: bool,
}

impl Surface<'_> {
    fn title<'t>(&'t self, zone: &'t str) -> Title<'t> {
        let (name, line, class) = (self.object.name.as_str(), self.object.line, self.object.layout.class);
        Title { name, line, class, zone, kind: self.kind, exposed: self.exposed }
    }
}

/// Writes one face.
pub(super) fn write_face(
    rings: &[&[DVec3]],
    material: u32,
    title: &Title,
    file: &Path,
    geometry: &mut Geometry,
) -> Result<()> {
    let Title { name, line, class, zone, kind, exposed } = *title;
    let id = geometry.objects.id(name);
    let note = ObjectNote { object: zone.to_owned(), object_type: class.to_owned(), ..ObjectNote::default() };
    geometry.object_notes.insert(id, note);
    let mut corners = Vec::new();
    for ring in rings {
        let ring: Result<Vec<u32>> = ring.iter().map(|&p| geometry.push_vertex(file, p)).collect();
        corners.push(ring?);
    }
    geometry.push_face(corners.iter().map(Vec::as_slice), material, id, line);
    geometry.note_face(FaceNote { kind: Some(kind), exposed: Some(exposed), source: FaceSource::Named });
    Ok(())
}

/// Properties that follow from the class of a surface.
struct Kind {
    behind: AdjacentSpace,
    kind: SurfaceKind,
    tilt_deg: f64,
}

impl Kind {
    fn new(object: &Object) -> Option<Kind> {
        let kind = |behind, what| Kind {
            behind,
            kind: match what {
                "floor" => SurfaceKind::Floor,
                "roof" | "ceiling" => SurfaceKind::Roof,
                _ => SurfaceKind::Wall,
            },
            tilt_deg: match what {
                "floor" => 180.0,
                "wall" => 90.0,
                _ => 0.0,
            },
        };
        Some(match object.layout.class {
            "BuildingSurface:Detailed" => kind(behind(object), object.text("surface_type").to_lowercase().as_str()),
            "Wall:Detailed" => kind(behind(object), "wall"),
            "RoofCeiling:Detailed" => kind(behind(object), "roof"),
            "Floor:Detailed" => kind(behind(object), "floor"),
            "Wall:Exterior" => kind(AdjacentSpace::Outdoors, "wall"),
            "Roof" => kind(AdjacentSpace::Outdoors, "roof"),
            "Wall:Underground" => kind(AdjacentSpace::Ground, "wall"),
            "Floor:GroundContact" => kind(AdjacentSpace::Ground, "floor"),
            "Wall:Adiabatic" => kind(AdjacentSpace::Adiabatic, "wall"),
            "Ceiling:Adiabatic" => kind(AdjacentSpace::Adiabatic, "ceiling"),
            "Floor:Adiabatic" => kind(AdjacentSpace::Adiabatic, "floor"),
            "Wall:Interzone" => kind(AdjacentSpace::Inside, "wall"),
            "Ceiling:Interzone" => kind(AdjacentSpace::Inside, "ceiling"),
            "Floor:Interzone" => kind(AdjacentSpace::Inside, "floor"),
            _ => return None,
        })
    }
}

/// Returns the kind of an opening: glass doors are windows, other doors are parts of the wall.
fn opening_kind(object: &Object) -> SurfaceKind {
    let door = object.layout.class == "Door" || object.text("surface_type").eq_ignore_ascii_case("Door");
    if door { SurfaceKind::Wall } else { SurfaceKind::Window }
}

fn behind(object: &Object) -> AdjacentSpace {
    let condition = object.text("outside_boundary_condition").to_lowercase();
    match condition.as_str() {
        // A surface behind itself is how older models state an adiabatic one.
        "surface" if same(object.text("outside_boundary_condition_object")) == same(&object.name) => {
            AdjacentSpace::Adiabatic
        }
        "surface" | "zone" | "space" => AdjacentSpace::Inside,
        "adiabatic" => AdjacentSpace::Adiabatic,
        ground if ground.starts_with("ground") || ground == "foundation" => AdjacentSpace::Ground,
        // `Outdoors`, `OtherSideCoefficients`, `OtherSideConditionsModel`: part of the hull.
        _ => AdjacentSpace::Outdoors,
    }
}

/// Returns the vertices of an object: the first ones if a smaller number is stated, otherwise all.
pub(super) fn stated_vertices<'o>(object: &'o Object, file: &Path, notes: &mut Notes) -> Result<&'o [[f64; 3]]> {
    let all = object.vertices.as_slice();
    let Some(stated) = object.number(file, "number_of_vertices")? else { return Ok(all) };
    if stated == all.len() as f64 {
        return Ok(all);
    }
    notes.add("surfaces state a wrong number of vertices", &object.name);
    // The cast saturates, so that negative and huge numbers are safe.
    Ok(all.get(..stated as usize).unwrap_or(all))
}

/// Returns three or four corners, which have fields of their own.
fn corners_of_four(object: &Object, file: &Path) -> Result<Vec<[f64; 3]>> {
    let mut corners = Vec::new();
    for keys in [
        ["vertex_1_x_coordinate", "vertex_1_y_coordinate", "vertex_1_z_coordinate"],
        ["vertex_2_x_coordinate", "vertex_2_y_coordinate", "vertex_2_z_coordinate"],
        ["vertex_3_x_coordinate", "vertex_3_y_coordinate", "vertex_3_z_coordinate"],
        ["vertex_4_x_coordinate", "vertex_4_y_coordinate", "vertex_4_z_coordinate"],
    ] {
        let [x, y, z] = keys.map(|key| object.number(file, key));
        match (x?, y?, z?) {
            (Some(x), Some(y), Some(z)) => corners.push([x, y, z]),
            (None, None, None) => {}
            _ => {
                let what = format!("corner {} lacks a coordinate", corners.len() + 1);
                return Err(object.error(file, what, "give x, y and z of every vertex"));
            }
        }
    }
    // A triangle may carry a fourth corner that does not count.
    if object.number(file, "number_of_vertices")? == Some(3.0) {
        corners.truncate(3);
    }
    Ok(corners)
}
