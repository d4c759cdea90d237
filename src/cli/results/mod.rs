//! Arguments of commands that ask archives for light.

mod buildings;
mod energyplus;
mod export;
mod pv;
mod recombine;
mod view;

pub use buildings::{BuildingsArgs, ModuleSize, PlaceOn, PlacesArgs, YearArgs};
pub use energyplus::{EnergyplusArgs, Physics};
pub use export::ExportArgs;
pub use pv::PvArgs;
pub use recombine::{FactorsArgs, QueryArgs, RecombineArgs, ReplayArgs, TableArgs};
pub use view::ViewArgs;
