//! Request for an export. In: options. Out: the archive, receiver and light, and the file to write.

use std::path::PathBuf;

use crate::export::sun_position::SunPosition;
use heliotile_core::archive::Access;
use heliotile_core::error::{Error, Result, check_ranges};
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_requests::{DefaultRequest, Request};

/// Request for an export.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct ExportRequest {
    /// Archive to read, or the folder of an atlas: a path or an address.
    #[field(name = "archive", positional, required, input = Archive)]
    pub place: PathBuf,
    /// How the archive is read.
    #[field(name = "io", python = "access", default = "map", neutral)]
    pub access: Access,
    /// File to write: `.exr` or `.png` of a receiver; otherwise a table of view factors, `-` for
    /// standard output.
    #[field(skip, default = "-")]
    pub output: PathBuf,
    /// Export the layers of this receiver.
    #[field(short = 'r', metavar = "ID")]
    pub receiver: Option<String>,
    /// Draw six fisheye pictures in place of one: what is seen, the light of --sun by its paths,
    /// and their sum, on one scale.
    #[field(requires("sun"), conflicts("weather", "latitude"))]
    pub panel: bool,
    /// Azimuth (clockwise from true north) and altitude of a sun, degrees: an .exr gets maps of its
    /// light, a .png its position.
    #[field(metavar = "AZIMUTH,ALTITUDE", hyphen)]
    pub sun: Option<SunPosition>,
    /// Direct normal irradiance of that sun, W/m2.
    #[field(metavar = "W/M2", default = 0.0, requires("sun"), range = 0.0..=ExportRequest::MAX_W_M2, says = "give a number from 0 to 1000000, W/m2")]
    pub dni_w_m2: f64,
    /// Diffuse horizontal irradiance of the sky around it, W/m2.
    #[field(metavar = "W/M2", default = 0.0, requires("sun"), range = 0.0..=ExportRequest::MAX_W_M2, says = "give a number from 0 to 1000000, W/m2")]
    pub dhi_w_m2: f64,
    /// Model of the sky's radiance.
    #[field(default = "perez", requires("sun"), help = SkyModel::described)]
    pub sky: SkyModel,
    /// Number of sky patches: 145, 577 or 2305 [default: that for which the archive was built].
    #[field(requires("sun"))]
    pub patches: Option<usize>,
    /// Number of diffuse reflections that count: all, or 1 to 64 (1 counts the first one only).
    #[field(default = "all", requires("sun"))]
    pub bounces: MaxBounces,
    /// Weather file. A .png shows the sun's paths over its place (the archive's, if the file states
    /// none), with hours of the file's clock; a page of --html shows its weather.
    #[field(short = 'w', metavar = "FILE", conflicts("latitude"), input = Weather)]
    pub weather: Option<PathBuf>,
    /// Options for facts that the weather file does not state.
    #[field(
        flatten,
        without("latitude", "longitude", "shift", "weather_stamp", "date_order"),
        heading = "About the weather file",
        needs("weather")
    )]
    pub about_weather: WeatherOptions,
    /// Latitude, degrees, north positive, for which a .png shows the sun's paths; hours are mean
    /// solar time.
    #[field(metavar = "DEGREES", range = -90.0..=90.0, says = "give degrees from -90 to 90, north positive")]
    pub latitude_deg: Option<f64>,
}

impl ExportRequest {
    /// Largest irradiance that is accepted for a sun or a sky, W/m2.
    pub const MAX_W_M2: f64 = 1e6;

    /// Refuses numbers that are out of range and choices that exclude each other, before any file
    /// is read.
    pub fn check(&self) -> Result<()> {
        check_ranges(self)?;
        let excluded = |names: &str, hint: &'static str| Err(Error::argument(names, "do not go together", hint));
        match self {
            _ if self.weather.is_some() && self.latitude_deg.is_some() => {
                excluded("weather, latitude", "give one of them")
            }
            _ if self.panel && self.sun.is_none() => {
                Err(Error::argument("panel", "has no light", "give a {sun}, and {dni} or {dhi}"))
            }
            _ if self.panel && (self.weather.is_some() || self.latitude_deg.is_some()) => {
                excluded("panel, weather, latitude", "give a panel, or the paths of the sun")
            }
            _ if self.receiver.is_none()
                && (self.sun.is_some() || self.weather.is_some() || self.latitude_deg.is_some()) =>
            {
                let hint = "leave {sun}, {weather} and {latitude} out, or give a {receiver}";
                Err(Error::argument("view_factors", "do not depend on light", hint))
            }
            _ => Ok(()),
        }
    }
}
