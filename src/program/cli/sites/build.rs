//! Arguments of `build` and `plan`.

use std::path::PathBuf;

use clap::Args;

use super::quality::parse_preview;
use super::{clock_of, weather_files};
use crate::cli::values::{Bytes, choice, parse_memory};
use crate::cli::{AccuracyArgs, ClockArgs, Percent, SceneArgs, TableNorthArgs, parse_negligible};
use heliotile::{EffectChoice, Share};

/// Options that `--part` excludes, as the plan of an atlas states their values.
const PLANNED: [&str; 24] = [
    "receivers",
    "output",
    "materials",
    "materials_only",
    "no_ground",
    "assume_version",
    "crs",
    "latitude",
    "longitude",
    "rotate_deg",
    "grid_north",
    "elevation",
    "scale",
    "up",
    "effects",
    "negligible",
    "preview",
    "weather",
    "store",
    "no_scene",
    "error",
    "set",
    "quality",
    "share",
];

#[derive(Args, Debug)]
#[command(group(clock_of("weather_files")), group(weather_files()))]
pub struct BuildArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub table_north: TableNorthArgs,
    /// Table of receivers, CSV with columns receiver,x,y,z, tilt_deg,azimuth_deg (from true north) or
    /// nx,ny,nz, and optionally area_m2,surface; height (above the roof or ground below) may stand
    /// for z
    #[arg(long, short)]
    pub receivers: Option<PathBuf>,
    /// Archive to write
    #[arg(long, short, value_name = "SITE.helio")]
    pub output: Option<PathBuf>,
    /// Build one part of an atlas, by its name or number, or `all` parts. SCENE is then the folder
    /// or address of the atlas, which states inputs and settings
    #[arg(long, value_name = "K", conflicts_with_all = PLANNED)]
    pub part: Option<String>,
    /// Seconds between checkpoints: a crash loses no more work than this
    #[arg(long, value_name = "SECONDS", default_value_t = 30, value_parser = parse_seconds)]
    pub checkpoint: u32,
    /// Discard an interrupted build at the output path and start again. Without this option a build
    /// of the same inputs is resumed, and a build of other inputs is an error
    #[arg(long)]
    pub fresh: bool,
    /// Sharing of probes (traced samples of what the surroundings see) between receivers
    #[arg(long, value_parser = choice::<Share>(), default_value = "cells", conflicts_with = "error")]
    pub share: Share,
    /// Light paths to trace besides direct sun and sky: `auto` (those that can matter in the
    /// scene), `all`, `none`, or some of diffuse, bounces, mirrors, canopies, leaves
    #[arg(long, value_name = "LIST", default_value_t = EffectChoice::Auto)]
    pub effects: EffectChoice,
    /// Leave out light paths that add no more than this share of the sum over --weather, in any
    /// group of receivers, such as 0.5%
    #[arg(long, value_name = "PERCENT", value_parser = parse_negligible, requires = "weather", conflicts_with = "effects")]
    pub negligible: Option<Percent>,
    /// Weather file of --negligible: light paths are left out by what they add under it
    #[arg(long, short, value_name = "FILE", requires = "negligible")]
    pub weather: Option<PathBuf>,
    /// Cache folder with traces of earlier builds of any project: what it holds is not traced
    /// again, and the traces of this build are added
    #[arg(long, value_name = "FOLDER")]
    pub store: Option<PathBuf>,
    /// Archive of this scene before a change, or with --part an atlas of it; a path or an address.
    /// Only light that the change can alter is traced; the new archive has the same bytes as
    /// without this option
    #[arg(long, value_name = "BEFORE.helio")]
    pub from: Option<PathBuf>,
    /// Keep light of --from that the change alters by less than this share of the light on open
    /// ground, on average over the sky, such as 1%. The new archive is marked as a preview; the
    /// same command without this option completes it
    #[arg(long, value_name = "PERCENT", value_parser = parse_preview, requires = "from")]
    pub preview: Option<Percent>,
    /// Leave the scene's triangles out of the archive, if they may not be passed on
    #[arg(long)]
    pub no_scene: bool,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Memory to work in, such as 512MiB or 2GiB; what does not fit goes to temporary files beside
    /// the archive
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    #[command(flatten)]
    pub about_weather: ClockArgs,
}

#[derive(Args, Debug)]
#[command(group(clock_of("weather_files")), group(weather_files()))]
pub struct PlanArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub table_north: TableNorthArgs,
    /// Table of receivers, CSV with columns receiver,x,y,z, tilt_deg,azimuth_deg (from true north) or
    /// nx,ny,nz, and optionally area_m2,surface; height (above the roof or ground below) may stand
    /// for z
    #[arg(long, short)]
    pub receivers: PathBuf,
    /// Light paths to trace besides direct sun and sky: `auto` (those that can matter in the
    /// scene), `all`, `none`, or some of diffuse, bounces, mirrors, canopies, leaves
    #[arg(long, value_name = "LIST", default_value_t = EffectChoice::Auto)]
    pub effects: EffectChoice,
    /// Weather file under which to print also the light that each light path adds, by group of
    /// receivers
    #[arg(long, short, value_name = "FILE")]
    pub weather: Option<PathBuf>,
    /// Leave out light paths that add no more than this share of the sum over --weather, in any
    /// group of receivers, such as 0.5%
    #[arg(long, value_name = "PERCENT", value_parser = parse_negligible, requires = "weather", conflicts_with = "effects")]
    pub negligible: Option<Percent>,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    #[command(flatten)]
    pub about_weather: ClockArgs,
}

fn parse_seconds(text: &str) -> Result<u32, String> {
    text.parse()
        .map_err(|_| "give whole seconds from 0 (a checkpoint whenever something is written) to 4294967295".into())
}
