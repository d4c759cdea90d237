//! Arguments of `audit`.

use std::path::PathBuf;

use clap::Args;

use super::clock_of;
use crate::cli::values::{Bytes, parse_memory};
use crate::cli::{ClockArgs, SceneArgs};
use heliotile::tables::is_time;
use heliotile::{AuditRequest, SkyModel};

#[derive(Args, Debug)]
#[command(group(clock_of("weather")))]
pub struct AuditArgs {
    /// Archive to audit
    pub archive: PathBuf,
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Weather file from which hours are sampled, 12 positions of the sun in each [default: suns
    /// from all sides]
    #[arg(long, short)]
    pub weather: Option<PathBuf>,
    /// Table of suns and skies in place of weather, as for `query`:
    /// condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2. If it has up to 64 rows, each
    /// receiver is checked under all of them
    #[arg(long, short, value_name = "FILE", conflicts_with = "weather")]
    pub conditions: Option<PathBuf>,
    /// Number of receivers to check [default: 256, or as many as --seconds allow]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub samples: Option<u32>,
    /// Number of hours to check for each receiver [default: 8, or all rows of --conditions if they
    /// are 64 or fewer]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub hours: Option<u32>,
    /// Time limit, seconds: no receiver is started after it
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    pub seconds: Option<f64>,
    /// Number of light paths that the reference path tracer follows from each receiver
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(AuditRequest::PATHS))]
    pub paths: u32,
    /// Seed of the random choice of receivers, hours and paths
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Sky radiance distribution: perez, uniform, or cie:1 to cie:16
    #[arg(long, default_value = "perez")]
    pub sky: SkyModel,
    /// Folder to write audit.csv, pictures and index.html into
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    #[command(flatten)]
    pub about_weather: ClockArgs,
}

impl AuditArgs {
    /// Returns the request of `audit`.
    pub fn request(&self) -> AuditRequest {
        AuditRequest {
            archive: self.archive.clone(),
            scene: self.scene.request(),
            weather: self.weather.clone(),
            about_weather: self.about_weather.options(false),
            conditions: self.conditions.clone(),
            samples: self.samples,
            hours: self.hours,
            seconds: self.seconds,
            paths: self.paths,
            seed: self.seed,
            sky: self.sky,
        }
    }
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| is_time(*seconds));
    seconds.ok_or_else(|| "give a number of seconds above 0".into())
}
