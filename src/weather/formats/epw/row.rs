//! A row of a weather file. In: the cells of a line. Out: its interval and irradiances, not yet
//! filled or checked against each other.

use std::path::Path;

use crate::judging::raw_weather::{RawRow, irradiance};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::{Message, excerpt};
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::sun::Interval;

/// Index of the column in a data row.
const MINUTE: usize = 4;
const GHI: usize = 13;
const DNI: usize = 14;
pub const DHI: usize = 15;
pub const YEAR: usize = 0;
const SNOW_DEPTH: usize = 30;
const ALBEDO: usize = 32;

const MISSING_RADIATION: f64 = 9999.0;
/// Numbers that some programs write for a missing GHI in place of 9999. EnergyPlus, which uses DNI
/// and DHI, runs such files.
const MISSING_CODES: [f64; 3] = [-99.0, -999.0, -9999.0];
const MISSING_SNOW_CM: f64 = 999.0;

/// Reads the cells of a line. `odd_minute` gets line and minute of the first hourly row whose
/// minute is not 0 or 60.
pub fn read_row(
    path: &Path,
    line: usize,
    cells: &[&str],
    records_per_hour: u32,
    odd_minute: &mut Option<(usize, u32)>,
) -> Result<RawRow> {
    let cell = |i: usize| cells.get(i).copied().unwrap_or_default();
    let bad = |name: &str, text: &str, hint: Message| {
        Error::input(path, line, format!("column `{name}` holds `{}`", excerpt(text, 60)), hint)
            .because(Problem::value(name, text))
    };
    let mut clock = [0_u32; 5];
    let names = ["year", "month", "day", "hour", "minute"];
    for (i, (value, name)) in clock.iter_mut().zip(names).enumerate() {
        let text = cell(i);
        *value = text.parse().map_err(|_| bad(name, text, "write a whole number".into()))?;
    }
    let [year, month, day, hour, minute] = clock;
    // EnergyPlus runs files whose years are 0.
    let date = match year {
        0 => Date::of_no_year(month, day),
        _ => i32::try_from(year).ok().and_then(|year| Date::new(year, month, day)),
    };
    let Some(date) = date else {
        let what = format!("the date {year}-{month}-{day} does not exist");
        return Err(Error::input(path, line, what, "correct year, month or day"));
    };
    if !(1..=24).contains(&hour) {
        return Err(bad("hour", cell(3), "hours run from 1 to 24".into()));
    }
    let step = 60 / records_per_hour;
    let minute = match minute {
        0 => 60,
        _ if records_per_hour == 1 => {
            if minute != 60 {
                odd_minute.get_or_insert((line, minute));
            }
            60
        }
        1..=60 if minute % step == 0 => minute,
        _ => {
            let hint = format!("with {records_per_hour} records an hour, minutes are multiples of {step} up to 60");
            return Err(bad("minute", cell(MINUTE), hint.into()));
        }
    };
    let end = (hour - 1) * 60 + minute;
    let mut negative = false;
    let mut radiation = |i: usize, name: &str| {
        let text = cell(i);
        let codes: &[f64] = if i == GHI { &MISSING_CODES } else { &[] };
        if text.is_empty() {
            return Ok(None);
        }
        let missing = |value| value >= MISSING_RADIATION || codes.contains(&value);
        irradiance(text, missing, &mut negative, || bad(name, text, "write W/m2 from 0 up, 9999 where missing".into()))
    };
    let optional = |i: usize, low: f64, high: f64| {
        let value = cell(i).parse::<f64>().ok();
        value.filter(|v| (low..=high).contains(v))
    };
    let ghi = radiation(GHI, "global horizontal radiation")?;
    let dni = radiation(DNI, "direct normal radiation")?;
    let dhi = radiation(DHI, "diffuse horizontal radiation")?;
    Ok(RawRow {
        line,
        interval: Interval { date, start_min: f64::from(end - step), end_min: f64::from(end) },
        ghi,
        dni,
        dhi,
        negative,
        albedo: optional(ALBEDO, 0.0, 1.0).filter(|a| *a > 0.0),
        snow_depth_cm: optional(SNOW_DEPTH, 0.0, MISSING_SNOW_CM - 0.5),
    })
}
