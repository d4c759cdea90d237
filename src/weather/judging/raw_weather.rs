//! Data of a weather file, not yet filled or checked against each other. In: cells. Out: rows with
//! `None` for missing values.

use crate::judging::station::Station;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::Message;
use heliotile_core::weather::air::Air;
use heliotile_core::weather::options::StampedAt;
use heliotile_core::weather::time::sun::Interval;

/// Lowest irradiance that counts as 0, W/m2. Thermopile pyranometers read a little below 0 under a
/// cold sky: ISO 9060:2018 allows class C an offset of 30 W/m2. A lower number is a foreign code
/// for missing (-99, -999) or a mistake.
const LOWEST_OFFSET_W_M2: f64 = -30.0;

/// Range of air temperatures near the ground, degrees Celsius, with room beyond the records: -89
/// (Vostok, 1983) and 57 (Death Valley, 1913).
pub const AIR_C: [f64; 2] = [-90.0, 70.0];

/// Range of wind speeds that are accepted, m/s; 99 and 999 stand for missing.
pub const WIND_M_S: [f64; 2] = [0.0, 60.0];

/// Result of a reader.
pub struct RawWeather {
    pub station: Station,
    /// Rows in file order, at least one.
    pub rows: Vec<RawRow>,
    /// `[row]`: its air; empty if only light was read.
    pub air: Vec<Air>,
    /// Length of every row's interval, minutes.
    pub step_min: f64,
    /// Place in its interval where each row's time stamp was taken to stand.
    pub stamped_at: StampedAt,
    /// `[row]`: zenith angle of the sun at its time stamp; empty if the file has no such column, or
    /// if the place of stamps is known without it.
    pub zenith_deg: Vec<Option<f64>>,
    /// Warnings of the reader, each a sentence that names the file.
    pub warnings: Vec<Message>,
}

/// A row of the file.
pub struct RawRow {
    pub line: usize,
    pub interval: Interval,
    pub ghi: Option<f64>,
    pub dni: Option<f64>,
    pub dhi: Option<f64>,
    /// True if one of GHI, DNI and DHI was below 0, and was set to 0.
    pub negative: bool,
    /// Albedo above 0 and at most 1. Several sources write 0 where they have none, at night, too.
    pub albedo: Option<f64>,
    pub snow_depth_cm: Option<f64>,
}

impl RawRow {
    /// Returns true if the next row starts where this one ends.
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

/// Codes for a missing irradiance in tables that lie above those of thousands: -99, -99.9, -99.99.
pub const MISSING_99: std::ops::RangeInclusive<f64> = -99.999..=-99.0;

/// Reads GHI, DNI or DHI from a cell; `None` where the number is `missing`, an error where it is no
/// irradiance. A number a little below 0 becomes 0 and sets `negative`.
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

/// Returns a number of W/m2 as an irradiance, if it can be one. A number a little below 0 becomes 0
/// and sets `negative`.
pub fn irradiance_of(value: f64, negative: &mut bool) -> Option<f64> {
    if (LOWEST_OFFSET_W_M2..0.0).contains(&value) {
        *negative = true;
        return Some(0.0);
    }
    // Adding 0 turns the -0.00 of some files into 0.
    (value >= 0.0 && value.is_finite()).then_some(value + 0.0)
}
