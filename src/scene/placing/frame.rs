//! Frame of a site: the place, rotation and unit of all its files. In: options of a command line,
//! or the table `[site]` of a `site.toml`. Out: numbers in range, and systems that can place
//! coordinates.

use heliotile_requests::{Parse, Request, Wrong};
use serde::{Deserialize, Serialize};

use heliotile_core::named::NamedValues;

use heliotile_place::reference::{Reference, Unplaced};

/// Place of a site on Earth, its rotation, and the unit of its files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, Request)]
#[serde(deny_unknown_fields)]
pub struct SiteFrame {
    /// Coordinate reference system of the scene's coordinates, in metres: EPSG:28992 or 28992.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(name = "crs", metavar = "EPSG", parse = parse_crs)]
    pub epsg: Option<u32>,
    /// Latitude of the scene, degrees, north positive; y is then true north, unless a coordinate
    /// system states otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "DEGREES", requires("longitude"), range = -90.0..=90.0, says = "give degrees from -90 to 90, north positive")]
    pub latitude_deg: Option<f64>,
    /// Longitude of the scene, degrees, east positive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "DEGREES", requires("latitude"), range = -180.0..=180.0, says = "give degrees from -180 to 180, east positive")]
    pub longitude_deg: Option<f64>,
    /// Angle of the model's y axis from north, degrees, clockwise as seen from above (the north
    /// axis of EnergyPlus); coordinates stay.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "DEGREES", name = "rotate_deg", parse = parse_rotation)]
    pub rotate_deg: Option<f64>,
    /// Count azimuths in the table of points from the y axis, in place of true north.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub grid_north: bool,
    /// Height above sea level of z = 0, metres, for all files but terrain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "METRES", parse = parse_elevation)]
    pub elevation_m: Option<f64>,
    /// Metres per unit of all files but terrain: 0.001 for millimetres. 0.3048 and 0.3048006 (feet)
    /// also apply to terrain whose file does not state its unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "METRES", parse = parse_scale)]
    pub scale: Option<f64>,
    /// The axis that points up in OBJ, PLY and STL files: z, with y to the north, or y, with z to
    /// the south [default: z].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "AXIS", parse = parse_up)]
    pub up: Option<UpAxis>,
}

/// Axis of a file that points up: z, with y to the north, or y, with z to the south.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// y points up and z points south.
    Y,
    /// z points up and y points north.
    Z,
}

impl NamedValues for UpAxis {
    const VALUES: &'static [(&'static str, &'static str, Self)] =
        &[("y", "y points up, z to the south", UpAxis::Y), ("z", "z points up, y to the north", UpAxis::Z)];
}

/// Checks that a scale, metres a unit, is within range.
pub fn check_scale(scale: f64) -> Result<f64, String> {
    // NaN compares false.
    if (1e-6..=1e6).contains(&scale) { Ok(scale) } else { Err(format!("`scale` is {scale}, not from 1e-6 to 1e6")) }
}

/// Checks that the rotation of a model is within range.
pub fn check_rotation(degrees: f64) -> Result<f64, String> {
    let known = (-360.0..=360.0).contains(&degrees);
    if known { Ok(degrees) } else { Err(format!("`rotate_deg` is {degrees}, not from -360 to 360")) }
}

/// Checks that a height above sea level is within range.
pub fn check_elevation(metres: f64) -> Result<f64, String> {
    let known = (-1000.0..=10_000.0).contains(&metres);
    if known { Ok(metres) } else { Err(format!("`elevation_m` is {metres}, not from -1000 to 10000")) }
}

/// Checks that a system can place plane coordinates.
pub fn check_epsg(epsg: u32) -> Result<u32, String> {
    match Reference::Epsg(epsg).check() {
        Ok(()) => Ok(epsg),
        Err(Unplaced::Geocentric) => Err(format!(
            "EPSG:{epsg} is geocentric, but scenes have x to the east and z up: reproject the files, for instance to UTM, and give the \
             number of that system"
        )),
        Err(Unplaced::Degrees) => Err(format!(
            "EPSG:{epsg} has coordinates in degrees, but scenes are in metres: reproject the files, for instance to UTM, and give the \
             number of that system"
        )),
        Err(_) => Err(format!(
            "EPSG:{epsg} is not known here: give the number of a plane system, such as 28992 or 25832, or a latitude and a longitude"
        )),
    }
}

impl SiteFrame {
    /// Returns the frame if every number is in range; an error names the number that is not.
    pub fn checked(self) -> Result<SiteFrame, String> {
        self.check().map(|()| self).map_err(|(_, what)| what)
    }

    /// Checks that every number is in range; an error names the first field that is not, as
    /// requests call it, and the fault.
    pub(crate) fn check(&self) -> Result<(), (&'static str, String)> {
        let degrees = |name: &str, value: Option<f64>, most: f64| match value {
            Some(value) if !(-most..=most).contains(&value) => {
                Err(format!("`{name}` is {value}, not from -{most} to {most}"))
            }
            _ => Ok(()),
        };
        let of = |field: &'static str| move |what: String| (field, what);
        degrees("latitude_deg", self.latitude_deg, 90.0).map_err(of("latitude"))?;
        degrees("longitude_deg", self.longitude_deg, 180.0).map_err(of("longitude"))?;
        if self.latitude_deg.is_some() != self.longitude_deg.is_some() {
            let what = "a latitude and a longitude belong together, one of them is missing";
            return Err(("latitude, longitude", what.to_owned()));
        }
        self.epsg.map(check_epsg).transpose().map_err(of("crs"))?;
        self.rotate_deg.map(check_rotation).transpose().map_err(of("rotate_deg"))?;
        self.elevation_m.map(check_elevation).transpose().map_err(of("elevation"))?;
        self.scale.map(check_scale).transpose().map_err(of("scale"))?;
        Ok(())
    }

    /// Returns the stated places of coordinates: by a system, and by latitude and longitude.
    pub fn references(&self) -> [Option<Reference>; 2] {
        let place = self.latitude_deg.zip(self.longitude_deg);
        let place = place.map(|(latitude_deg, longitude_deg)| Reference::Place { latitude_deg, longitude_deg });
        [self.epsg.map(Reference::Epsg), place]
    }

    /// Returns the values that `other` states, and this frame's values for the rest.
    pub(crate) fn under(self, other: &SiteFrame) -> SiteFrame {
        SiteFrame {
            epsg: other.epsg.or(self.epsg),
            latitude_deg: other.latitude_deg.or(self.latitude_deg),
            longitude_deg: other.longitude_deg.or(self.longitude_deg),
            rotate_deg: other.rotate_deg.or(self.rotate_deg),
            grid_north: other.grid_north || self.grid_north,
            elevation_m: other.elevation_m.or(self.elevation_m),
            scale: other.scale.or(self.scale),
            up: other.up.or(self.up),
        }
    }

    /// Returns the values of both frames together; an error names the field that they state
    /// differently.
    pub(crate) fn joined(self, other: &SiteFrame) -> Result<SiteFrame, &'static str> {
        let differ = |a: Option<f64>, b: Option<f64>| a.zip(b).is_some_and(|(a, b)| a != b);
        let found = [
            ("epsg", self.epsg.zip(other.epsg).is_some_and(|(a, b)| a != b)),
            ("latitude_deg", differ(self.latitude_deg, other.latitude_deg)),
            ("longitude_deg", differ(self.longitude_deg, other.longitude_deg)),
            ("rotate_deg", differ(self.rotate_deg, other.rotate_deg)),
            ("elevation_m", differ(self.elevation_m, other.elevation_m)),
            ("scale", differ(self.scale, other.scale)),
            ("up", self.up.zip(other.up).is_some_and(|(a, b)| a != b)),
        ];
        match found.into_iter().find(|(_, differ)| *differ) {
            Some((key, _)) => Err(key),
            None => Ok(self.under(other)),
        }
    }
}

heliotile_core::parse_by_name!(UpAxis);

/// Reads `EPSG:28992`, `epsg:28992` or `28992`.
pub fn parse_crs(text: &str) -> Result<u32, String> {
    let upper = text.trim().to_ascii_uppercase();
    let digits = upper.strip_prefix("EPSG:").unwrap_or(&upper);
    let number = digits.parse().map_err(|_| "give the number of a system in the EPSG register, such as EPSG:28992")?;
    check_epsg(number)
}

fn parse_rotation(text: &str) -> Result<f64, Wrong> {
    Ok(check_rotation(f64::parse(text)?)?)
}

fn parse_elevation(text: &str) -> Result<f64, Wrong> {
    Ok(check_elevation(f64::parse(text)?)?)
}

fn parse_scale(text: &str) -> Result<f64, Wrong> {
    Ok(check_scale(f64::parse(text)?)?)
}

fn parse_up(text: &str) -> Result<UpAxis, String> {
    UpAxis::parse(&text.to_ascii_lowercase()).map_err(|_| "give y or z".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three spellings of RD New are 28992. A system in degrees, an unknown one and a name are
    /// refused with a hint. Two axes may point up.
    #[test]
    fn three_spellings_name_one_system() {
        for text in ["28992", "EPSG:28992", " epsg:28992"] {
            assert_eq!(parse_crs(text), Ok(28992), "{text}");
        }
        for (text, word) in [("4326", "degrees"), ("EPSG:99999", "not known"), ("RD New", "such as EPSG:28992")] {
            assert!(parse_crs(text).expect_err(text).contains(word), "{text}");
        }
        for (text, axis) in [("y", Some(UpAxis::Y)), ("Z", Some(UpAxis::Z)), ("x", None)] {
            assert_eq!(parse_up(text).ok(), axis, "{text}");
        }
        assert!(parse_scale("nan").is_err());
    }
}
