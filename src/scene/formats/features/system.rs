//! Coordinate systems of files of features. In: what a file states, its coordinates, the system of the scene. Out: how its coordinates become metres,
//! and a sentence on it.

use std::path::Path;

use glam::DVec2;
use heliotile_core::error::{Error, Result};

use crate::epsg_numbers::{Axes, axes_of};
use crate::formats::wkt::TextSystem;
use crate::placing::from_degrees::FromDegrees;
use crate::reference::{PlaneSystem, Reference, Unplaced};
use crate::text::excerpt;

/// The world in web maps: lengths are those of the equator.
const WEB_MAPS: u32 = 3857;

/// What a file states of its coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct FeatureSystem {
    /// Number in the EPSG register.
    pub epsg: Option<u32>,
    /// What coordinates are, if the file says so.
    pub axes: Option<Axes>,
    /// Metres a unit of plane coordinates, if the file says so.
    pub unit_m: Option<f64>,
}

impl FeatureSystem {
    /// Longitude and latitude on WGS 84.
    pub(super) const WGS84: FeatureSystem = FeatureSystem { epsg: Some(4326), axes: Some(Axes::Degrees), unit_m: None };

    /// By its number.
    pub(super) fn of_epsg(epsg: u32) -> FeatureSystem {
        FeatureSystem { epsg: Some(epsg), axes: axes_of(epsg), unit_m: None }
    }

    /// By well-known text; nothing is known of other text.
    pub(super) fn of_text(text: &str) -> FeatureSystem {
        let found = TextSystem::of(text).unwrap_or_default();
        FeatureSystem { epsg: found.epsg, axes: found.axes, unit_m: found.plane_unit_m }
    }
}

/// How coordinates of a file become metres of the scene's system.
pub(super) enum ToMetres {
    /// They are as they should be, but for their unit.
    Scaled(f64),
    /// From longitude and latitude.
    Degrees(Box<FromDegrees>),
    /// From a plane system of which a metre is none on the ground, by way of longitude and latitude.
    Plane(Box<PlaneSystem>, Box<FromDegrees>),
}

/// What was found about the coordinates of a file.
pub(super) struct Placing {
    pub to_metres: ToMetres,
    pub reference: Option<Reference>,
    /// Whether coordinates are metres for certain.
    pub in_metres: bool,
    /// What was decided.
    pub note: Option<String>,
}

impl Placing {
    /// Decides on a file whose coordinates fill a box; `asked` is the system of the scene, or none.
    pub(super) fn of(file: &Path, stated: &FeatureSystem, bounds: [DVec2; 2], asked: Option<u32>) -> Result<Placing> {
        let [low, high] = bounds;
        let middle = 0.5 * (low + high);
        let like_degrees = low.x >= -180.0 && high.x <= 180.0 && low.y >= -90.0 && high.y <= 90.0;
        let is_degrees = match stated.axes {
            Some(Axes::Geocentric) => {
                let hint = "reproject the file to a system in metres, such as the national grid or UTM";
                return Err(Error::input(file, None, "its coordinates are geocentric", hint));
            }
            Some(Axes::Degrees) if !like_degrees => {
                let what = format!(
                    "its coordinates are stated as longitude and latitude, but reach from {:.1} {:.1} to {:.1} {:.1}",
                    low.x, low.y, high.x, high.y
                );
                let hint = "they are metres of some system: write the file with its system (GeoJSON with a `crs`, or .gpkg), or \
                            reproject it to EPSG:4326";
                return Err(Error::input(file, None, what, hint));
            }
            axes => axes == Some(Axes::Degrees),
        };
        let to = |geographic: Option<u32>, longitude: f64, latitude: f64| {
            FromDegrees::new(geographic, asked, latitude, longitude).map_err(|why| unplaced(file, why, asked))
        };
        if is_degrees {
            let system = to(stated.epsg, middle.x, middle.y)?;
            let reference = system.reference();
            let note = format!(
                "{}: longitude and latitude become metres of {reference}{}",
                file.display(),
                if asked.is_some() { "" } else { ", UTM of its middle ({crs} takes another system)" }
            );
            let to_metres = ToMetres::Degrees(Box::new(system));
            return Ok(Placing { to_metres, reference: Some(reference), in_metres: true, note: Some(note) });
        }
        // A metre of web maps is none.
        if stated.epsg == Some(WEB_MAPS) && asked != Some(WEB_MAPS) {
            let plane = PlaneSystem::of(WEB_MAPS).map_err(|why| unplaced(file, why, stated.epsg))?;
            let place = plane.degrees(middle.x, middle.y);
            let (latitude, longitude) = place.ok_or_else(|| unplaced(file, Unplaced::Outside, stated.epsg))?;
            let system = to(None, longitude, latitude)?;
            let reference = system.reference();
            let note = format!(
                "{}: coordinates of web maps (EPSG:{WEB_MAPS}), whose metre is not that of the ground, become metres of {reference}",
                file.display()
            );
            let to_metres = ToMetres::Plane(Box::new(plane), Box::new(system));
            return Ok(Placing { to_metres, reference: Some(reference), in_metres: true, note: Some(note) });
        }
        let unit_m = stated.unit_m.or_else(|| Some(Reference::Epsg(stated.epsg?).unit_m()));
        let reference = stated.epsg.map(Reference::Epsg);
        if reference.is_none() && like_degrees && (high - low).max_element() < 5.0 {
            let what = format!(
                "its coordinates reach from {:.5} {:.5} to {:.5} {:.5} and no coordinate system is stated",
                low.x, low.y, high.x, high.y
            );
            let hint = "if they are longitude and latitude, write the system with the file (.prj with EPSG:4326), or write GeoJSON";
            return Err(Error::input(file, None, what, hint));
        }
        Ok(Placing {
            to_metres: ToMetres::Scaled(unit_m.unwrap_or(1.0)),
            reference,
            in_metres: unit_m.is_some(),
            note: None,
        })
    }
}

impl ToMetres {
    /// A position in plan; `None` where the system has no such point.
    pub(super) fn place(&self, at: DVec2) -> Option<DVec2> {
        match self {
            ToMetres::Scaled(unit_m) => Some(at * *unit_m),
            ToMetres::Degrees(system) => system.plane(at.y, at.x),
            ToMetres::Plane(plane, system) => {
                let (latitude, longitude) = plane.degrees(at.x, at.y)?;
                system.plane(latitude, longitude)
            }
        }
    }
}

fn unplaced(file: &Path, why: Unplaced, asked: Option<u32>) -> Error {
    let system = asked.map_or("UTM".to_owned(), |epsg| format!("EPSG:{epsg}"));
    let what = match why {
        Unplaced::Outside => format!("its middle has no coordinates in {system}"),
        _ => format!("{} is no plane system that is known here", excerpt(system.as_bytes())),
    };
    Error::input(file, None, what, "give the number of a national grid or of UTM there as {crs}")
}
