//! Arguments of commands that read scenes and trace them, and arguments of weather files.

mod audit;
mod build;
mod cover;
mod partition;
mod quality;
mod rasters;
mod run;
mod scene;
mod study;
mod tradeoff;
mod update;
mod weather;

pub use audit::AuditArgs;
pub use build::{BuildArgs, PlanArgs};
pub use cover::{CoverArgs, Metres, ReceiversArgs};
pub use partition::{CatalogueArgs, FindArgs, PartitionArgs};
pub use quality::{AccuracyArgs, Percent, parse_negligible};
pub use rasters::RasterArgs;
pub use run::RunArgs;
pub use scene::{
    FootprintArgs, MaterialsArgs, PlaceArgs, SceneArgs, TableNorthArgs, parse_crs, parse_latitude, parse_longitude,
};
pub use study::{RaySquare, StudyArgs, StudyCommand, WallArgs};
pub use tradeoff::TradeoffArgs;
pub use update::UpdateArgs;
pub use weather::{ClockArgs, WeatherArgs, clock_of, parse_time_zone, weather_files};
