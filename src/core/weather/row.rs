//! One row of a weather file, checked.

use glam::DVec3;

use crate::weather::time::sun::Interval;

/// One interval of a weather file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeatherRow {
    /// Line of the file, counted from 1.
    pub line: usize,
    /// Date and interval in local standard time.
    pub interval: Interval,
    /// Unit vector towards the sun at mid-interval; below the horizon at night.
    pub sun: DVec3,
    /// Global horizontal irradiance, W/m2, mean over the interval; `None` where the file has none.
    pub ghi_w_m2: Option<f64>,
    /// Direct normal irradiance, W/m2, mean over the interval, 0 or more; 0 where the file has none
    /// and it could not be computed.
    pub dni_w_m2: f64,
    /// Diffuse horizontal irradiance, W/m2, mean over the interval, 0 or more; 0 where the file has
    /// none and it could not be computed.
    pub dhi_w_m2: f64,
    /// Albedo of the ground around the station, above 0 and at most 1; `None` where missing.
    pub albedo: Option<f64>,
    /// Snow depth, centimetres; 0 where the ground is bare, `None` where missing.
    pub snow_depth_cm: Option<f64>,
}
