//! Weather and conditions in files. In: a path. Out: what their readers make of its bytes.

use std::path::Path;

use super::read;
use heliotile_core::error::Result;
use heliotile_core::weather::conditions::{ConditionsFile, parse_conditions};
use heliotile_core::weather::formats::weather_file::{ScenePlace, parse_weather, parse_weather_as};
use heliotile_core::weather::options::WeatherOptions;
use heliotile_core::weather::series::Weather;

/// See [`parse_conditions`].
pub fn read_conditions(path: &Path) -> Result<ConditionsFile> {
    parse_conditions(path, &read(path)?)
}

/// See [`parse_weather`].
pub fn read_weather(path: &Path) -> Result<Weather> {
    parse_weather(path, &read(path)?)
}

/// See [`parse_weather_as`].
pub fn read_weather_as(path: &Path, options: &WeatherOptions, scene: ScenePlace) -> Result<Weather> {
    parse_weather_as(path, &read(path)?, options, scene)
}
