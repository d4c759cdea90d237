//! Weather files of every kind. In: bytes. Out: [`Weather`], by the reader that the first lines
//! call for.

use std::borrow::Cow;
use std::path::Path;

use crate::formats::{epw, surfrad, tmy3, wea, weather_csv};
use crate::judging::judged;
use crate::series::Weather;
use heliotile_core::error::{Error, Result};
use heliotile_core::weather::options::WeatherOptions;

pub use crate::judging::station::ScenePlace;

/// Reads and checks the bytes of a weather file, EPW, TMY3, SURFRAD, WEA, CSV or JSON; messages
/// call it `path`. The text need not be UTF-8: only its numbers are used.
pub fn parse_weather(path: &Path, bytes: &[u8]) -> Result<Weather> {
    parse_weather_as(path, bytes, &WeatherOptions::default(), &mut || Ok(None))
}

/// Reads and checks the bytes of a weather file with the options of the user. `scene` gives the
/// place of the scene, for a file that does not state its own.
pub fn parse_weather_as(path: &Path, bytes: &[u8], options: &WeatherOptions, scene: ScenePlace) -> Result<Weather> {
    let text = text_of(path, bytes)?;
    let bytes = text.as_ref();
    let raw = if tmy3::is_tmy3(bytes) {
        tmy3::read(path, bytes, options)
    } else if surfrad::is_surfrad(bytes) {
        surfrad::read(path, bytes, options)
    } else if wea::is_wea(bytes) {
        wea::read(path, bytes, options)
    } else if epw::is_epw(path, bytes) {
        epw::read(path, bytes, options)
    } else if weather_csv::is_json(bytes) {
        weather_csv::read_json(path, bytes, options)
    } else {
        weather_csv::read(path, bytes, options)
    }?;
    judged(path, raw, options, scene)
}

/// First bytes of files that hold weather and are no text.
const NO_TEXT: [(&[u8], &str); 6] = [
    (b"PK\x03\x04", "a zip archive"),
    (b"\x1f\x8b", "a gzip file"),
    (b"PAR1", "a Parquet file"),
    (b"\x89HDF", "a NetCDF or HDF5 file"),
    (b"CDF", "a NetCDF file"),
    (b"GRIB", "a GRIB file"),
];

/// Returns the text of a file: UTF-16 becomes UTF-8. A known binary file is refused by the name of
/// its format.
fn text_of<'b>(path: &Path, bytes: &'b [u8]) -> Result<Cow<'b, [u8]>> {
    let utf16 = |rest: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = rest.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        char::decode_utf16(units).map(|c| c.unwrap_or('\u{fffd}')).collect::<String>().into_bytes()
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => return Ok(Cow::Owned(utf16(rest, u16::from_le_bytes))),
        [0xfe, 0xff, rest @ ..] => return Ok(Cow::Owned(utf16(rest, u16::from_be_bytes))),
        _ => {}
    }
    let start = bytes.get(..512).unwrap_or(bytes);
    let known = NO_TEXT.iter().find(|(magic, _)| start.starts_with(magic)).map(|(_, name)| *name);
    if known.is_none() && !start.contains(&0) {
        return Ok(Cow::Borrowed(bytes));
    }
    let what = format!("is {}, not a text file of weather", known.unwrap_or("a binary file"));
    Err(Error::input(path, None, what, "save the weather as CSV or EPW"))
}
