//! Weather files of every kind. In: a path. Out: [`Weather`], by the reader that the file's first lines call for.

use std::path::Path;

use crate::error::{Error, Result};
use crate::weather::formats::{epw, tmy3};
use crate::weather::weather::Weather;

/// Reads and checks a weather file, EPW or TMY3. The text need not be UTF-8: only its numbers are used.
pub fn read_weather(path: &Path) -> Result<Weather> {
    read(path, false)
}

/// The same with the air of every row, which longwave irradiance is made of.
pub fn read_weather_with_air(path: &Path) -> Result<Weather> {
    read(path, true)
}

fn read(path: &Path, with_air: bool) -> Result<Weather> {
    let bytes = std::fs::read(path).map_err(Error::io(path, "read"))?;
    if tmy3::is_tmy3(&bytes) { tmy3::parse(path, &bytes, with_air) } else { epw::parse(path, &bytes, with_air) }
}
