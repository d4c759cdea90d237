//! A weather file as it stands there, before it is judged.

use crate::error::{Error, Result};
use crate::weather::air::Air;
use crate::weather::judging::station::Station;
use crate::weather::options::StampedAt;
use crate::weather::time::sun::Interval;

/// Thermopile pyranometers read a little below 0 under a cold sky: ISO 9060:2018 allows class C an offset of 30 W/m2. Below
/// that a number is a foreign code for missing (-99, -999) or a slip.
const LOWEST_OFFSET_W_M2: f64 = -30.0;

/// The coldest and hottest air near the ground, with room: -89 (Vostok, 1983) and 57 degrees Celsius (Death Valley, 1913).
pub const AIR_C: [f64; 2] = [-90.0, 70.0];

/// Winds that are believed, m/s; 99 and 999 stand for missing.
pub const WIND_M_S: [f64; 2] = [0.0, 60.0];

/// What a reader makes of a file.
pub struct RawWeather {
    pub station: Station,
    /// In file order, at least one.
    pub rows: Vec<RawRow>,
    /// `[row]`; empty if only light was asked for.
    pub air: Vec<Air>,
    /// Length of every row's interval.
    pub step_min: f64,
    /// Where in its interval each row's time stamp was taken to stand.
    pub stamped_at: StampedAt,
    /// What the reader has to say, each sentence naming the file.
    pub warnings: Vec<String>,
}

/// A row as it stands in the file.
pub struct RawRow {
    pub line: usize,
    pub interval: Interval,
    pub ghi: Option<f64>,
    pub dni: Option<f64>,
    pub dhi: Option<f64>,
    /// Whether one of them was below 0, and was set to 0.
    pub negative: bool,
    /// Above 0 and at most 1; several sources write 0 where they have none, at night too.
    pub albedo: Option<f64>,
    pub snow_depth_cm: Option<f64>,
}

impl RawRow {
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
}

/// GHI, DNI or DHI as a cell says it; none where the number is `missing`, an error where it is no irradiance. What an instrument reads a
/// little below 0 is 0, and `negative` is told.
pub fn irradiance(
    text: &str,
    missing: impl Fn(f64) -> bool,
    negative: &mut bool,
    bad: impl FnOnce() -> Error,
) -> Result<Option<f64>> {
    match text.parse::<f64>() {
        Ok(value) if missing(value) => Ok(None),
        Ok(value) => irradiance_of(value, negative).map(Some).ok_or_else(bad),
        Err(_) => Err(bad()),
    }
}

/// A number of W/m2 as an irradiance, if it can be one: what an instrument reads a little below 0 is 0, and `negative` is told.
pub fn irradiance_of(value: f64, negative: &mut bool) -> Option<f64> {
    if (LOWEST_OFFSET_W_M2..0.0).contains(&value) {
        *negative = true;
        return Some(0.0);
    }
    // Adding 0 turns the -0.00 of some files into 0.
    (value >= 0.0 && value.is_finite()).then_some(value + 0.0)
}
