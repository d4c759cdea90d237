//! Arguments of `buildings` and `places`, which both ask an archive for the sums of a year.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueEnum};

use crate::cli::WeatherArgs;
use crate::cli::values::{Bytes, choice, parse_memory};
use heliotile_core::archive::Access;

/// An archive and the year that it is asked for.
#[derive(Args, Debug)]
pub struct YearArgs {
    /// Archive to read, or the folder of an atlas: a path or an address
    pub archive: PathBuf,
    /// Weather file of a year: EPW, TMY3, WEA, SURFRAD, CSV or JSON of a service (NSRDB, PVGIS, Open-Meteo, Solcast) or any other; also packed (.gz, .zip)
    #[arg(long, short)]
    pub weather: PathBuf,
    /// Take y for north: suns are not turned to the true north that the archive's place tells of
    #[arg(long)]
    pub grid_north: bool,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    /// How the archive is read [default: map, or pread if the archive is large beside --memory]
    #[arg(long, value_parser = choice::<Access>())]
    pub io: Option<Access>,
    #[command(flatten)]
    pub about_weather: WeatherArgs,
}

#[derive(Args, Debug)]
pub struct BuildingsArgs {
    #[command(flatten)]
    pub year: YearArgs,
    /// Table of buildings to write: .csv, .parquet, or - for CSV on standard output
    #[arg(long, short, default_value = "-")]
    pub output: PathBuf,
    /// Also write a table of roof faces: .csv or .parquet
    #[arg(long, value_name = "FILE")]
    pub faces: Option<PathBuf>,
    /// What a place on a roof gets at least that counts as usable, kWh/m2 in the year
    #[arg(long, value_name = "KWH_M2", default_value_t = 900.0, value_parser = parse_amount, allow_hyphen_values = true)]
    pub threshold: f64,
    /// What a region of such places that touch has at least that counts as usable, m2
    #[arg(long, value_name = "M2", default_value_t = 10.0, value_parser = parse_amount, allow_hyphen_values = true)]
    pub min_area: f64,
}

#[derive(Args, Debug)]
pub struct PlacesArgs {
    #[command(flatten)]
    pub year: YearArgs,
    /// Table of places to write, which `pv --points` takes: .csv, .parquet, or - for CSV on standard output
    #[arg(long, short, default_value = "-")]
    pub output: PathBuf,
    /// How many places, the best first
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    pub best: u32,
    /// Width x height of a module, metres: the width is level, the height goes up the surface
    #[arg(long, value_name = "WxH", default_value = "1.1x1.8")]
    pub module: ModuleSize,
    /// Surfaces to look on
    #[arg(long, value_enum, default_value = "roofs")]
    pub on: PlaceOn,
    /// Height of places above their surface, metres
    #[arg(long, value_name = "M", default_value_t = 0.1, value_parser = parse_amount, allow_hyphen_values = true)]
    pub clearance: f64,
}

/// Surfaces that modules go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PlaceOn {
    Roofs,
    Facades,
    Both,
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
