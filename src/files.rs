//! Files that the engine takes as bytes, packed with gzip or not. In: a path. Out: what its reader makes of the file, or an error that names
//! it.

use std::io::Read;
use std::path::Path;

use flate2::bufread::MultiGzDecoder;

use heliotile_core::error::{Error, Result};
use heliotile_core::weather::conditions::{ConditionsFile, parse_conditions};
use heliotile_core::weather::formats::weather_file::{ScenePlace, parse_weather, parse_weather_as};
use heliotile_core::weather::options::WeatherOptions;
use heliotile_core::weather::series::Weather;

/// First bytes of a file of gzip (RFC 1952).
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// What a packed file may unpack to: so many bytes, and so many times its own.
const MOST_UNPACKED: u64 = 4 << 30;
const MOST_TIMES: u64 = 200;

/// Small files may unpack to this, however well they are packed.
const ALWAYS_ALLOWED: u64 = 1 << 20;

/// The bytes of a file; what gzip packed is unpacked, whatever the file's name.
pub fn read_file(path: &Path) -> Result<Vec<u8>> {
    let bytes = std::fs::read(path).map_err(Error::io(path, "read"))?;
    if bytes.starts_with(&GZIP) { unpacked(path, &bytes) } else { Ok(bytes) }
}

fn unpacked(path: &Path, packed: &[u8]) -> Result<Vec<u8>> {
    let most = (packed.len() as u64).saturating_mul(MOST_TIMES).clamp(ALWAYS_ALLOWED, MOST_UNPACKED);
    let mut bytes = Vec::new();
    let read = MultiGzDecoder::new(packed).take(most + 1).read_to_end(&mut bytes);
    read.map_err(|error| {
        let what = format!("is packed with gzip and cannot be unpacked: {error}");
        Error::input(path, None, what, "the file may be cut off; fetch it again, or unpack it yourself")
    })?;
    if bytes.len() as u64 > most {
        let what = format!("is {} bytes packed with gzip, and more than {most} unpacked", packed.len());
        return Err(Error::input(path, None, what, "unpack it yourself if it is what you expect"));
    }
    Ok(bytes)
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
