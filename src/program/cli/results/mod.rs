//! Arguments of commands that compute light from archives.

mod buildings;
mod comfort;
mod energyplus;
mod export;
mod pv;
mod recombine;
mod sunlight;
mod view;

pub use buildings::{BuildingsArgs, PlacesArgs, YearArgs};
pub use comfort::ComfortArgs;
pub use energyplus::EnergyplusArgs;
pub use export::ExportArgs;
pub use pv::PvArgs;
pub use recombine::{CompareArgs, FactorsArgs, QueryArgs, RecombineArgs, ReplayArgs, SiteArgs, TableArgs};
pub use sunlight::{GlareArgs, RulesArgs, SunlightArgs};
pub use view::ViewArgs;
