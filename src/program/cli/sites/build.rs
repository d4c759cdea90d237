//! Arguments of `build` and `plan`.

use std::path::PathBuf;

use clap::Args;

use super::quality::parse_preview;
use super::{clock_of, weather_files};
use crate::cli::values::{Bytes, choice, parse_memory};
use crate::cli::{AccuracyArgs, ClockArgs, Percent, SceneArgs, parse_negligible};
use heliotile_builder::settings::{EffectChoice, Share};

/// Options that `--part` excludes, as the plan of an atlas states their values.
const PLANNED: [&str; 23] = [
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
    /// Receivers: receiver,x,y,z,nx,ny,nz and optionally area,surface
    #[arg(long, short)]
    pub receivers: Option<PathBuf>,
    /// Archive to write
    #[arg(long, short, value_name = "SITE.helio")]
    pub output: Option<PathBuf>,
    /// Build one part of the atlas whose folder or address SCENE is, by its name or number, or
    /// `all` of them; the atlas holds the inputs and settings
    #[arg(long, value_name = "K", conflicts_with_all = PLANNED)]
    pub part: Option<String>,
    /// Seconds between checkpoints: the most work that a crash costs
    #[arg(long, value_name = "SECONDS", default_value_t = 30, value_parser = parse_seconds)]
    pub checkpoint: u32,
    /// Discard an interrupted build at this path and start anew; without it, a build of the same
    /// inputs is resumed, and one of other inputs is not discarded
    #[arg(long)]
    pub fresh: bool,
    /// Sharing of probes between receivers: `cells` (default), or `none`: a hemisphere of its own
    /// for every hit, the slow reference
    #[arg(long, value_parser = choice::<Share>(), default_value = "cells", conflicts_with = "error")]
    pub share: Share,
    /// Light paths to trace: `auto` (those that the scene calls for), `all`, `none`, or some of
    /// diffuse, bounces, mirrors, canopies, leaves
    #[arg(long, value_name = "LIST", default_value_t = EffectChoice::Auto)]
    pub effects: EffectChoice,
    /// Leave out effects whose light makes up no more than this of the sum over a weather file, in
    /// each group of receivers, such as 0.5%
    #[arg(long, value_name = "PERCENT", value_parser = parse_negligible, requires = "weather", conflicts_with = "effects")]
    pub negligible: Option<Percent>,
    /// Weather file that the light of effects is computed for
    #[arg(long, short, value_name = "FILE", requires = "negligible")]
    pub weather: Option<PathBuf>,
    /// Folder with traces of earlier builds, of any project: nothing is traced twice, and this
    /// build is added
    #[arg(long, value_name = "FOLDER")]
    pub store: Option<PathBuf>,
    /// Archive of this scene before it was changed, or with --part such an atlas, a path or an
    /// address: only light that the change can alter is traced, and the new archive has the bytes
    /// that it would have without this option
    #[arg(long, value_name = "BEFORE.helio")]
    pub from: Option<PathBuf>,
    /// With --from: keep light that the change can alter by less than this share of the light on
    /// open ground, in the mean over the sky, such as 1%. The archive is a preview, and says so;
    /// the same command without this option completes it
    #[arg(long, value_name = "PERCENT", value_parser = parse_preview, requires = "from")]
    pub preview: Option<Percent>,
    /// Leave the scene's triangles out of the archive, for those who may not pass them on
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
    /// Receivers: receiver,x,y,z,nx,ny,nz and optionally area,surface
    #[arg(long, short)]
    pub receivers: PathBuf,
    /// Light paths to trace: `auto` (those that the scene calls for), `all`, `none`, or some of
    /// diffuse, bounces, mirrors, canopies, leaves
    #[arg(long, value_name = "LIST", default_value_t = EffectChoice::Auto)]
    pub effects: EffectChoice,
    /// Weather file: also print what each effect contributes in its time, by groups of receivers
    #[arg(long, short, value_name = "FILE")]
    pub weather: Option<PathBuf>,
    /// Leave out effects whose light makes up no more than this of the sum over the weather file,
    /// in each group of receivers, such as 0.5%
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
