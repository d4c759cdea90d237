//! Scene files as most commands take them.

use std::path::{Path, PathBuf};

use clap::Args;

use heliotile_core::error::Result;
use heliotile_scene::site::Site;

#[derive(Args, Debug)]
pub struct SceneArgs {
    /// Scene files, merged into one scene, or a site.toml that lists them: CityJSON (.city.json, .city.jsonl), terrain (.tif,
    /// .asc, .dem), EnergyPlus (.epjson, .idf), Honeybee (.hbjson), glTF (.gltf, .glb), .obj, .ply, .stl, each maybe .gz; metres,
    /// x east, y north, z up
    #[arg(required = true, value_name = "SCENE")]
    pub scene: Vec<PathBuf>,
    /// Reflectances, one table per material name; without it those that the files state, or usual ones
    #[arg(long, short)]
    pub materials: Option<PathBuf>,
}

impl SceneArgs {
    /// The files of the scene.
    pub fn site(&self) -> Result<Site> {
        Site::of(&self.scene, self.materials.as_deref())
    }

    /// The first file, which messages about the scene are about.
    pub fn first(&self) -> &Path {
        self.scene.first().map_or(Path::new(""), PathBuf::as_path)
    }
}
