//! Files that the engine takes as bytes. In: a path. Out: what its reader makes of the file, or an error that names it.

use std::path::Path;

use heliotile_core::error::{Error, Result};
use heliotile_core::weather::conditions::{ConditionsFile, parse_conditions};
use heliotile_core::weather::formats::weather_file::{parse_weather, parse_weather_with_air};
use heliotile_core::weather::series::Weather;

/// The bytes of a file.
pub fn read_file(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(Error::io(path, "read"))
}

/// See [`parse_conditions`].
pub fn read_conditions(path: &Path) -> Result<ConditionsFile> {
    parse_conditions(path, &read_file(path)?)
}

/// See [`parse_weather`].
pub fn read_weather(path: &Path) -> Result<Weather> {
    parse_weather(path, &read_file(path)?)
}

/// See [`parse_weather_with_air`].
pub fn read_weather_with_air(path: &Path) -> Result<Weather> {
    parse_weather_with_air(path, &read_file(path)?)
}
