//! Arguments of `pv`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};

use super::recombine::parse_share;
use crate::cli::values::{Bytes, choice, parse_memory, table_endings};
use crate::cli::{AccuracyArgs, ClockArgs, SceneArgs, TableNorthArgs};
use heliotile::{PvRequest, SkyModel, Snow, StampedAt};

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("modules").required(true).args(["points", "rows"])))]
pub struct PvArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub table_north: TableNorthArgs,
    /// Weather file: EPW, TMY3, WEA, SURFRAD, CSV or JSON of a service (NSRDB, PVGIS, Open-Meteo,
    /// Solcast), or any CSV or JSON with `time` and some of ghi, dni, dhi; also packed (.gz, .zip)
    #[arg(long, short)]
    pub weather: PathBuf,
    /// Positions of modules, CSV with columns point,x,y, z or height (metres above the roof or
    /// ground below), and tilt_deg,azimuth_deg (from true north; may be left out with --search)
    #[arg(long, short, value_name = "FILE")]
    pub points: Option<PathBuf>,
    /// Rows of modules, TOML: each [[rows]] has a name, an area or surface, tilt, azimuth, pitch,
    /// width, height. Modules shade each other, reflect light to each other, and have a front and a
    /// rear. `ground = 0.5` adds receivers on the ground among the rows, 0.5 m apart, with the
    /// light that plants use
    #[arg(long, short, value_name = "FILE")]
    pub rows: Option<PathBuf>,
    /// Bifaciality, the share of the light on the rear that is added to that on the front, for
    /// poa_global and the gain
    #[arg(long, default_value_t = 0.8, value_parser = parse_bifaciality)]
    pub bifaciality: f64,
    /// Folder to write: points.csv, months.csv, ground.csv, ground_months.csv, hourly.csv,
    /// horizon/, best.csv and the archive site.helio
    #[arg(long, short, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Find the best tilt and azimuth of every point: best.csv, search.csv and a picture of each;
    /// points without angles get the best ones
    #[arg(long, requires = "points")]
    pub search: bool,
    /// Range of tilts for --search, degrees, such as 10..60, or one tilt
    #[arg(long, value_name = "FROM..TO", default_value = "0..90", value_parser = parse_tilts)]
    pub tilts: [f64; 2],
    /// Range of azimuths for --search, degrees clockwise from true north, such as 90..270, or
    /// 300..60 through north, or one azimuth
    #[arg(long, value_name = "FROM..TO", default_value = "0..360", value_parser = parse_azimuths)]
    pub azimuths: [f64; 2],
    #[arg(long, help = SkyModel::described(), default_value = "perez")]
    pub sky: SkyModel,
    /// Ending of the table of hours, which chooses its format
    #[arg(long, value_parser = table_endings(), default_value = "csv")]
    pub format: String,
    /// Write no hourly table, sums only
    #[arg(long, conflicts_with = "format")]
    pub no_hourly: bool,
    /// Time that labels a row of hours: the start, middle or end of its interval
    #[arg(long, value_parser = choice::<StampedAt>(), default_value = "start")]
    pub stamp: StampedAt,
    /// Year of all dates in results, such as 2019; sun positions stay those of the weather file's
    /// dates
    #[arg(long, value_parser = clap::value_parser!(i32).range(1..=2999))]
    pub year: Option<i32>,
    /// Take the reflectance of all ground from the weather file: its snow depth
    /// (--snow-reflectance from 1 cm on) or its albedo
    #[arg(long, value_parser = choice::<Snow>())]
    pub snow: Option<Snow>,
    /// Diffuse reflectance of snow
    #[arg(long, default_value_t = 0.6, value_parser = parse_share, requires = "snow")]
    pub snow_reflectance: f64,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Replace results in the folder that are of another scene, points, accuracy or weather;
    /// without this option they are an error
    #[arg(long)]
    pub replace: bool,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    #[command(flatten)]
    pub about_weather: ClockArgs,
}

impl PvArgs {
    /// Returns the request of `pv`.
    pub fn request(&self) -> PvRequest {
        PvRequest {
            scene: self.scene.request_by(&self.table_north),
            weather: self.weather.clone(),
            about_weather: self.about_weather.options(false),
            points: self.points.clone(),
            rows: self.rows.clone(),
            bifaciality: self.bifaciality,
            folder: self.output.clone(),
            search: self.search,
            tilts_deg: self.tilts,
            azimuths_deg: self.azimuths,
            sky: self.sky,
            format: self.format.clone(),
            hourly: !self.no_hourly,
            stamp: self.stamp,
            year: self.year,
            snow: self.snow,
            snow_reflectance: self.snow_reflectance,
            accuracy: self.accuracy.request_beside(Some(&self.weather), &self.about_weather),
            replace: self.replace,
        }
    }
}

fn parse_bifaciality(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("give a share from 0 to 1, as in 0.8".into()),
    }
}

/// Parses `10..60`, or one number for both ends.
fn parse_range(text: &str) -> Result<[f64; 2], String> {
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{part}` is not a number: give degrees, as in 10..60")),
    };
    match text.split_once("..") {
        Some((from, to)) => Ok([number(from)?, number(to)?]),
        None => Ok([number(text)?; 2]),
    }
}

fn parse_tilts(text: &str) -> Result<[f64; 2], String> {
    match parse_range(text)? {
        [from, to] if 0.0 <= from && from <= to && to <= 180.0 => Ok([from, to]),
        _ => Err("tilts are from 0 (up) to 180 (down), the smaller one first".into()),
    }
}

fn parse_azimuths(text: &str) -> Result<[f64; 2], String> {
    let [from, to] = parse_range(text)?;
    if [from, to].iter().any(|azimuth| azimuth.abs() > 360.0) {
        return Err("azimuths are from -360 to 360, clockwise from true north".into());
    }
    let to = if to < from { to + 360.0 } else { to };
    if to - from > 360.0 {
        Err("the range is more than a full circle: give azimuths as in 90..270".into())
    } else {
        Ok([from, to])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ranges, one number and a sector over north are read; 7 wrong texts are refused.
    #[test]
    fn ranges_of_azimuths_may_cross_north() {
        assert_eq!((parse_tilts("10..60"), parse_tilts("30")), (Ok([10.0, 60.0]), Ok([30.0, 30.0])));
        assert_eq!((parse_azimuths("300..60"), parse_azimuths("180")), (Ok([300.0, 420.0]), Ok([180.0, 180.0])));
        assert_eq!(parse_azimuths("-90..90"), Ok([-90.0, 90.0]));
        for text in ["", "200", "60..10", "a..b", "-1..30"] {
            assert!(parse_tilts(text).is_err(), "{text}");
        }
        assert!(parse_azimuths("-360..360").is_err() && parse_azimuths("0..400").is_err());
    }
}
