//! Arguments of `partition`, `catalogue` and `find`: a region in parts.

use std::path::PathBuf;

use clap::Args;

use crate::cli::values::{Bytes, choice, parse_bounds, parse_memory};
use crate::cli::{CoverArgs, Metres, SceneArgs};
use heliotile::{Bounds, Quality};

#[derive(Args, Debug)]
pub struct PartitionArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Folder of the atlas to write: atlas.json, and a folder for each part once it is built
    #[arg(long, short, value_name = "ATLAS")]
    pub output: PathBuf,
    /// Side of a square part; its corners lie at multiples of this length in the scene's
    /// coordinates
    #[arg(long, value_name = "LENGTH", default_value = "500m")]
    pub part_size: Metres,
    /// Width of the zone around a part in which all objects count
    #[arg(long, value_name = "LENGTH", default_value = "300m")]
    pub halo: Metres,
    /// Angle above the horizon, degrees: objects beyond the halo count only if they rise higher
    /// than this, as seen from the part
    #[arg(long, value_name = "DEGREES", default_value_t = 5.0, value_parser = parse_skyline)]
    pub skyline: f64,
    #[command(flatten)]
    pub cover: CoverArgs,
    /// Accuracy level: a named set of settings, from fast to accurate, for all parts
    #[arg(long, value_parser = choice::<Quality>(), default_value = "standard")]
    pub quality: Quality,
    /// Change one setting, for all parts, such as `--set hit=16`; `info` of an archive lists the
    /// settings; may be repeated
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Leave the scene's triangles out of the archives, if they may not be passed on
    #[arg(long)]
    pub no_scene: bool,
    /// Number of receivers that are also traced with three times the halo, to estimate the error
    /// due to the halo; 0 for no estimate
    #[arg(long, value_name = "N", default_value_t = 256)]
    pub sample: usize,
    /// Replace the plan of an atlas that has no built parts
    #[arg(long)]
    pub replace: bool,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
}

fn parse_skyline(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(degrees) if (0.1..=90.0).contains(&degrees) => Ok(degrees),
        _ => Err("give an angle from 0.1 to 90 degrees; with 90, nothing beyond the halo counts".into()),
    }
}

#[derive(Args, Debug)]
pub struct CatalogueArgs {
    /// Folder of the atlas
    pub atlas: PathBuf,
    /// Title of the catalogue [default: the folder's name]
    #[arg(long)]
    pub title: Option<String>,
    /// Licence of the data of the atlas, an SPDX name such as CC-BY-4.0
    #[arg(long, value_name = "NAME", default_value = "other")]
    pub license: String,
}

#[derive(Args, Debug)]
pub struct FindArgs {
    /// Folder of the atlas, or its address
    pub atlas: PathBuf,
    /// Box in the coordinates of the scene, metres: xmin,ymin,xmax,ymax; only parts that touch it
    /// are listed [default: all parts]
    #[arg(long, value_name = "BOX", allow_hyphen_values = true, value_parser = parse_bounds)]
    pub bbox: Option<Bounds>,
}
