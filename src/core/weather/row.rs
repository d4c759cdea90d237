//! One row of a weather file, checked.

use glam::DVec3;

use crate::weather::time::sun::Interval;

/// One interval of a weather file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeatherRow {
    /// Line of the file, 1-based.
    pub line: usize,
    pub interval: Interval,
    /// Unit, towards the sun at mid-interval; below the horizon at night.
    pub sun: DVec3,
    /// Interval means; `None` where the file has none.
    pub ghi_w_m2: Option<f64>,
    pub dni_w_m2: f64,
    pub dhi_w_m2: f64,
    /// Of the ground around the station, above 0 and at most 1; `None` where missing.
    pub albedo: Option<f64>,
    /// 0 where the ground is bare, `None` where missing.
    pub snow_depth_cm: Option<f64>,
}
