//! Weather files of every kind. In: bytes. Out: [`Weather`], by the reader that the first lines call for.

use std::path::Path;

use crate::error::Result;
use crate::weather::formats::{epw, tmy3};
use crate::weather::series::Weather;

/// Reads and checks the bytes of a weather file, EPW or TMY3; `path` is its name in messages. The text need not be UTF-8: only its numbers
/// are used.
pub fn parse_weather(path: &Path, bytes: &[u8]) -> Result<Weather> {
    parse(path, bytes, false)
}

/// The same with the air of every row, which longwave irradiance is made of.
pub fn parse_weather_with_air(path: &Path, bytes: &[u8]) -> Result<Weather> {
    parse(path, bytes, true)
}

fn parse(path: &Path, bytes: &[u8], with_air: bool) -> Result<Weather> {
    if tmy3::is_tmy3(bytes) { tmy3::parse(path, bytes, with_air) } else { epw::parse(path, bytes, with_air) }
}
