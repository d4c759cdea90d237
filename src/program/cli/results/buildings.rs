//! Arguments of `buildings` and `places`, which both use the sums of a year.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;

use super::SiteArgs;
use crate::cli::WeatherArgs;
use crate::cli::values::{choice, table_help};
use heliotile::{
    BuildingsRequest, Component, ComponentList, Every, LightChoice, PlaceOn, PlacesRequest, ReplayRequest,
};

/// An archive and the weather of a year.
#[derive(Args, Debug)]
pub struct YearArgs {
    #[command(flatten)]
    pub site: SiteArgs,
    /// Weather file of a year: EPW, TMY3, WEA, SURFRAD, CSV or JSON of a service (NSRDB, PVGIS,
    /// Open-Meteo, Solcast), or any CSV or JSON with `time` and some of ghi, dni, dhi; also packed
    /// (.gz, .zip)
    #[arg(long, short)]
    pub weather: PathBuf,
    #[command(flatten)]
    pub about_weather: WeatherArgs,
}

impl YearArgs {
    /// Returns the request for totals over the weather file.
    pub fn request(&self) -> ReplayRequest {
        let columns = Some(ComponentList::of(Component::Total));
        ReplayRequest {
            light: LightChoice { columns, ..LightChoice::default() },
            about_weather: self.about_weather.options(false),
            every: Every::Total,
            ..ReplayRequest::of(&self.weather)
        }
    }
}

#[derive(Args, Debug)]
pub struct BuildingsArgs {
    #[command(flatten)]
    pub year: YearArgs,
    #[arg(long, short, default_value = "-", help = table_help("Table of buildings to write"))]
    pub output: PathBuf,
    /// Also write a table of roof faces; its ending chooses the format, as for --output
    #[arg(long, value_name = "FILE")]
    pub faces: Option<PathBuf>,
    /// Least irradiation of a usable place on a roof, kWh/m2 over the weather file
    #[arg(long, value_name = "KWH_M2", default_value_t = BuildingsRequest::default().threshold_kwh_m2, value_parser = parse_amount, allow_hyphen_values = true)]
    pub threshold: f64,
    /// Least area of a usable region, m2: usable places that touch one another
    #[arg(long, value_name = "M2", default_value_t = BuildingsRequest::default().least_m2, value_parser = parse_amount, allow_hyphen_values = true)]
    pub min_area: f64,
}

impl BuildingsArgs {
    /// Returns the request of `buildings`.
    pub fn request(&self) -> BuildingsRequest {
        BuildingsRequest {
            output: self.output.clone(),
            faces: self.faces.clone(),
            threshold_kwh_m2: self.threshold,
            least_m2: self.min_area,
        }
    }
}

#[derive(Args, Debug)]
pub struct PlacesArgs {
    #[command(flatten)]
    pub year: YearArgs,
    #[arg(long, short, default_value = "-", help = table_help("Table of places to write; as CSV, `pv --points` reads it"))]
    pub output: PathBuf,
    /// Number of places, the best first
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    pub best: u32,
    /// Width x height of a module, metres: the width is horizontal, the height goes up the surface
    #[arg(long, value_name = "WxH", default_value = "1.1x1.8")]
    pub module: ModuleSize,
    /// Surfaces to search for places
    #[arg(long, value_parser = choice::<PlaceOn>(), default_value = "roofs")]
    pub on: PlaceOn,
    /// Height of modules above their surface, metres
    #[arg(long, value_name = "M", default_value_t = 0.1, value_parser = parse_amount, allow_hyphen_values = true)]
    pub clearance: f64,
}

impl PlacesArgs {
    /// Returns the request of `places`.
    pub fn request(&self) -> PlacesRequest {
        PlacesRequest {
            output: self.output.clone(),
            best: self.best as usize,
            module_m: self.module.0,
            on: self.on,
            clearance_m: self.clearance,
        }
    }
}

/// Width and height of a module, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModuleSize(pub [f64; 2]);

impl FromStr for ModuleSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let metres = |side: &str| side.trim().parse().ok().filter(|metres| (0.01..=100.0).contains(metres));
        let sides = text.split_once(['x', 'X']).and_then(|(width, height)| Some([metres(width)?, metres(height)?]));
        sides.map(ModuleSize).ok_or_else(|| "give width and height in metres, 0.01 to 100, as in 1.1x1.8".into())
    }
}

fn parse_amount(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("give a number of 0 or more".into()),
    }
}
