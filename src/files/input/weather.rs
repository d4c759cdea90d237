//! Weather and conditions in files. In: a path. Out: the values that the parsers of
//! `heliotile_core` read from its bytes.

use std::fs;
use std::path::{Path, PathBuf};

use super::{ending, read, refused};
use heliotile_core::error::{Error, Result};
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

/// Returns the EPW files in a folder, by name. Fails if there are none.
pub fn weather_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).map_err(|source| refused(folder, "read", source))?;
    let all = entries.map(|entry| entry.map(|entry| entry.path())).collect::<std::io::Result<Vec<PathBuf>>>();
    let mut files = all.map_err(|source| refused(folder, "read", source))?;
    files.retain(|file| ending(file) == "epw" && file.is_file());
    files.sort();
    if files.is_empty() {
        let hint = "give one weather file, or a folder with an EPW file for each year";
        return Err(Error::input(folder, None, "the folder holds no .epw", hint));
    }
    Ok(files)
}

/// Reads a weather file with options and the scene's place; see [`parse_weather_as`].
pub fn read_weather_as(path: &Path, options: &WeatherOptions, scene: ScenePlace) -> Result<Weather> {
    parse_weather_as(path, &read(path)?, options, scene)
}
