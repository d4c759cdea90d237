//! Arguments of `buildings`.

use std::path::PathBuf;

use clap::Args;

use super::choice::choice;
use super::{Bytes, WeatherArgs, parse_memory};
use heliotile_core::archive::Access;

#[derive(Args, Debug)]
pub struct BuildingsArgs {
    /// Archive to read
    pub archive: PathBuf,
    /// Weather file of a year: EPW, TMY3, NSRDB, PVGIS or other CSV, SURFRAD; also packed with gzip (.gz)
    #[arg(long, short)]
    pub weather: PathBuf,
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

fn parse_amount(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("give a number of 0 or more".into()),
    }
}
