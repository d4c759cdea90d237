//! Weather files of every kind. In: bytes. Out: [`Weather`], by the reader that the first lines call for.

use std::path::Path;

use crate::error::Result;
use crate::weather::formats::{epw, surfrad, tmy3, weather_csv};
use crate::weather::judging::judged;
use crate::weather::options::WeatherOptions;
use crate::weather::series::Weather;

pub use crate::weather::judging::station::ScenePlace;

/// Reads and checks the bytes of a weather file, EPW, TMY3, SURFRAD or CSV; `path` is its name in messages. The text need not be UTF-8: only
/// its numbers are used.
pub fn parse_weather(path: &Path, bytes: &[u8]) -> Result<Weather> {
    parse_weather_as(path, bytes, &WeatherOptions::default(), &mut || Ok(None))
}

/// The same with what the user says about the file, and the place of the scene for one that does not say where it is from.
pub fn parse_weather_as(path: &Path, bytes: &[u8], options: &WeatherOptions, scene: ScenePlace) -> Result<Weather> {
    let raw = if tmy3::is_tmy3(bytes) {
        tmy3::read(path, bytes, options)
    } else if surfrad::is_surfrad(bytes) {
        surfrad::read(path, bytes, options)
    } else if epw::is_epw(path, bytes) {
        epw::read(path, bytes, options)
    } else {
        weather_csv::read(path, bytes, options)
    }?;
    judged(path, raw, options, scene)
}
