//! The book: what README summarises, a topic a page. The pages are plain files in `src/book`, too.
#![doc = include_str!("README.md")]

#[doc = include_str!("first-hour.md")]
pub mod first_hour {}

#[doc = include_str!("scenes.md")]
pub mod scenes {}

#[doc = include_str!("footprints.md")]
pub mod footprints {}

#[doc = include_str!("place.md")]
pub mod place {}

#[doc = include_str!("terrain.md")]
pub mod terrain {}

#[doc = include_str!("rasters.md")]
pub mod rasters {}

#[doc = include_str!("materials.md")]
pub mod materials {}

#[doc = include_str!("receivers.md")]
pub mod receivers {}

#[doc = include_str!("building.md")]
pub mod building {}

#[doc = include_str!("effects.md")]
pub mod effects {}

#[doc = include_str!("command-line.md")]
pub mod command_line {}

#[doc = include_str!("query-and-replay.md")]
pub mod query_and_replay {}

#[doc = include_str!("comparing.md")]
pub mod comparing {}

#[doc = include_str!("sunlight.md")]
pub mod sunlight {}

#[doc = include_str!("glare.md")]
pub mod glare {}

#[doc = include_str!("maps.md")]
pub mod maps {}

#[doc = include_str!("pictures.md")]
pub mod pictures {}

#[doc = include_str!("weather.md")]
pub mod weather {}

#[doc = include_str!("skies.md")]
pub mod skies {}

#[doc = include_str!("reflectances.md")]
pub mod reflectances {}

#[doc = include_str!("canopies.md")]
pub mod canopies {}

#[doc = include_str!("mirrors-and-glass.md")]
pub mod mirrors_and_glass {}

#[doc = include_str!("bands.md")]
pub mod bands {}

#[doc = include_str!("longwave.md")]
pub mod longwave {}

#[doc = include_str!("comfort.md")]
pub mod comfort {}

#[doc = include_str!("energyplus.md")]
pub mod energyplus {}

#[doc = include_str!("pv.md")]
pub mod pv {}

#[doc = include_str!("python.md")]
pub mod python {}

#[doc = include_str!("viewing.md")]
pub mod viewing {}

#[doc = include_str!("buildings.md")]
pub mod buildings {}

#[doc = include_str!("export.md")]
pub mod export {}

#[doc = include_str!("regions.md")]
pub mod regions {}

#[doc = include_str!("archives.md")]
pub mod archives {}

#[doc = include_str!("remote.md")]
pub mod remote {}

#[doc = include_str!("method.md")]
pub mod method {}

#[doc = include_str!("accuracy.md")]
pub mod accuracy {}

#[doc = include_str!("validation.md")]
pub mod validation {}

#[doc = include_str!("radiance.md")]
pub mod radiance {}

#[doc = include_str!("numerics.md")]
pub mod numerics {}

#[doc = include_str!("performance.md")]
pub mod performance {}

#[doc = include_str!("limits.md")]
pub mod limits {}

#[doc = include_str!("studies.md")]
pub mod studies {}

#[doc = include_str!("contributing.md")]
pub mod contributing {}

/// Options of all commands, a page for each.
pub mod reference;
