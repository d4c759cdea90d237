//! Reader of the weather of Radiance and Daysim (`.wea`). In: a file's bytes. Out: its rows, not
//! yet filled or checked against each other.
//!
//! Format: Ward and others, manual pages of `gendaymtx` and `epw2wea` (Radiance): lines `place`,
//! `latitude`, `longitude` and `time_zone` (the last two west positive, the zone in degrees of 15
//! an hour), `site_elevation`, `weather_data_file_units`, then month, day, hour as a decimal number
//! in the middle of its interval, DNI and DHI. Units 1 are W/m2; the others are illuminances. There
//! is no year.

use std::path::Path;

use crate::formats::stamp_text::clock_seconds;
use crate::formats::stamped::{StampedRows, SteppedRows};
use crate::judging::raw_weather::{RawRow, RawWeather, irradiance};
use crate::judging::station::Station;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::{Message, excerpt};
use heliotile_core::weather::air::Air;
use heliotile_core::weather::options::{StampedAt, WeatherOptions};
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::sun::Interval;

/// Degrees that the sun moves in an hour.
const DEGREES_AN_HOUR: f64 = 15.0;

const MISSING_RADIATION: f64 = 9999.0;

const HINT: &str = "a .wea file has lines place, latitude, longitude, time_zone, site_elevation and weather_data_file_units, then month, \
                    day, hour, DNI and DHI";

/// Returns true if the first line is that of a place.
pub(super) fn is_wea(bytes: &[u8]) -> bool {
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let mut lines = start.split(|byte| *byte == b'\n');
    let has = |line: Option<&[u8]>, word: &[u8]| line.is_some_and(|line| line.trim_ascii_start().starts_with(word));
    has(lines.next(), b"place") && has(lines.next(), b"latitude")
}

pub(super) fn read(path: &Path, bytes: &[u8], options: &WeatherOptions) -> Result<RawWeather> {
    let text = String::from_utf8_lossy(bytes);
    let mut station = Station {
        name: String::new(),
        latitude_deg: None,
        longitude_deg: None,
        zone_hours: None,
        zone_is_certain: false,
        elevation_m: 0.0,
    };
    let (mut rows, mut seconds) = (Vec::new(), Vec::new());
    for (line, number) in text.lines().map(|line| line.trim_start_matches('\u{feff}').trim()).zip(1_usize..) {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let Some(first) = words.first() else { continue };
        if first.starts_with('#') {
            continue;
        }
        if first.starts_with(|c: char| c.is_ascii_digit()) {
            let row = WeaRow { path, line: number, words: &words };
            seconds.push(row.seconds()?);
            rows.push(row.light()?);
        } else {
            take_tag(path, number, &words, &mut station)?;
        }
    }
    if rows.is_empty() {
        return Err(Error::input(path, None, "the file has no weather rows", HINT));
    }
    let warning =
        format!("{}: {} rows state no year and are read as rows of {}", path.display(), rows.len(), Date::NO_YEAR);
    let stamped_at = options.stamped_at.unwrap_or(StampedAt::Middle);
    let stamped = StampedRows { rows, seconds, stamped_at, day_of_start: true, late_min: 0.0, moved_s: 0, legal: None };
    let stepped: SteppedRows = stamped.stepped(path)?;
    let warnings = stepped.warning.into_iter().chain([warning]).map(Message::from).collect();
    // A .wea file holds no air.
    let air = if options.with_air { vec![Air::default(); stepped.rows.len()] } else { Vec::new() };
    Ok(RawWeather {
        station,
        rows: stepped.rows,
        air,
        step_min: stepped.step_min,
        stamped_at,
        zenith_deg: Vec::new(),
        warnings,
    })
}

/// Reads a line above the rows.
fn take_tag(path: &Path, line: usize, words: &[&str], station: &mut Station) -> Result<()> {
    let tag = words.first().copied().unwrap_or_default();
    let value = words.get(1).copied().unwrap_or_default();
    let number = || {
        let number = value.parse::<f64>().ok().filter(|value| value.is_finite());
        number.ok_or_else(|| Error::input(path, line, format!("`{tag}` holds `{}`", excerpt(value, 60)), HINT))
    };
    match tag {
        "place" => station.name = words.get(1..).unwrap_or_default().join(" "),
        "latitude" => station.latitude_deg = Some(number()?),
        "longitude" => station.longitude_deg = Some(-number()?),
        "time_zone" => station.zone_hours = Some(-number()? / DEGREES_AN_HOUR),
        "site_elevation" => station.elevation_m = number()?,
        "weather_data_file_units" if number()? != 1.0 => {
            return Err(Error::Unsupported {
                what: format!("{}, line {line}: weather_data_file_units", path.display()).into(),
                found: excerpt(value, 20),
                supported: "1, DNI and DHI in W/m2".into(),
            });
        }
        "weather_data_file_units" => {}
        _ => {
            let what = format!("`{}` does not start a line of a .wea file", excerpt(tag, 60));
            return Err(Error::input(path, line, what, HINT));
        }
    }
    Ok(())
}

/// Cells of a row.
struct WeaRow<'a> {
    path: &'a Path,
    line: usize,
    words: &'a [&'a str],
}

impl WeaRow<'_> {
    fn word(&self, place: usize) -> &str {
        self.words.get(place).copied().unwrap_or_default()
    }

    fn seconds(&self) -> Result<i64> {
        let whole = |place: usize| self.word(place).parse::<u32>().ok();
        let date = whole(0).zip(whole(1)).and_then(|(month, day)| Date::of_no_year(month, day));
        let hours = self.word(2).parse::<f64>().ok().filter(|hours| (0.0..=24.0).contains(hours));
        let (Some(date), Some(hours)) = (date, hours) else {
            let what = format!("`{}` is not an existing month, day and hour", excerpt(&self.words.join(" "), 60));
            return Err(Error::input(self.path, self.line, what, "correct the row"));
        };
        // Rounded to whole minutes, because hours of 10-minute steps are rounded to thousandths.
        Ok(clock_seconds(date, (hours * 60.0).round() as i64 * 60))
    }

    fn light(&self) -> Result<RawRow> {
        if self.words.len() != 5 {
            let what = format!("the row has {} columns instead of 5", self.words.len());
            return Err(Error::input(self.path, self.line, what, HINT));
        }
        let mut negative = false;
        let mut light = |place: usize, name: &str| {
            let text = self.word(place);
            let missing = |value: f64| value >= MISSING_RADIATION || value <= -900.0;
            irradiance(text, missing, &mut negative, || {
                let what = format!("{name} holds `{}`", excerpt(text, 60));
                Error::input(self.path, self.line, what, "write W/m2 from 0 up, 9999 where missing")
            })
        };
        let (dni, dhi) = (light(3, "DNI")?, light(4, "DHI")?);
        let interval = Interval { date: Date::OF_DAY_0, start_min: 0.0, end_min: 0.0 };
        Ok(RawRow { line: self.line, interval, ghi: None, dni, dhi, negative, albedo: None, snow_depth_cm: None })
    }
}
