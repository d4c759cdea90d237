//! A row of a weather file as it stands there, and the filling of its gaps.

use std::path::Path;

use glam::DVec3;

use super::super::calendar::Date;
use super::super::sun::{Interval, Site, extraterrestrial_w_m2};
use crate::error::{Error, Result};

/// Places of the columns in a data row.
const MINUTE: usize = 4;
const GHI: usize = 13;
const DNI: usize = 14;
pub const DHI: usize = 15;
const SNOW_DEPTH: usize = 30;
const ALBEDO: usize = 32;

const MISSING_RADIATION: f64 = 9999.0;
const MISSING_SNOW_CM: f64 = 999.0;

/// Below this cosine GHI says nothing about DNI: (GHI - DHI) / cos z would blow up.
const SMALLEST_COSINE: f64 = 0.05;

/// Sub-steps over which the cosine of a row is averaged for filling a gap.
const GAP_STEPS: usize = 4;

/// How a row's DNI and DHI came about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fill {
    Nothing,
    Reconstructed,
    Zeroed,
}

/// A row as it stands in the file.
pub struct RawRow {
    pub line: usize,
    pub interval: Interval,
    pub ghi: Option<f64>,
    pub dni: Option<f64>,
    pub dhi: Option<f64>,
    pub albedo: Option<f64>,
    pub snow_depth_cm: Option<f64>,
}

impl RawRow {
    /// Reads the cells of a line. `odd_minute` gets line and minute of the first hourly row whose minute is not 0 or 60.
    pub fn read(
        path: &Path,
        line: usize,
        cells: &[&str],
        records_per_hour: u32,
        odd_minute: &mut Option<(usize, u32)>,
    ) -> Result<Self> {
        let cell = |i: usize| cells.get(i).copied().unwrap_or_default();
        let bad = |name: &str, text: &str, hint: &str| {
            Error::input(path, line, format!("column `{name}` holds `{text}`"), hint)
        };
        let mut clock = [0_u32; 5];
        let names = ["year", "month", "day", "hour", "minute"];
        for (i, (value, name)) in clock.iter_mut().zip(names).enumerate() {
            let text = cell(i);
            *value = text.parse().map_err(|_| bad(name, text, "write a whole number"))?;
        }
        let [year, month, day, hour, minute] = clock;
        let date = i32::try_from(year).ok().and_then(|year| Date::new(year, month, day));
        let Some(date) = date else {
            let what = format!("the date {year}-{month}-{day} does not exist");
            return Err(Error::input(path, line, what, "correct year, month or day"));
        };
        if !(1..=24).contains(&hour) {
            return Err(bad("hour", cell(3), "hours run from 1 to 24"));
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
                return Err(bad("minute", cell(MINUTE), &hint));
            }
        };
        let end = (hour - 1) * 60 + minute;
        let radiation = |i: usize, name: &str| {
            let text = cell(i);
            match text.parse::<f64>() {
                Ok(value) if value >= MISSING_RADIATION => Ok(None),
                // Adding 0 turns the -0.00 of some files into 0.
                Ok(value) if value >= 0.0 => Ok(Some(value + 0.0)),
                _ => Err(bad(name, text, "write W/m2 from 0 up, 9999 where missing")),
            }
        };
        let optional = |i: usize, low: f64, high: f64| {
            let value = cell(i).parse::<f64>().ok();
            value.filter(|v| (low..=high).contains(v))
        };
        Ok(RawRow {
            line,
            interval: Interval { date, start_min: f64::from(end - step), end_min: f64::from(end) },
            ghi: radiation(GHI, "global horizontal radiation")?,
            dni: radiation(DNI, "direct normal radiation")?,
            dhi: radiation(DHI, "diffuse horizontal radiation")?,
            albedo: optional(ALBEDO, 0.0, 1.0),
            snow_depth_cm: optional(SNOW_DEPTH, 0.0, MISSING_SNOW_CM - 0.5),
        })
    }

    /// Whether the next row starts where this one ends.
    pub fn is_followed_by(&self, next: &RawRow) -> bool {
        let (end, start) = (self.interval.end_min, next.interval.start_min);
        if self.interval.date == next.interval.date {
            start == end
        } else {
            let whole_days = end == 1440.0 && start == 0.0;
            whole_days && self.interval.date.is_followed_by(next.interval.date)
        }
    }

    /// DNI and DHI: as given, from closure GHI = DHI + DNI cos z with the mean cosine of the sunlit part, or 0.
    pub fn fill(&self, site: &Site, sun: DVec3) -> (f64, f64, Fill) {
        let (ghi, dni, dhi) = match (self.ghi, self.dni, self.dhi) {
            (_, Some(dni), Some(dhi)) => return (dni, dhi, Fill::Nothing),
            (None, dni, dhi) => return (dni.unwrap_or(0.0), dhi.unwrap_or(0.0), Fill::Zeroed),
            (Some(_), None, None) => return (0.0, 0.0, Fill::Zeroed),
            (Some(ghi), dni, dhi) => (ghi, dni, dhi),
        };
        let suns = site.sunlit(&self.interval, sun, GAP_STEPS);
        let cosine = suns.iter().map(|s| s.z).sum::<f64>() / suns.len().max(1) as f64;
        if cosine < SMALLEST_COSINE {
            return (0.0, ghi, Fill::Reconstructed);
        }
        match (dni, dhi) {
            (Some(dni), _) => (dni, (ghi - dni * cosine).max(0.0), Fill::Reconstructed),
            (None, dhi) => {
                // More than the sun sends cannot be: the rest is diffuse or an error of the file.
                let most = extraterrestrial_w_m2(self.interval.date);
                let dhi = dhi.unwrap_or(0.0);
                (((ghi - dhi) / cosine).clamp(0.0, most), dhi, Fill::Reconstructed)
            }
        }
    }
}
