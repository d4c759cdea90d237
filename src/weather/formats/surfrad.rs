//! Reader of daily files of SURFRAD. In: a file's bytes. Out: its rows, not yet filled or checked
//! against each other.
//!
//! Format: "Description of SURFRAD daily data files", NOAA Global Monitoring Laboratory: the
//! station's name, a line of latitude, longitude (west positive), elevation, then rows of 48
//! numbers in UTC. Each measurement has a quality flag behind it: 0 good, 1 impossible, 2 doubtful;
//! -9999.9 is missing. Rows are means over a minute, three minutes before 2009. A file may also
//! hold days one after the other, each with its two header lines.

use std::path::Path;

use crate::formats::stamp_text::{clock_seconds, digits};
use crate::formats::stamped::{LegalDays, StampedRows, SteppedRows};
use crate::judging::raw_weather::{AIR_C, RawRow, RawWeather, WIND_M_S, irradiance};
use crate::judging::station::Station;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::{Message, excerpt};
use heliotile_core::weather::air::{Air, dew_point_c};
use heliotile_core::weather::options::{StampedAt, WeatherOptions};
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::clock_zone::ClockZone;
use heliotile_core::weather::time::sun::Interval;

/// Index of the column in a row; a flag stands behind each from the eighth on.
const GHI: usize = 8;
const DNI: usize = 12;
const DHI: usize = 14;
const INFRARED: usize = 16;
const TEMPERATURE: usize = 38;
const HUMIDITY: usize = 40;
const WIND: usize = 42;
const COUNT: usize = 48;

/// Flag of an impossible measurement.
const IMPOSSIBLE: &str = "1";

/// Largest number that stands for a missing measurement.
const MISSING: f64 = -9999.0;

/// Returns true if the second line is that of a station.
pub(super) fn is_surfrad(bytes: &[u8]) -> bool {
    let second = bytes.split(|byte| *byte == b'\n').nth(1).unwrap_or_default();
    let words = || second.split(|byte| byte.is_ascii_whitespace()).filter(|word| !word.is_empty());
    words().nth(3) == Some(b"m") && words().nth(4) == Some(b"version")
}

pub(super) fn read(path: &Path, bytes: &[u8], options: &WeatherOptions) -> Result<RawWeather> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines().map(str::trim).zip(1_usize..);
    let name = lines.next().map_or("", |(line, _)| line);
    let place = lines.next().map_or("", |(line, _)| line);
    let station = station(path, name, place)?;
    let (mut rows, mut seconds, mut air) = (Vec::new(), Vec::new(), Vec::new());
    for (line, number) in lines {
        if line.is_empty() || line == name || line == place {
            continue;
        }
        let cells: Vec<&str> = line.split_ascii_whitespace().collect();
        if cells.len() != COUNT {
            let what = format!("the row has {} columns instead of {COUNT}", cells.len());
            return Err(Error::input(path, number, what, "the file may be cut off; fetch it again"));
        }
        let row = SurfradRow { path, line: number, cells };
        seconds.push(row.seconds()?);
        rows.push(row.light()?);
        if options.with_air {
            air.push(row.air());
        }
    }
    if rows.is_empty() {
        return Err(Error::input(path, None, "the file has no weather rows", "SURFRAD has them from line 3 on"));
    }
    let year = seconds.first().and_then(|first| Date::of_day_number((first / 86_400) as i32)).map(|date| date.year);
    let zone = options.zone.unwrap_or(ClockZone::Hours(0.0));
    let zone_hours = zone.standard_hours(year.unwrap_or(Date::NO_YEAR));
    let station = Station { zone_hours: Some(zone_hours), ..station };
    let ahead = (zone_hours * 3600.0).round() as i64;
    seconds.iter_mut().for_each(|stamp| *stamp += ahead);
    let legal = matches!(zone, ClockZone::Named(_)).then_some(LegalDays { zone, standard_hours: zone_hours });
    let stamped_at = options.stamped_at.unwrap_or(StampedAt::End);
    // A daily file starts with 00:00.
    let stamped = StampedRows { rows, seconds, stamped_at, day_of_start: false, late_min: 0.0, moved_s: ahead, legal };
    let SteppedRows { rows, step_min, warning } = stamped.stepped(path)?;
    Ok(RawWeather {
        station,
        rows,
        air,
        step_min,
        stamped_at,
        zenith_deg: Vec::new(),
        warnings: warning.into_iter().map(Message::from).collect(),
    })
}

fn station(path: &Path, name: &str, place: &str) -> Result<Station> {
    let mut words = place.split_ascii_whitespace();
    let mut number = |name: &str| {
        let text = words.next().unwrap_or_default();
        let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
        let hint =
            "SURFRAD writes latitude, longitude (west positive) and elevation, such as `37.70 105.92 2317 m version 1`";
        value.ok_or_else(|| Error::input(path, 2, format!("{name} holds `{}`", excerpt(text, 60)), hint))
    };
    let (latitude, west, elevation_m) = (number("latitude")?, number("longitude")?, number("elevation")?);
    Ok(Station {
        name: name.to_owned(),
        latitude_deg: Some(latitude),
        longitude_deg: Some(-west),
        zone_hours: None,
        zone_is_certain: true,
        elevation_m,
    })
}

/// Cells of a row.
struct SurfradRow<'a> {
    path: &'a Path,
    line: usize,
    cells: Vec<&'a str>,
}

impl SurfradRow<'_> {
    fn cell(&self, place: usize) -> &str {
        self.cells.get(place).copied().unwrap_or_default()
    }

    fn seconds(&self) -> Result<i64> {
        let whole = |place: usize| digits(self.cell(place));
        let read = || {
            let date = Date::new(i32::try_from(whole(0)?).ok()?, whole(2)?, whole(3)?)?;
            let (hour, minute) = (whole(4).filter(|hour| *hour < 24)?, whole(5).filter(|minute| *minute < 60)?);
            Some(clock_seconds(date, i64::from(hour * 3600 + minute * 60)))
        };
        let what = "year, month, day, hour and minute do not form an existing time";
        read().ok_or_else(|| Error::input(self.path, self.line, what, "fetch the file again"))
    }

    fn light(&self) -> Result<RawRow> {
        let mut negative = false;
        let mut light = |place: usize, name: &str| {
            let text = self.cell(place);
            let missing = |value: f64| value.is_finite() && (value <= MISSING || self.cell(place + 1) == IMPOSSIBLE);
            irradiance(text, missing, &mut negative, || {
                let what = format!("column `{name}` holds `{}`", excerpt(text, 60));
                Error::input(self.path, self.line, what, "write W/m2, -9999.9 where missing")
            })
        };
        let (ghi, dni, dhi) = (light(GHI, "dw_solar")?, light(DNI, "direct_n")?, light(DHI, "diffuse")?);
        let interval = Interval { date: Date::OF_DAY_0, start_min: 0.0, end_min: 0.0 };
        Ok(RawRow { line: self.line, interval, ghi, dni, dhi, negative, albedo: None, snow_depth_cm: None })
    }

    fn air(&self) -> Air {
        let number = |place: usize, [low, high]: [f64; 2]| {
            let value = self.cell(place).parse().ok().filter(|value| (low..=high).contains(value));
            value.filter(|_: &f64| self.cell(place + 1) != IMPOSSIBLE)
        };
        let dry_bulb_c = number(TEMPERATURE, AIR_C);
        let dew = |dry, humidity| Some(dew_point_c(dry, humidity)).filter(|dew| (AIR_C[0]..=AIR_C[1]).contains(dew));
        Air {
            dry_bulb_c,
            dew_point_c: dry_bulb_c.zip(number(HUMIDITY, [0.1, 100.0])).and_then(|(dry, humidity)| dew(dry, humidity)),
            infrared_w_m2: number(INFRARED, [1.0, 800.0]),
            opaque_sky_tenths: None,
            wind_m_s: number(WIND, WIND_M_S),
        }
    }
}
