//! Coordinate systems of files of features. In: the system that a file states, its coordinates, and
//! the system of the scene. Out: the conversion of its coordinates to metres, and a sentence on it.

use std::path::Path;

use glam::DVec2;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::{Message, message};

use crate::coordinate::is_position;
use crate::formats::wkt::TextSystem;
use crate::placing::axis_order::{Degrees, Swap};
use crate::placing::from_degrees::FromDegrees;
use crate::text::excerpt;
use heliotile_place::epsg_numbers::{Axes, axes_of};
use heliotile_place::reference::{PlaneSystem, Reference, Unplaced};

/// EPSG number of Web Mercator, whose metre is true only at the equator.
const WEB_MAPS: u32 = 3857;

/// Coordinate system that a file states.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::formats) struct FeatureSystem {
    /// EPSG number.
    pub epsg: Option<u32>,
    /// Kind of coordinates, if it is known.
    pub axes: Option<Axes>,
    /// Unit of plane coordinates, metres, if the file states it.
    pub unit_m: Option<f64>,
    /// True if the file names a system in degrees whose register has latitude first, so that
    /// writers disagree on the order.
    pub is_order_open: bool,
    /// Sentences on the file that its reader has for the user.
    pub doubts: Vec<Message>,
}

/// EPSG numbers and Esri's numbers of Web Mercator.
const OTHER_WEB_MAPS: [u32; 4] = [900_913, 102_100, 102_113, 3785];

impl FeatureSystem {
    /// Longitude and latitude on WGS 84.
    pub(in crate::formats) const WGS84: FeatureSystem = FeatureSystem {
        epsg: Some(4326),
        axes: Some(Axes::Degrees),
        unit_m: None,
        is_order_open: false,
        doubts: Vec::new(),
    };

    /// Returns the system of an EPSG number.
    pub(in crate::formats) fn of_epsg(epsg: u32) -> FeatureSystem {
        let epsg = if OTHER_WEB_MAPS.contains(&epsg) { WEB_MAPS } else { epsg };
        FeatureSystem { epsg: Some(epsg), axes: axes_of(epsg), ..FeatureSystem::default() }
    }

    /// Returns the system of well-known text; other text gives an unknown system.
    pub(in crate::formats) fn of_text(text: &str) -> FeatureSystem {
        let found = TextSystem::parse(text).unwrap_or_default();
        let known = found.epsg.map(FeatureSystem::of_epsg).unwrap_or_default();
        FeatureSystem { axes: known.axes.or(found.axes), unit_m: found.plane_unit_m, ..known }
    }

    /// Returns the unit of plane coordinates, metres; `None` for degrees and where it is unknown.
    pub(in crate::formats) fn plane_unit_m(&self) -> Option<f64> {
        if self.axes == Some(Axes::Degrees) {
            return None;
        }
        self.unit_m.or_else(|| Some(Reference::Epsg(self.epsg?).unit_m()))
    }
}

/// Conversion of the coordinates of a file to metres of the scene's system.
pub(in crate::formats) enum ToMetres {
    /// Plane coordinates, times the length of their unit in metres.
    Scaled(f64),
    /// Longitude and latitude, in this order unless latitude is first.
    Degrees { system: Box<FromDegrees>, latitude_first: bool },
    /// Plane coordinates whose metre is not a metre on the ground, converted by way of longitude
    /// and latitude.
    Plane(Box<PlaneSystem>, Box<FromDegrees>),
}

/// Conversion of the coordinates of a file, and what is known of the result.
pub(in crate::formats) struct Placing {
    pub to_metres: ToMetres,
    pub reference: Option<Reference>,
    /// True if the converted coordinates are certainly metres.
    pub in_metres: bool,
    /// Sentence on the conversion, for the user.
    pub note: Option<Message>,
    /// Sentence on an order of coordinates that is not the stated one.
    pub doubt: Option<String>,
}

impl Placing {
    /// Decides on a file with coordinates within `bounds`; `asked` is the EPSG number of the
    /// scene's system, if it has one.
    pub(in crate::formats) fn new(
        file: &Path,
        stated: &FeatureSystem,
        bounds: [DVec2; 2],
        asked: Option<u32>,
    ) -> Result<Placing> {
        let [low, high] = bounds;
        let middle = 0.5 * (low + high);
        let like_degrees = low.x >= -180.0 && high.x <= 180.0 && low.y >= -90.0 && high.y <= 90.0;
        let like_swapped = low.y >= -180.0 && high.y <= 180.0 && low.x >= -90.0 && high.x <= 90.0;
        let is_degrees = match stated.axes {
            Some(Axes::Geocentric) => {
                let hint = "reproject the file to a system in metres, such as the national grid or UTM";
                return Err(Error::input(file, None, "its coordinates are geocentric", hint));
            }
            Some(Axes::Degrees) if !like_degrees && !like_swapped => {
                let what = format!(
                    "its coordinates are stated as longitude and latitude, but reach from {:.1} {:.1} to {:.1} {:.1}",
                    low.x, low.y, high.x, high.y
                );
                let hint = "write the file with its coordinate system (GeoJSON with a `crs`, or .gpkg), or reproject it to \
                            EPSG:4326: such numbers are metres, not degrees";
                return Err(Error::input(file, None, what, hint));
            }
            axes => axes == Some(Axes::Degrees),
        };
        let to = |geographic: Option<u32>, longitude: f64, latitude: f64| {
            FromDegrees::new(geographic, asked, latitude, longitude).map_err(|why| unplaced(file, why, asked))
        };
        if is_degrees {
            let at = Degrees { latitude: middle.y, longitude: middle.x };
            let swap = match like_degrees {
                true => Swap::new(stated.epsg, asked, at, !stated.is_order_open).filter(|_| like_swapped),
                false => Some(Swap::Impossible),
            };
            let doubt = swap.map(|swap| swap.sentence(if like_degrees { at } else { impossible(bounds) }));
            let read = if swap.is_some() { at.swapped() } else { at };
            let system = to(stated.epsg, read.longitude, read.latitude)?;
            let reference = system.reference();
            let note = message!("{}: longitude and latitude are converted to metres of {reference}", file.display())
                .and(if asked.is_some() { "" } else { ", the UTM zone of its middle ({crs} sets another system)" });
            let to_metres = ToMetres::Degrees { system: Box::new(system), latitude_first: swap.is_some() };
            return Ok(Placing { to_metres, reference: Some(reference), in_metres: true, note: Some(note), doubt });
        }
        // A metre of Web Mercator is not a metre on the ground.
        if stated.epsg == Some(WEB_MAPS) && asked != Some(WEB_MAPS) {
            let plane = PlaneSystem::by_epsg(WEB_MAPS).map_err(|why| unplaced(file, why, stated.epsg))?;
            let place = plane.degrees(middle.x, middle.y);
            let (latitude, longitude) = place.ok_or_else(|| unplaced(file, Unplaced::Outside, stated.epsg))?;
            let system = to(None, longitude, latitude)?;
            let reference = system.reference();
            let note = format!(
                "{}: coordinates in Web Mercator (EPSG:{WEB_MAPS}), whose metres are not metres on the ground, are converted to metres of {reference}",
                file.display()
            );
            let to_metres = ToMetres::Plane(Box::new(plane), Box::new(system));
            return Ok(Placing {
                to_metres,
                reference: Some(reference),
                in_metres: true,
                note: Some(note.into()),
                doubt: None,
            });
        }
        let unit_m = stated.plane_unit_m();
        let reference = stated.epsg.map(Reference::Epsg);
        if reference.is_none() && like_degrees && (high - low).max_element() < 5.0 {
            let what = format!(
                "its coordinates reach from {:.5} {:.5} to {:.5} {:.5} and no coordinate system is stated",
                low.x, low.y, high.x, high.y
            );
            let hint =
                "if they are longitude and latitude, state that in the file (.prj with EPSG:4326), or write GeoJSON";
            return Err(Error::input(file, None, what, hint));
        }
        Ok(Placing {
            to_metres: ToMetres::Scaled(unit_m.unwrap_or(1.0)),
            reference,
            in_metres: unit_m.is_some(),
            note: None,
            doubt: None,
        })
    }
}

impl Placing {
    /// Returns the position in plan of a corner of the file, metres. Fails outside of the system.
    pub(in crate::formats) fn place(&self, file: &Path, at: DVec2) -> Result<DVec2> {
        self.to_metres.place(at).filter(|p| is_position(p.extend(0.0))).ok_or_else(|| {
            let what =
                format!("the corner at {:.5} {:.5} lies outside of the coordinate system of the scene", at.x, at.y);
            Error::input(file, None, what, "correct the corner, or give another system as {crs}")
        })
    }
}

impl ToMetres {
    /// Returns a position in plan, metres; `None` where the system has no such point.
    fn place(&self, at: DVec2) -> Option<DVec2> {
        match self {
            ToMetres::Scaled(unit_m) => Some(at * *unit_m),
            ToMetres::Degrees { system, latitude_first: false } => system.plane(at.y, at.x),
            ToMetres::Degrees { system, latitude_first: true } => system.plane(at.x, at.y),
            ToMetres::Plane(plane, system) => {
                let (latitude, longitude) = plane.degrees(at.x, at.y)?;
                system.plane(latitude, longitude)
            }
        }
    }
}

/// Returns the corner of some bounds whose latitude is beyond 90 degrees.
fn impossible([low, high]: [DVec2; 2]) -> Degrees {
    let corner = if low.y < -90.0 { low } else { high };
    Degrees { latitude: corner.y, longitude: corner.x }
}

fn unplaced(file: &Path, why: Unplaced, asked: Option<u32>) -> Error {
    let system = asked.map_or("UTM".to_owned(), |epsg| format!("EPSG:{epsg}"));
    let what = match why {
        Unplaced::Outside => format!("the middle of the file lies outside of {system}"),
        _ => format!("{} is not a known plane coordinate system", excerpt(system.as_bytes())),
    };
    Error::input(file, None, what, "give the EPSG code of the national grid or UTM zone of the place as {crs}")
}
