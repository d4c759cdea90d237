//! Arguments of `tradeoff`.

use std::path::PathBuf;

use clap::Args;

use super::clock_of;
use crate::cli::values::{Bytes, parse_memory};
use crate::cli::{ClockArgs, SceneArgs, TableNorthArgs};
use heliotile::{EffectChoice, TradeoffRequest};

#[derive(Args, Debug)]
#[command(group(clock_of("weather")))]
pub struct TradeoffArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub table_north: TableNorthArgs,
    /// Table of receivers, CSV with columns receiver,x,y,z, tilt_deg,azimuth_deg (from true north) or
    /// nx,ny,nz, and optionally area_m2,surface; height (above the roof or ground below) may stand
    /// for z
    #[arg(long, short)]
    pub receivers: PathBuf,
    /// Folder to write tradeoff.csv, pictures and index.html into
    #[arg(long, short, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Number of receivers to try settings on, spread over the site
    #[arg(long, default_value_t = 32, value_parser = clap::value_parser!(u16).range(TradeoffRequest::SAMPLES))]
    pub sample: u16,
    /// Weather file under which errors are estimated and replays are timed [default: suns from all
    /// sides]
    #[arg(long, short)]
    pub weather: Option<PathBuf>,
    /// Also try each setting alone, and write sources.csv and a picture (takes several times as
    /// long)
    #[arg(long)]
    pub sources: bool,
    /// Light paths to trace besides direct sun and sky: `auto` (those that can matter in the
    /// scene), `all`, `none`, or some of diffuse, bounces, mirrors, canopies, leaves
    #[arg(long, value_name = "LIST", default_value_t = EffectChoice::Auto)]
    pub effects: EffectChoice,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    #[command(flatten)]
    pub about_weather: ClockArgs,
}

impl TradeoffArgs {
    /// Returns the request of `tradeoff`.
    pub fn request(&self) -> TradeoffRequest {
        TradeoffRequest {
            scene: self.scene.request_by(&self.table_north),
            receivers: self.receivers.clone(),
            folder: self.output.clone(),
            sample: self.sample,
            weather: self.weather.clone(),
            about_weather: self.about_weather.options(false),
            sources: self.sources,
            effects: self.effects,
        }
    }
}
