//! The command line of `export`.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};

use crate::cli::sites::{parse_latitude, parse_time_zone};
use crate::cli::values::{Bytes, choice, parse_depth, parse_memory, table_help};
use heliotile::atlas::{ExportRequest, SunPosition};
use heliotile::{Access, ClockZone, MaxBounces, PageRequest, SkyModel, WeatherOptions};

/// Text of `export --help` on images.
const IMAGES: &str = "\
An .exr file has three parts, or four if the receiver sees sky in mirrors (f32, texels of equal solid angle, see schema/layers.md). The attribute
`heliotile` of each part describes its contents as JSON. Parts and their channels:
  sky       upper hemisphere of the world, first line towards y: visible, weight_sr; with --sun also sky_direct, sun_direct
  hit       hemisphere of the surface, first line up the surface: class (1 ground, 2 obstruction), material, cell, mirrors
            passed, weight_sr; with --sun also sun_reflected, sky_reflected: the radiance of what is seen there
  response  upper hemisphere of the world: ground.x to obstruction.z, reflected light by the direction of its source;
            with --sun also weight_sr, sky_reflected: the radiance of the sky there
  mirror    upper hemisphere of the world, by the direction that light has in the sky: weight_sr;
            with --sun also sky_mirrored, sun_mirrored
Behind canopies, `sky` also has `through`, the share of light that passes them. Channels named like a column of `query` are radiances, W/(m2 sr):
their sum over the texels of a part, each times weight_sr, is that column.

A .png shows the upper hemisphere, equidistant (fisheye), zenith in the middle, y up, x right as on a map, N at true north. With --weather or
--latitude it shows the sun's paths at the solstices and equinoxes, and the sun's position at each full hour through the year. With --panel and
--sun it has six pictures as a camera on the surface sees them: what is seen, then radiances of the sky, of sunlit surfaces, of sun and sky in
mirrors and of skylit surfaces, and their sum, on one logarithmic scale; the irradiance of each, in W/m2, stands above it.";

#[derive(Args, Debug)]
#[command(after_long_help = IMAGES)]
#[command(group(ArgGroup::new("subject").required(true).args(["receiver", "view_factors", "html"])))]
pub struct ExportArgs {
    /// Archive to read, or the folder of an atlas: a path or an address
    pub archive: PathBuf,
    #[arg(long, short, required_unless_present = "html", help = table_help("File to write: .exr or .png for a receiver; for view factors"))]
    pub output: Option<PathBuf>,
    /// Export the layers of this receiver
    #[arg(long, short, value_name = "ID")]
    pub receiver: Option<String>,
    /// Export the shares of every receiver's hemisphere that are sky, ground, obstructions and
    /// nothing (they sum to 1)
    #[arg(long, conflicts_with_all = ["sun", "weather", "latitude"])]
    pub view_factors: bool,
    /// Write a page that shows the archive in a browser, as `view` does, but needs no server. An
    /// archive of up to 50 MB is inside the page, with the weather file if one is given; for a
    /// larger one the page asks for the file
    #[arg(long, value_name = "PAGE.html", conflicts_with_all = ["output", "sun", "latitude", "time_zone"])]
    pub html: Option<PathBuf>,
    /// Archive of the same site after a change, for the page of --html: it shows before, after and
    /// the change, as `view --with` does
    #[arg(long, value_name = "AFTER", conflicts_with_all = ["receiver", "view_factors"])]
    pub with: Option<PathBuf>,
    /// Draw six fisheye pictures in place of one: what is seen, the light of --sun by its paths,
    /// and their sum, on one scale
    #[arg(long, requires = "sun", conflicts_with_all = ["weather", "latitude"])]
    pub panel: bool,
    /// Azimuth (clockwise from true north) and altitude of a sun, degrees: an .exr gets maps of its
    /// light, a .png its position
    #[arg(long, value_name = "AZIMUTH,ALTITUDE", allow_hyphen_values = true)]
    pub sun: Option<SunPosition>,
    /// Direct normal irradiance of that sun, W/m2
    #[arg(long, value_name = "W/M2", default_value_t = 0.0, value_parser = parse_irradiance, requires = "sun", allow_negative_numbers = true)]
    pub dni: f64,
    /// Diffuse horizontal irradiance of the sky around it, W/m2
    #[arg(long, value_name = "W/M2", default_value_t = 0.0, value_parser = parse_irradiance, requires = "sun", allow_negative_numbers = true)]
    pub dhi: f64,
    #[arg(long, help = SkyModel::described(), default_value = "perez", requires = "sun")]
    pub sky: SkyModel,
    /// Number of sky patches: 145, 577 or 2305 [default: that for which the archive was built]
    #[arg(long, requires = "sun")]
    pub patches: Option<usize>,
    /// Number of diffuse reflections that count: all, or 1 to 64 (1 counts the first one only)
    #[arg(long, default_value = "all", value_parser = parse_depth, requires = "sun")]
    pub bounces: MaxBounces,
    /// Weather file. A .png shows the sun's paths over its place (the archive's, if the file states
    /// none), with hours of the file's clock; a page of --html shows its weather
    #[arg(long, short, value_name = "FILE", conflicts_with = "latitude")]
    pub weather: Option<PathBuf>,
    /// Time zone of the weather file's clock, such as +01:00, -7 or UTC, in place of that of the
    /// file
    #[arg(long, value_name = "ZONE", requires = "weather", allow_hyphen_values = true, value_parser = parse_time_zone)]
    pub time_zone: Option<ClockZone>,
    /// Latitude, degrees, north positive, for which a .png shows the sun's paths; hours are mean
    /// solar time
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = parse_latitude)]
    pub latitude: Option<f64>,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    /// How the archive is read
    #[arg(long, value_parser = choice::<Access>(), default_value = "map")]
    pub io: Access,
}

impl ExportArgs {
    /// Returns the file to write; one of `--output` and `--html` is always given.
    pub fn output(&self) -> &Path {
        self.output.as_deref().or(self.html.as_deref()).unwrap_or(Path::new("-"))
    }

    /// Returns the request for a page, if one is requested.
    pub fn page(&self) -> Option<PageRequest> {
        Some(PageRequest {
            archive: self.archive.clone(),
            with: self.with.clone(),
            access: self.io,
            weather: self.weather.clone(),
            about_weather: WeatherOptions::default(),
            output: self.html.clone().filter(|_| self.receiver.is_none())?,
        })
    }

    /// Returns the request for images or view factors.
    pub fn request(&self) -> ExportRequest {
        ExportRequest {
            place: self.archive.clone(),
            access: self.io,
            output: self.output().into(),
            receiver: self.receiver.clone(),
            panel: self.panel,
            sun: self.sun,
            dni_w_m2: self.dni,
            dhi_w_m2: self.dhi,
            sky: self.sky,
            patches: self.patches,
            bounces: self.bounces,
            weather: self.weather.clone(),
            about_weather: WeatherOptions { zone: self.time_zone, ..WeatherOptions::default() },
            latitude_deg: self.latitude,
        }
    }
}

fn parse_irradiance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=ExportRequest::MOST_W_M2).contains(&value) => Ok(value),
        _ => Err("give a number from 0 to 1000000, W/m2".into()),
    }
}
