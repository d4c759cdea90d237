//! Scene files as most commands take them.

use std::path::{Path, PathBuf};

use clap::Args;

use heliotile_core::error::Result;
use heliotile_scene::site::{MissingGround, Site};

#[derive(Args, Debug)]
pub struct SceneArgs {
    /// Scene files, merged into one scene, or a site.toml that lists them: CityJSON (.city.json, .city.jsonl), terrain (.tif,
    /// .asc), EnergyPlus (.epjson, .idf), glTF (.gltf, .glb), .obj, .ply, .stl; metres, x east, y north, z up
    #[arg(required = true, value_name = "SCENE")]
    pub scene: Vec<PathBuf>,
    #[command(flatten)]
    pub surfaces: MaterialsArgs,
}

/// What surfaces reflect, and whether there is ground.
#[derive(Args, Debug)]
pub struct MaterialsArgs {
    /// Reflectances, one table per material name: they win over those that the files state; materials without a table keep theirs, or
    /// usual ones
    #[arg(long, short)]
    pub materials: Option<PathBuf>,
    /// Take nothing that the files state of materials: --materials has to name all of them
    #[arg(long)]
    pub materials_only: bool,
    /// Add no ground to a scene that has none [default: a plane below it, that of an EnergyPlus model as the model says]
    #[arg(long)]
    pub no_ground: bool,
}

impl MaterialsArgs {
    /// A site of files.
    pub fn site(&self, files: &[PathBuf]) -> Result<Site> {
        let mut site = Site::of(files, self.materials.as_deref())?;
        if !self.no_ground {
            site.missing_ground = MissingGround::Assume;
        }
        site.parts.iter_mut().for_each(|part| part.materials_only |= self.materials_only);
        Ok(site)
    }
}

impl SceneArgs {
    /// The files of the scene.
    pub fn site(&self) -> Result<Site> {
        self.surfaces.site(&self.scene)
    }

    /// The first file, which messages about the scene are about.
    pub fn first(&self) -> &Path {
        self.scene.first().map_or(Path::new(""), PathBuf::as_path)
    }
}
