//! Arguments of `run`.

use std::path::PathBuf;

use clap::Args;

use super::{AccuracyArgs, Bytes, CoverArgs, SceneArgs, WeatherArgs, parse_memory};

#[derive(Args, Debug)]
pub struct RunArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Weather file: EPW, TMY3, NSRDB, PVGIS or other CSV, SURFRAD; also packed with gzip (.gz)
    #[arg(long, short)]
    pub weather: PathBuf,
    /// Folder for receivers.csv, site.helio, annual.csv and annual.ply [default: the name of the first scene file, with .sun]
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub cover: CoverArgs,
    /// Receivers to take in place of those that cover surfaces: receiver,x,y,z,nx,ny,nz and optionally area,surface
    #[arg(long, short, conflicts_with_all = ["on", "spacing", "per_surface", "offset", "min_area"])]
    pub receivers: Option<PathBuf>,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    #[command(flatten)]
    pub about_weather: WeatherArgs,
}
