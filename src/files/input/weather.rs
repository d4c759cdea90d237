//! Weather and conditions in files. In: a path. Out: the values that the parsers of
//! `heliotile_core` read from its bytes.

use std::path::Path;

use super::read;
use heliotile_core::error::Result;
use heliotile_core::weather::conditions::{ConditionsFile, parse_conditions};
use heliotile_core::weather::options::WeatherOptions;
use heliotile_weather::formats::weather_file::{ScenePlace, parse_weather, parse_weather_as};
use heliotile_weather::series::Weather;

/// Reads a file of conditions; see [`parse_conditions`].
pub fn read_conditions(path: &Path) -> Result<ConditionsFile> {
    parse_conditions(path, &read(path)?)
}

/// Reads a weather file; see [`parse_weather`].
pub fn read_weather(path: &Path) -> Result<Weather> {
    parse_weather(path, &read(path)?)
}

/// Reads a weather file with options and the scene's place; see [`parse_weather_as`].
pub fn read_weather_as(path: &Path, options: &WeatherOptions, scene: ScenePlace) -> Result<Weather> {
    parse_weather_as(path, &read(path)?, options, scene)
}
