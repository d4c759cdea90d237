//! Arguments of `energyplus`: a model, what stands around it, which light it gets.

use std::path::PathBuf;

use clap::Args;

use super::choice::{NamedValues, choice};
use super::cover::Metres;
use crate::cli::{AccuracyArgs, Bytes, MaterialsArgs, PlaceArgs, parse_memory};

#[derive(Args, Debug)]
pub struct EnergyplusArgs {
    /// Model of EnergyPlus 25.2: .idf or .epJSON
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// Files of what stands around it, in the coordinates of the model: CityJSON, terrain, meshes, site.toml
    #[arg(long, value_name = "SCENE", num_args = 1..)]
    pub scene: Vec<PathBuf>,
    /// Weather file of --run
    #[arg(long, short)]
    pub weather: Option<PathBuf>,
    /// Folder for model.idf or model.epJSON, report.md and .html, receivers.csv and site.helio
    #[arg(long, short, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Which light the model gets
    #[arg(long, value_parser = choice::<Physics>(), default_value = "full")]
    pub physics: Physics,
    /// Distance between receivers on the model's surfaces, such as 1m or 50cm
    #[arg(long, value_name = "LENGTH", default_value = "1m")]
    pub spacing: Metres,
    #[command(flatten)]
    pub surfaces: MaterialsArgs,
    #[command(flatten)]
    pub place: PlaceArgs,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Replace what the folder holds of another model, scene, spacing or accuracy, which is refused otherwise
    #[arg(long)]
    pub replace: bool,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
}

/// Which paths of light are injected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Physics {
    Full,
    EnergyPlus,
}

impl NamedValues for Physics {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("full", "All reflections, those that mirrors light too", Physics::Full),
        (
            "energyplus",
            "One diffuse reflection and the mirrored sun, as EnergyPlus has them: to compare",
            Physics::EnergyPlus,
        ),
    ];
}
