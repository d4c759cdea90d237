//! Arguments of `update`.

use std::path::PathBuf;

use clap::Args;

use super::cover::Metres;
use super::quality::{Percent, parse_preview};
use super::scene::{MaterialsArgs, PlaceArgs};
use crate::cli::values::{Bytes, parse_memory};
use heliotile::{
    CoverRequest, Density, ObjectHeight, ObjectMaterial, ObjectMove, SceneEdits, SceneRequest, UpdateRequest,
};

#[derive(Args, Debug)]
pub struct UpdateArgs {
    /// Archive to edit, which must hold the triangles of its scene: a path or an address
    #[arg(value_name = "BEFORE.helio")]
    pub before: PathBuf,
    /// Archive to write
    #[arg(long, short, value_name = "AFTER.helio")]
    pub output: PathBuf,
    /// Add the objects of a scene file, in the coordinates of the scene; may be repeated
    #[arg(long, value_name = "FILE")]
    pub add: Vec<PathBuf>,
    /// Remove an object or a building; may be repeated, as --move, --height and --material may
    #[arg(long, value_name = "OBJECT")]
    pub remove: Vec<String>,
    /// Move an object by these metres along x, y and z; its receivers go with it
    #[arg(long, value_name = "OBJECT=DX,DY,DZ", value_parser = clap::value_parser!(ObjectMove))]
    pub r#move: Vec<ObjectMove>,
    /// Raise or lower the roofs of an object, and its walls with them: by +3m or -3m, or to a
    /// height of 12m over its lowest point
    #[arg(long, value_name = "OBJECT=HEIGHT", value_parser = clap::value_parser!(ObjectHeight))]
    pub height: Vec<ObjectHeight>,
    /// Give all surfaces of an object a material of the scene or of --materials
    #[arg(long, value_name = "OBJECT=MATERIAL", value_parser = clap::value_parser!(ObjectMaterial))]
    pub material: Vec<ObjectMaterial>,
    #[command(flatten)]
    pub surfaces: MaterialsArgs,
    #[command(flatten)]
    pub place: PlaceArgs,
    /// Surfaces of new or reshaped objects to cover with receivers, as for `receivers`
    #[arg(long, value_delimiter = ',')]
    pub on: Vec<String>,
    /// Distance between the receivers on new or reshaped objects, such as 2m [default: about that
    /// of the archive's own]
    #[arg(long, value_name = "LENGTH")]
    pub spacing: Option<Metres>,
    /// Keep light that the edits alter by less than this share of the light on open ground, on
    /// average over the sky, such as 1%. The new archive is marked as a preview; the same command
    /// without this option completes it
    #[arg(long, value_name = "PERCENT", value_parser = parse_preview)]
    pub preview: Option<Percent>,
    /// Discard an interrupted update at the output path and start again. Without this option an
    /// update with the same edits is resumed
    #[arg(long)]
    pub fresh: bool,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
}

impl UpdateArgs {
    /// Returns the request of `update`.
    pub fn request(&self) -> UpdateRequest {
        UpdateRequest {
            before: self.before.clone(),
            output: self.output.clone(),
            edits: SceneEdits {
                remove: self.remove.clone(),
                moves: self.r#move.clone(),
                heights: self.height.clone(),
                materials: self.material.clone(),
            },
            add: SceneRequest { frame: self.place.frame(), ..self.surfaces.request(&self.add) },
            cover: CoverRequest { on: self.on.clone(), ..CoverRequest::default() },
            density: self.spacing.map(|Metres(metres)| Density::Spacing(metres)),
            preview_percent: self.preview.map(|Percent(percent)| percent),
            fresh: self.fresh,
        }
    }
}
