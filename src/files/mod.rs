//! Files that the engine takes as bytes, packed with gzip or not, and archives wherever they are. In: a path, or the address of an archive.
//! Out: what its reader makes of the file, or an error that names it.

#[cfg(feature = "remote")]
mod afar;
mod any_folder;
mod archives;
#[cfg(any(test, not(feature = "remote")))]
mod not_afar;

use std::path::Path;

use heliotile_builder::build::Workspace;
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_core::error::Result;
use heliotile_core::memory::Use;
use heliotile_core::weather::conditions::{ConditionsFile, parse_conditions};
use heliotile_core::weather::formats::weather_file::{ScenePlace, parse_weather, parse_weather_as};
use heliotile_core::weather::options::WeatherOptions;
use heliotile_core::weather::series::Weather;
use heliotile_scene::Scene;
use heliotile_scene::input;
use heliotile_scene::placing::plausible::far_receivers;

#[cfg(not(feature = "remote"))]
use not_afar as afar;

pub(crate) use afar::{check_writable, copy, traffic};
pub(crate) use any_folder::AnyFolder;
pub(crate) use archives::{ATLAS, find_archive, hold, require_file};
pub use archives::{is_address, open_archive, shown, verify_archive};

/// The bytes of a file; what gzip packed is unpacked, whatever the file's name.
pub fn read_file(path: &Path) -> Result<Vec<u8>> {
    input::read(path)
}

/// See [`parse_conditions`].
pub fn read_conditions(path: &Path) -> Result<ConditionsFile> {
    parse_conditions(path, &read_file(path)?)
}

/// See [`parse_weather`].
pub fn read_weather(path: &Path) -> Result<Weather> {
    parse_weather(path, &read_file(path)?)
}

/// See [`parse_weather_as`].
pub fn read_weather_as(path: &Path, options: &WeatherOptions, scene: ScenePlace) -> Result<Weather> {
    parse_weather_as(path, &read_file(path)?, options, scene)
}

/// The receivers of a table in tiles, and what is to be said of them: columns that are passed over, receivers far from the scene.
pub fn read_receivers(path: &Path, scene: &Scene, workspace: &Workspace) -> Result<(ReceiverTiles, Vec<String>)> {
    let mut warnings = Vec::new();
    let budget = workspace.memory.length(Use::SortedReceivers);
    let receivers = ReceiverTiles::open(path, scene.mesh.origin, &workspace.folder, budget, &mut warnings)?;
    let far = |farthest| far_receivers(scene, receivers.bounds(), farthest, receivers.count());
    warnings.extend(receivers.farthest().and_then(far).map(|far| format!("{}: {far}", path.display())));
    Ok((receivers, warnings))
}
