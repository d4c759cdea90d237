//! What is said of all files of a site: where it lies, how it is turned, in which unit. In: options of a command line, or the table
//! `[site]` of a `site.toml`. Out: numbers in range, and systems that can place coordinates.

use serde::{Deserialize, Serialize};

use heliotile_core::named::NamedValues;

use crate::reference::{Reference, Unplaced};

/// Where a site lies on Earth, how it is turned, and the unit of its files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SiteFrame {
    /// Coordinate reference system of the scene's coordinates, in place of what files say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epsg: Option<u32>,
    /// North positive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latitude_deg: Option<f64>,
    /// East positive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longitude_deg: Option<f64>,
    /// Direction of y clockwise from true north, beside the convergence of a grid: the north axis of EnergyPlus. Coordinates stay.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotate_deg: Option<f64>,
    /// Height above sea level of z = 0 of all files but rasters, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elevation_m: Option<f64>,
    /// Metres a unit of all files but rasters; of rasters in feet, too, for what they do not state themselves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// The axis that points up in files of formats that do not say it: OBJ, PLY, STL.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<UpAxis>,
}

/// The axis of a file that points up: z, with y to the north, or y, with z to the south.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// z is south.
    Y,
    /// y is north.
    Z,
}

impl NamedValues for UpAxis {
    const VALUES: &'static [(&'static str, &'static str, Self)] =
        &[("y", "y points up, z to the south", UpAxis::Y), ("z", "z points up, y to the north", UpAxis::Z)];
}

/// Metres a unit of a file, if it may be one.
pub fn check_scale(scale: f64) -> Result<f64, String> {
    // NaN compares false.
    if (1e-6..=1e6).contains(&scale) { Ok(scale) } else { Err(format!("`scale` is {scale}, not from 1e-6 to 1e6")) }
}

/// An angle of a model, if it may be one.
pub fn check_rotation(degrees: f64) -> Result<f64, String> {
    let known = (-360.0..=360.0).contains(&degrees);
    if known { Ok(degrees) } else { Err(format!("`rotate_deg` is {degrees}, not from -360 to 360")) }
}

/// A height above sea level, if it may be one.
pub fn check_elevation(metres: f64) -> Result<f64, String> {
    let known = (-1000.0..=10_000.0).contains(&metres);
    if known { Ok(metres) } else { Err(format!("`elevation_m` is {metres}, not from -1000 to 10000")) }
}

/// A system whose number says where coordinates lie.
pub fn check_epsg(epsg: u32) -> Result<u32, String> {
    match Reference::Epsg(epsg).check() {
        Ok(()) => Ok(epsg),
        Err(Unplaced::Geocentric) => Err(format!(
            "EPSG:{epsg} is geocentric, and scenes have x to the east and z up: reproject the files, for instance to UTM, and give the \
             number of that system"
        )),
        Err(Unplaced::Degrees) => Err(format!(
            "EPSG:{epsg} has coordinates in degrees, and scenes are in metres: reproject the files, for instance to UTM, and give the \
             number of that system"
        )),
        Err(_) => Err(format!(
            "EPSG:{epsg} is not known here: give the number of a plane system, such as 28992 or 25832, or a latitude and a longitude"
        )),
    }
}

impl SiteFrame {
    /// The same if every number is in range; an error says which is not.
    pub fn checked(self) -> Result<SiteFrame, String> {
        self.check().map(|()| self).map_err(|(_, what)| what)
    }

    /// The first field that is not in range, as requests call it, and what is wrong with it.
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

    /// Where it says that coordinates lie: by a system, by a place.
    pub fn references(&self) -> [Option<Reference>; 2] {
        let place = self.latitude_deg.zip(self.longitude_deg);
        let place = place.map(|(latitude_deg, longitude_deg)| Reference::Place { latitude_deg, longitude_deg });
        [self.epsg.map(Reference::Epsg), place]
    }

    /// What another frame states, and for the rest this one.
    pub(crate) fn under(self, other: &SiteFrame) -> SiteFrame {
        SiteFrame {
            epsg: other.epsg.or(self.epsg),
            latitude_deg: other.latitude_deg.or(self.latitude_deg),
            longitude_deg: other.longitude_deg.or(self.longitude_deg),
            rotate_deg: other.rotate_deg.or(self.rotate_deg),
            elevation_m: other.elevation_m.or(self.elevation_m),
            scale: other.scale.or(self.scale),
            up: other.up.or(self.up),
        }
    }

    /// What two frames state together; an error names what they state differently.
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
