//! Arguments of `energyplus`: a model, its surroundings, the light that it gets.

use std::path::PathBuf;

use clap::Args;
use glam::DVec3;

use crate::cli::sites::parse_crs;
use crate::cli::values::{Bytes, choice, parse_memory};
use crate::cli::{AccuracyArgs, FootprintArgs, MaterialsArgs, Metres};
use heliotile::{EnergyplusRequest, Physics, SceneRequest};

#[derive(Args, Debug)]
pub struct EnergyplusArgs {
    /// EnergyPlus model, .idf or .epJSON, of version 24.1 to 25.2; with --assume-version 25.2 of
    /// any version that EnergyPlus 25.2 runs
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// Scene files of the surroundings: CityJSON, terrain, meshes, site.toml; in the coordinates of
    /// the model, unless --at is given
    #[arg(long, value_name = "SCENE", num_args = 1..)]
    pub scene: Vec<PathBuf>,
    /// Position of the model's origin in the coordinates of --scene, metres: east,north or
    /// east,north,up. The model is turned so that its true north is that of their coordinate system
    #[arg(long, value_name = "E,N[,Z]", requires = "scene", allow_hyphen_values = true, value_parser = parse_spot)]
    pub at: Option<DVec3>,
    /// Coordinate reference system of --scene, in place of the one that its files state: EPSG:28992
    /// or 28992
    #[arg(long, value_name = "EPSG", requires = "scene", value_parser = parse_crs)]
    pub crs: Option<u32>,
    /// Remove the shading objects of the surroundings from the model. Their effect on direct and
    /// diffuse light becomes a time series for --weather, and EnergyPlus computes no shadows of
    /// them
    #[arg(long, requires = "weather")]
    pub delete_surroundings: bool,
    /// Weather file for --run and --delete-surroundings
    #[arg(long, short)]
    pub weather: Option<PathBuf>,
    /// Folder to write: model.idf or model.epJSON, report.md and .html, receivers.csv and
    /// site.helio; with --delete-surroundings also series.csv, and stripped.idf with an archive of
    /// its own
    #[arg(long, short, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Reflected light that the model gets
    #[arg(long, value_parser = choice::<Physics>(), default_value = "full")]
    pub physics: Physics,
    /// Run EnergyPlus three times (without reflections, with its own, with the injected light) and
    /// compare the results in the report
    #[arg(long, requires = "weather")]
    pub run: bool,
    /// Folder of EnergyPlus 25.2 [default: that of `energyplus` on the search path]
    #[arg(long, value_name = "DIR", requires = "run")]
    pub energyplus: Option<PathBuf>,
    /// Distance between receivers on the model's surfaces, such as 1m or 50cm; with
    /// --delete-surroundings the default is 50cm, as shadows depend on it
    #[arg(long, value_name = "LENGTH", default_value = "1m", default_value_if("delete_surroundings", "true", "50cm"))]
    pub spacing: Metres,
    #[command(flatten)]
    pub surfaces: MaterialsArgs,
    #[command(flatten)]
    pub footprints: FootprintArgs,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Replace results in the folder that are of another model, scene, spacing or accuracy; without
    /// this option they are an error
    #[arg(long)]
    pub replace: bool,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
}

impl EnergyplusArgs {
    /// Returns the request of `energyplus`.
    pub fn request(&self) -> EnergyplusRequest {
        EnergyplusRequest {
            model: self.model.clone(),
            scene: self.scene.clone(),
            at: self.at.map(|at| at.to_array()),
            crs: self.crs,
            delete_surroundings: self.delete_surroundings,
            weather: self.weather.clone(),
            folder: self.output.clone(),
            physics: self.physics,
            run: self.run,
            energyplus: self.energyplus.clone(),
            spacing_m: self.spacing.0,
            surfaces: SceneRequest { footprints: self.footprints.options(), ..self.surfaces.request(&[]) },
            accuracy: self.accuracy.request(),
            replace: self.replace,
        }
    }
}

/// Parses a position: `78500,457800` or `78500,457800,1.5`.
fn parse_spot(text: &str) -> Result<DVec3, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse::<f64>().ok()).collect();
    match numbers.as_deref() {
        Some([x, y]) if x.abs() <= MOST_M && y.abs() <= MOST_M => Ok(DVec3::new(*x, *y, 0.0)),
        Some([x, y, z]) if [x, y, z].iter().all(|m| m.abs() <= MOST_M) => Ok(DVec3::new(*x, *y, *z)),
        _ => Err("give two or three numbers of metres, such as 78500,457800 or 78500,457800,1.5".into()),
    }
}

/// Largest coordinate, metres: no plane system has larger ones.
const MOST_M: f64 = 1e8;

#[cfg(test)]
mod tests {
    use super::*;

    /// Two positions are read, 4 texts are refused.
    #[test]
    fn positions_have_two_or_three_numbers() {
        assert_eq!(parse_spot("78500, -45.5"), Ok(DVec3::new(78500.0, -45.5, 0.0)));
        assert_eq!(parse_spot("1,2,3"), Ok(DVec3::new(1.0, 2.0, 3.0)));
        for text in ["", "1", "1,nan", "1,2,3,4"] {
            assert!(parse_spot(text).is_err(), "{text}");
        }
    }
}
