//! Shades of buildings. In: shading objects of a model. Out: one face each; light meets both of its
//! sides.

use std::path::Path;

use crate::coordinate::is_position;
use crate::formats::building::frame::Frame;
use crate::formats::building::notes::Notes;
use crate::formats::building::notes::{TOO_FAR, TOO_FEW};
use crate::formats::energyplus::materials::Materials;
use crate::formats::energyplus::model::Surface;
use crate::formats::energyplus::model::{Model, Object};
use crate::formats::energyplus::place::{Of, PlaceObject};
use crate::formats::energyplus::surfaces::{NO_SIZE, Surfaces, Title, stated_vertices, write_face};
use crate::geometry::Geometry;
use glam::DVec3;
use heliotile_core::error::Result;
use heliotile_core::site::semantics::SurfaceKind;

const NO_WINDOW: &str = "because the window or door that they shade is not in the file";

/// Writes all shading surfaces of a model.
pub(super) fn write(
    model: &Model,
    file: &Path,
    place: &PlaceObject,
    surfaces: &Surfaces,
    geometry: &mut Geometry,
    materials: &mut Materials,
    notes: &mut Notes,
) -> Result<()> {
    let mut writer = Writer { file, place, geometry, materials, notes };
    for object in &model.objects {
        match object.layout.class {
            "Shading:Site:Detailed" => writer.detailed(object, Of::Site)?,
            "Shading:Building:Detailed" => writer.detailed(object, Of::Building)?,
            "Shading:Zone:Detailed" => {
                let base = surfaces.find(object.text("base_surface_name"));
                if base.is_none() {
                    writer.notes.add(
                        "shades name a surface that is not in the file; they are placed by the building's origin",
                        &object.name,
                    );
                }
                // A shade at a window is placed in the zone of the wall, too.
                let wall = base.and_then(|surface| surfaces.list.get(surface.base));
                let of = wall.map_or(Of::Building, |wall| Of::Zone(wall.object.text("zone_name")));
                writer.detailed(object, of)?;
            }
            "Shading:Site" => writer.rectangle(object, Of::Site)?,
            "Shading:Building" => writer.rectangle(object, Of::Building)?,
            class @ ("Shading:Overhang" | "Shading:Overhang:Projection" | "Shading:Fin" | "Shading:Fin:Projection") => {
                let window = surfaces.find(object.text("window_or_door_name"));
                let wall = window.and_then(|window| surfaces.list.get(window.base));
                match (window, wall) {
                    (Some(window), Some(wall)) if class.starts_with("Shading:Overhang") => {
                        writer.overhang(object, window, wall)?;
                    }
                    (Some(window), Some(wall)) => writer.fins(object, window, wall)?,
                    _ => writer.geometry.leave_out(NO_WINDOW),
                }
            }
            _ => {}
        }
    }
    Ok(())
}

struct Writer<'w, 'm> {
    file: &'w Path,
    place: &'w PlaceObject,
    geometry: &'w mut Geometry,
    materials: &'w mut Materials<'m>,
    notes: &'w mut Notes,
}

impl Writer<'_, '_> {
    fn detailed(&mut self, object: &Object, of: Of) -> Result<()> {
        let vertices = self.place.vertices(stated_vertices(object, self.file, self.notes)?, of);
        if vertices.len() < 3 {
            self.geometry.leave_out(TOO_FEW);
            return Ok(());
        }
        self.face(object, &object.name, &vertices)
    }

    fn rectangle(&mut self, object: &Object, of: Of) -> Result<()> {
        let frame = self.place.rectangle(object, self.file, of, 90.0)?;
        self.framed(object, &object.name, &frame)
    }

    /// Writes a rectangle if it has an area.
    fn framed(&mut self, object: &Object, name: &str, frame: &Frame) -> Result<()> {
        // A fin extends to the left of its own frame: its width is negative.
        if !(frame.width.abs() > 0.0 && frame.height > 0.0) {
            self.geometry.leave_out(NO_SIZE);
            return Ok(());
        }
        self.face(object, name, &frame.corners())
    }

    fn face(&mut self, object: &Object, name: &str, vertices: &[DVec3]) -> Result<()> {
        if !vertices.iter().all(|&p| is_position(p)) {
            self.geometry.leave_out(TOO_FAR);
            return Ok(());
        }
        let material = self.materials.of_shade(object, self.geometry, self.notes)?;
        let (line, class) = (object.line, object.layout.class);
        let title = Title { name, line, class, zone: "", kind: SurfaceKind::Shade, exposed: true };
        write_face(&[vertices], material, &title, self.file, self.geometry)
    }

    fn overhang(&mut self, object: &Object, window: &Surface, wall: &Surface) -> Result<()> {
        let number = |key| object.number_or(self.file, key, 0.0);
        let left = number("left_extension_from_window_door_width")?;
        let right = number("right_extension_from_window_door_width")?;
        let above = number("height_above_window_or_door")?;
        let depth = match object.number(self.file, "depth")? {
            Some(depth) => depth,
            None => number("depth_as_fraction_of_window_door_height")? * window.frame.height,
        };
        let tilt = object.number_or(self.file, "tilt_angle_from_window_door", 90.0)?;
        let frame = Frame {
            origin: on_wall(window, wall, -left, window.frame.height + above),
            azimuth_deg: window.frame.azimuth_deg,
            tilt_deg: window.frame.tilt_deg + tilt,
            width: (left + right + window.frame.width).max(0.0),
            height: depth,
        };
        self.framed(object, &object.name, &frame)
    }

    fn fins(&mut self, object: &Object, window: &Surface, wall: &Surface) -> Result<()> {
        let number = |key| object.number_or(self.file, key, 0.0);
        let depth = |metres, share| match object.number(self.file, metres)? {
            Some(depth) => Ok(depth),
            None => Ok(object.number_or(self.file, share, 0.0)? * window.frame.width),
        };
        let fin = |x, above: f64, below: f64, tilt: Option<f64>, depth: f64| Frame {
            origin: on_wall(window, wall, x, -below),
            azimuth_deg: window.frame.azimuth_deg - (180.0 - tilt.unwrap_or(90.0)),
            tilt_deg: window.frame.tilt_deg,
            width: -depth.max(0.0),
            height: above + below + window.frame.height,
        };
        let tilt = |key| object.number(self.file, key);
        let left = fin(
            -number("left_extension_from_window_door")?,
            number("left_distance_above_top_of_window")?,
            number("left_distance_below_bottom_of_window")?,
            tilt("left_tilt_angle_from_window_door")?,
            depth("left_depth", "left_depth_as_fraction_of_window_door_width")?,
        );
        let right = fin(
            window.frame.width + number("right_extension_from_window_door")?,
            number("right_distance_above_top_of_window")?,
            number("right_distance_below_bottom_of_window")?,
            tilt("right_tilt_angle_from_window_door")?,
            depth("right_depth", "right_depth_as_fraction_of_window_door_width")?,
        );
        for (side, frame) in [("Left", left), ("Right", right)] {
            // A model gives a fin that it does not want a depth of 0.
            if frame.width != 0.0 {
                self.framed(object, &format!("{} {side}", object.name), &frame)?;
            }
        }
        Ok(())
    }
}

/// Returns a point in the plane of the wall, `x` to the right of and `y` above the lower left
/// corner of a window.
fn on_wall(window: &Surface, wall: &Surface, x: f64, y: f64) -> DVec3 {
    let (right, up) = (wall.frame.right(), wall.frame.up());
    let from = window.frame.origin - wall.frame.origin;
    wall.frame.origin + (from.dot(right) + x) * right + (from.dot(up) + y) * up
}
