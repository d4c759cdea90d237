//! Coordinates of a file as metres east, north and up. In: names of coordinate systems, and three
//! numbers at a time. Out: positions, their coordinate system, and notes on what was decided.
//!
//! Latitude and longitude become metres of the scene's plane system, or of UTM. Latitude comes
//! first, as in the EPSG register, unless that order cannot be meant (`axis_order`). In a plane
//! system the first position of the file decides which number is the easting: the one order in
//! which a metre of the system is about a metre on the ground there. Where both orders pass, a URN
//! or address follows the register, and any other name means easting, northing.

use glam::DVec3;
use heliotile_core::text::Message;

use crate::coordinate::is_position;
use crate::formats::citygml::northing_first::is_northing_first;
use crate::formats::citygml::srs_name::SrsName;
use crate::placing::axis_order::{Degrees, STRETCH, Swap, stretch};
use crate::placing::from_degrees::FromDegrees;
use crate::text::excerpt;
use heliotile_place::epsg_numbers::{Axes, axes_of, horizontal_part};
use heliotile_place::reference::{PlaneSystem, Reference, Unplaced};

/// Reason why a position cannot be computed.
pub(super) enum Unusable {
    /// Only the object is wrong.
    Object(String),
    /// The whole file is wrong.
    File { what: String, hint: &'static str },
}

/// Coordinate system of a file.
#[derive(Default)]
pub(super) struct Coordinates {
    /// EPSG number of the scene's plane system, if it has one.
    scene: Option<u32>,
    /// First `srsName` of the file, and its meaning.
    stated: Option<(String, SrsName)>,
    /// Conversion to metres, known from the first position on.
    way: Option<Way>,
    /// Notes on decisions; each continues "the file: ".
    pub notes: Vec<Message>,
    /// Notes on doubtful statements of the file.
    pub doubts: Vec<Message>,
}

/// Conversion of numbers to metres.
enum Way {
    Plain,
    Degrees { from: Box<FromDegrees>, longitude_first: bool },
    Plane { northing_first: bool, unit_m: f64, height_unit_m: f64 },
}

impl Coordinates {
    pub(super) fn new(scene: Option<u32>) -> Coordinates {
        Coordinates { scene, ..Coordinates::default() }
    }

    /// Returns the coordinate system of the converted positions.
    pub(super) fn reference(&self) -> Option<Reference> {
        match &self.way {
            Some(Way::Degrees { from, .. }) => Some(from.reference()),
            _ => self.stated.as_ref().and_then(|(_, name)| name.epsg).map(Reference::Epsg),
        }
    }

    /// Returns true if numbers had to be converted to metres.
    pub(super) fn made_metres(&self) -> bool {
        match self.way {
            Some(Way::Degrees { .. }) => true,
            Some(Way::Plane { unit_m, .. }) => unit_m != 1.0,
            _ => false,
        }
    }

    /// Records a `srsName`; the error says what is wrong with an object that has another system
    /// than the file.
    pub(super) fn state(&mut self, text: &str) -> Result<(), String> {
        let text = text.trim();
        let name = match &self.stated {
            Some((known, _)) if known == text => return Ok(()),
            _ => SrsName::parse(text),
        };
        match &self.stated {
            Some((_, known)) if known.epsg == name.epsg => Ok(()),
            Some((known, _)) => Err(format!(
                "its coordinate system is `{}`, but objects before it are in `{}`",
                excerpt(text.as_bytes()),
                excerpt(known.as_bytes())
            )),
            // Positions were read as plain metres already.
            None if self.way.is_some() => Err(format!(
                "its coordinate system is `{}`, but objects before it state no system",
                excerpt(text.as_bytes())
            )),
            None => {
                if name.epsg.is_none() {
                    let shown = excerpt(text.as_bytes());
                    self.doubts.push(
                        format!(
                            "`srsName` is `{shown}`, which has no known EPSG code; the place on Earth stays unknown"
                        )
                        .into(),
                    );
                }
                self.stated = Some((text.to_owned(), name));
                Ok(())
            }
        }
    }

    /// Returns the position of three numbers.
    pub(super) fn place(&mut self, numbers: [f64; 3]) -> Result<DVec3, Unusable> {
        if self.way.is_none() {
            self.way = Some(self.decide(numbers)?);
        }
        let [a, b, height] = numbers;
        let found = match &self.way {
            Some(Way::Degrees { from, longitude_first }) => {
                let (latitude, longitude) = if *longitude_first { (b, a) } else { (a, b) };
                from.plane(latitude, longitude).map(|plane| plane.extend(height))
            }
            Some(Way::Plane { northing_first, unit_m, height_unit_m }) => {
                let (x, y) = if *northing_first { (b, a) } else { (a, b) };
                Some(DVec3::new(x * unit_m, y * unit_m, height * height_unit_m))
            }
            _ => Some(DVec3::new(a, b, height)),
        };
        found
            .filter(|position| is_position(*position))
            .ok_or_else(|| Unusable::Object(format!("a corner has impossible coordinates: {a} {b} {height}")))
    }

    /// Returns the conversion for a file whose first position this is.
    fn decide(&mut self, [a, b, _]: [f64; 3]) -> Result<Way, Unusable> {
        let Some((text, name)) = &self.stated else { return Ok(Way::Plain) };
        let shown = excerpt(text.as_bytes());
        let Some(epsg) = name.epsg else { return Ok(Way::Plain) };
        match axes_of(epsg) {
            Some(Axes::Geocentric) => Err(Unusable::File {
                what: format!("its coordinates are geocentric: `srsName` is `{shown}`"),
                hint: "reproject the file to a system in metres with z up, such as the national grid or UTM",
            }),
            Some(Axes::Degrees) => self.of_degrees(epsg, [a, b]),
            _ => Ok(self.of_plane(epsg, [a, b])),
        }
    }

    fn of_degrees(&mut self, epsg: u32, [a, b]: [f64; 2]) -> Result<Way, Unusable> {
        let Some((text, name)) = &self.stated else { return Ok(Way::Plain) };
        let order = |longitude_first| if longitude_first { (b, a) } else { (a, b) };
        let (latitude, longitude) = order(name.longitude_first);
        let stated = Degrees { latitude, longitude };
        let is_certain = name.is_formal || name.longitude_first;
        let swap = Swap::new(Some(epsg), self.scene, stated, is_certain);
        let read = if swap.is_some() { stated.swapped() } else { stated };
        if !read.is_in_range() {
            let what = format!("the first corner has {stated} of EPSG:{epsg}");
            return Err(Unusable::File { what, hint: "correct `srsName`: coordinates of this system are degrees" });
        }
        let from = FromDegrees::new(Some(epsg), self.scene, read.latitude, read.longitude).map_err(|why| {
            let what = match (self.scene, why) {
                (Some(scene), Unplaced::Unknown) => format!("degrees cannot be converted to metres of EPSG:{scene}"),
                _ => format!("{read} have no plane coordinates"),
            };
            Unusable::File { what, hint: "reproject the file to a system in metres, such as the national grid or UTM" }
        })?;
        if let Some(swap) = swap {
            self.doubts.push(swap.sentence(stated).into());
        } else if !is_certain && self.scene.is_none() && stated.swapped().is_in_range() {
            // Writers of such names use both orders (OGC 05-077r4 has longitude first).
            self.doubts.push(format!(
                "`srsName` is `{}`, which does not say whether latitude comes first: the first position is read as {read}; if longitude \
                 comes first, write `urn:ogc:def:crs:OGC:1.3:CRS84`",
                excerpt(text.as_bytes())
            ).into());
        }
        let longitude_first = name.longitude_first != swap.is_some();
        let reference = from.reference();
        self.notes.push(format!("latitude and longitude (EPSG:{epsg}) are converted to metres of {reference}").into());
        Ok(Way::Degrees { from: Box::new(from), longitude_first })
    }

    fn of_plane(&mut self, epsg: u32, [a, b]: [f64; 2]) -> Way {
        let Some((_, name)) = self.stated.as_ref() else { return Way::Plain };
        let (stated_unit, is_formal) = (name.height_unit_m, name.is_formal);
        let Ok(system) = PlaneSystem::by_epsg(epsg) else { return Way::Plain };
        let unit_m = system.unit_m();
        let fits = |x: f64, y: f64| stretch(epsg, x, y).is_some_and(|stretch| stretch <= STRETCH);
        let by_register = is_northing_first(horizontal_part(epsg));
        let northing_first = match (fits(a, b), fits(b, a)) {
            (true, false) => false,
            (false, true) => true,
            _ => by_register && is_formal,
        };
        if northing_first != (by_register && is_formal) {
            let order = if northing_first { "northing, easting" } else { "easting, northing" };
            self.notes.push(
                format!(
                    "coordinates are read as {order}: in the other order they lie outside of the area of EPSG:{epsg}"
                )
                .into(),
            );
        }
        let height_unit_m = stated_unit.unwrap_or(unit_m);
        if unit_m != 1.0 || height_unit_m != 1.0 {
            self.notes.push(format!(
                "coordinates are converted to metres: a unit of EPSG:{epsg} is {unit_m:.7} m, a unit of heights {height_unit_m:.7} m"
            ).into());
        }
        Way::Plane { northing_first, unit_m, height_unit_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(system: &str, scene: Option<u32>, numbers: [f64; 3]) -> Result<(DVec3, Coordinates), String> {
        let mut coordinates = Coordinates::new(scene);
        coordinates.state(system)?;
        match coordinates.place(numbers) {
            Ok(position) => Ok((position, coordinates)),
            Err(Unusable::Object(what) | Unusable::File { what, .. }) => Err(what),
        }
    }

    /// Nine systems give the position of pyproj 3.7.2 within 0.1 m: degrees with latitude first or
    /// by CRS84, swapped Gauss-Krueger, Poland in the register's order and the other, UTM zones in
    /// both orders, and feet as metres.
    #[test]
    fn positions_are_metres_east_and_north() {
        for (system, scene, numbers, expected) in [
            (
                "http://www.opengis.net/def/crs/EPSG/0/6697",
                Some(6677),
                [35.25, 139.7, 9.0],
                [-12_133.41, -83_197.58, 9.0],
            ),
            ("OGC:CRS84", Some(25832), [6.2, 54.0, 1.0], [316_483.85, 5_987_150.64, 1.0]),
            ("EPSG:31467", None, [3_375_084.7, 5_708_808.1, 7.0], [3_375_084.7, 5_708_808.1, 7.0]),
            ("urn:ogc:def:crs:EPSG::31467", None, [5_708_808.1, 3_375_084.7, 7.0], [3_375_084.7, 5_708_808.1, 7.0]),
            ("urn:ogc:def:crs:EPSG::31467", None, [3_375_084.7, 5_708_808.1, 7.0], [3_375_084.7, 5_708_808.1, 7.0]),
            ("urn:ogc:def:crs:EPSG::2180", None, [242_838.3, 750_732.5, 2.0], [750_732.5, 242_838.3, 2.0]),
            ("EPSG:2180", None, [750_732.5, 242_838.3, 2.0], [750_732.5, 242_838.3, 2.0]),
            ("EPSG:25832", None, [5_987_150.6, 316_483.8, 2.0], [316_483.8, 5_987_150.6, 2.0]),
            ("EPSG:2263+5703", None, [998_114.0, 194_309.3, 10.0], [304_225.755, 59_225.593, 10.0]),
        ] {
            let (found, _) = placed(system, scene, numbers).expect(system);
            assert!(found.distance(DVec3::from(expected)) < 0.1, "{system} {numbers:?}: {found}");
        }
        let (_, utm) = placed("EPSG:6697", None, [35.25, 139.7, 9.0]).expect("degrees");
        assert_eq!((utm.reference(), utm.made_metres(), utm.notes.len()), (Some(Reference::Epsg(32654)), true, 1));
        let (feet, _) = placed("EPSG:2263", None, [998_114.0, 194_309.3, 10.0]).expect("feet");
        assert!((feet.z - 3.048_006).abs() < 1e-6, "{feet}");
    }

    /// Positions in the wrong order are read in the other one, with a warning: a latitude beyond
    /// 90, degrees far from a German scene, Antarctica under a plain name. The plain name of a
    /// place that may be meant gets a warning, a URN none. Positions are those of pyproj 3.7.2,
    /// within 0.1 m.
    #[test]
    fn degrees_in_an_impossible_order_are_swapped() {
        for (system, scene, numbers, expected, said) in [
            ("EPSG:6697", Some(6677), [139.7, 35.25, 9.0], [-12_133.41, -83_197.58, 9.0], "no place on Earth"),
            ("EPSG:4258", Some(25832), [9.0, 52.0, 0.0], [500_000.0, 5_761_038.21, 0.0], "far outside of EPSG:25832"),
            ("EPSG:4326", None, [-77.0, 38.9, 0.0], [326_565.46, 4_307_580.85, 0.0], "in Antarctica"),
            ("EPSG:4326", None, [52.0, 9.0, 0.0], [500_000.0, 5_761_038.21, 0.0], "does not say whether"),
        ] {
            let (found, coordinates) = placed(system, scene, numbers).expect(system);
            assert!(found.distance(DVec3::from(expected)) < 0.1, "{system} {numbers:?}: {found}");
            assert!(coordinates.doubts.first().is_some_and(|doubt| doubt.contains(said)), "{:?}", coordinates.doubts);
        }
        let (_, formal) = placed("urn:ogc:def:crs:EPSG::4326", None, [52.0, 9.0, 0.0]).expect("degrees");
        assert_eq!((formal.reference(), formal.doubts.len()), (Some(Reference::Epsg(32632)), 0));
    }

    /// Four hopeless coordinates are refused: geocentric ones, numbers that are no degrees, and two
    /// systems in one file, one of which comes late.
    #[test]
    fn wrong_systems_are_named() {
        for (system, numbers, said) in
            [("EPSG:4978", [3.9e6, 3e5, 5e6], "geocentric"), ("EPSG:4326", [3.9e6, 3e5, 5.0], "latitude 3900000")]
        {
            let what = placed(system, None, numbers).err().expect(system);
            assert!(what.contains(said), "{what}");
        }
        let (_, mut first) = placed("EPSG:25832", None, [5e5, 5.8e6, 0.0]).expect("metres");
        assert!(first.state("EPSG:25832+5783").is_ok());
        assert!(first.state("EPSG:25833").is_err_and(|what| what.contains("EPSG:25832")));
        let mut late = Coordinates::new(None);
        assert!(late.place([1.0, 2.0, 3.0]).is_ok());
        assert!(late.state("EPSG:25833").is_err_and(|what| what.contains("state no system")));
    }
}
