//! Place of a model's coordinates. In: geometry rules, north axes and origins of building and
//! zones. Out: vertices in the world frame, the upper left one first, counter-clockwise.
//!
//! Follows EnergyPlus' `SurfaceGeometry` (`GetVertices`, `MakeRectangularVertices`,
//! `MakeRelativeRectangularVertices`).

use std::collections::HashMap;
use std::path::Path;

use glam::{DVec2, DVec3};

use crate::formats::building::frame::Frame;
use crate::formats::energyplus::model::{Model, Object, same};
use heliotile_core::error::Result;
use heliotile_core::text::Message;

/// Frame to which coordinates are relative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Of<'n> {
    Site,
    Building,
    /// A zone, by its name.
    Zone(&'n str),
}

#[derive(Debug)]
pub(super) struct PlaceObject {
    clockwise: bool,
    /// Index of the corner that comes first: upper left, lower left, lower right, upper right.
    corner: usize,
    world: bool,
    rectangles_world: bool,
    /// Azimuth of the building's north axis, degrees clockwise from north.
    north_deg: f64,
    zones: HashMap<String, Zone>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Zone {
    north_deg: f64,
    origin: DVec3,
}

/// Turns a point from the coordinates of an axis, `degrees` clockwise from north, to those of
/// north.
fn turned(p: DVec3, degrees: f64) -> DVec3 {
    if degrees == 0.0 {
        return p;
    }
    DVec2::from_angle(-degrees.to_radians()).rotate(p.truncate()).extend(p.z)
}

impl PlaceObject {
    pub(super) fn read(model: &Model, file: &Path, warnings: &mut Vec<Message>) -> Result<PlaceObject> {
        let rules = model.of("GlobalGeometryRules").next();
        let text = |key| rules.map_or("", |rules| rules.text(key));
        let corner = text("starting_vertex_position").to_lowercase();
        let corner = ["upperleftcorner", "lowerleftcorner", "lowerrightcorner", "upperrightcorner"]
            .iter()
            .position(|name| *name == corner);
        let direction = text("vertex_entry_direction").to_lowercase();
        let system = text("coordinate_system").to_lowercase();
        let known = ["counterclockwise", "ccw", "clockwise", "cw"].contains(&direction.as_str())
            && ["relative", "world", "absolute"].contains(&system.as_str());
        if !known || corner.is_none() {
            warnings.push(
                format!(
                    "{}: GlobalGeometryRules are missing or unclear; where they state nothing else, UpperLeftCorner, \
                 Counterclockwise and, as in EnergyPlus, World are assumed",
                    file.display()
                )
                .into(),
            );
        }
        let mut zones = HashMap::new();
        for zone in model.of("Zone") {
            let number = |key| zone.number_or(file, key, 0.0);
            let origin = DVec3::new(number("x_origin")?, number("y_origin")?, number("z_origin")?);
            zones.entry(same(&zone.name)).or_insert(Zone { north_deg: number("direction_of_relative_north")?, origin });
        }
        let building = model.of("Building").next();
        let north = building.map_or(Ok(0.0), |building| building.number_or(file, "north_axis", 0.0))?;
        Ok(PlaceObject {
            clockwise: direction.starts_with("cl") || direction == "cw",
            corner: corner.unwrap_or(0),
            world: system != "relative",
            rectangles_world: ["world", "absolute"]
                .contains(&text("rectangular_surface_coordinate_system").to_lowercase().as_str()),
            north_deg: north,
            zones,
        })
    }

    pub(super) fn has_zone(&self, name: &str) -> bool {
        self.zones.contains_key(&same(name))
    }

    fn zone(&self, name: &str) -> Zone {
        self.zones.get(&same(name)).copied().unwrap_or_default()
    }

    fn placed(&self, p: DVec3, of: Of) -> DVec3 {
        match of {
            Of::Site => p,
            Of::Building => turned(p, self.north_deg),
            Of::Zone(name) => {
                let zone = self.zone(name);
                turned(turned(p, zone.north_deg) + zone.origin, self.north_deg)
            }
        }
    }

    /// Returns the vertices of a detailed surface, the upper left one first, counter-clockwise.
    pub(super) fn vertices(&self, vertices: &[[f64; 3]], of: Of) -> Vec<DVec3> {
        let of = if self.world { Of::Site } else { of };
        let mut placed: Vec<DVec3> = vertices.iter().map(|&p| self.placed(DVec3::from_array(p), of)).collect();
        if self.clockwise
            && let Some(after_first) = placed.get_mut(1..)
        {
            after_first.reverse();
        }
        if !placed.is_empty() {
            let steps = self.corner % placed.len();
            placed.rotate_right(steps);
        }
        placed
    }

    /// Returns the frame of a surface that is given by a corner, two angles and two lengths.
    pub(super) fn rectangle(&self, object: &Object, file: &Path, of: Of, tilt_deg: f64) -> Result<Frame> {
        let number = |key| object.number_or(file, key, 0.0);
        let corner =
            [number("starting_x_coordinate")?, number("starting_y_coordinate")?, number("starting_z_coordinate")?];
        // EnergyPlus turns the azimuth by the rules for detailed surfaces, and the corner by those
        // for rectangular ones.
        let turn_deg = match of {
            _ if self.world => 0.0,
            Of::Site => 0.0,
            Of::Building => self.north_deg,
            Of::Zone(name) => self.north_deg + self.zone(name).north_deg,
        };
        let of = if self.rectangles_world { Of::Site } else { of };
        let height = match object.number(file, "height")? {
            Some(height) => height,
            None => number("width")?,
        };
        Ok(Frame {
            origin: self.placed(DVec3::from_array(corner), of),
            azimuth_deg: number("azimuth_angle")? + turn_deg,
            tilt_deg: object.number_or(file, "tilt_angle", tilt_deg)?,
            width: number("length")?,
            height,
        })
    }
}
