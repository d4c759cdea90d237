//! Units and the world frame: x east, y north, z up, metres; irradiance in W/m2, angles inside the library in radians.

use glam::DVec3;

/// Half the apparent diameter of the sun's disc (0.533 deg, mean over the year), in radians.
pub const SUN_RADIUS_RAD: f64 = 0.533 / 2.0 * std::f64::consts::PI / 180.0;

/// Unit vector towards a point of the sky. Azimuth is clockwise from north, altitude above the horizon, both in degrees.
pub fn direction_from_degrees(azimuth_deg: f64, altitude_deg: f64) -> DVec3 {
    let (sin_azimuth, cos_azimuth) = azimuth_deg.to_radians().sin_cos();
    let (sin_altitude, cos_altitude) = altitude_deg.to_radians().sin_cos();
    DVec3::new(cos_altitude * sin_azimuth, cos_altitude * cos_azimuth, sin_altitude)
}

/// Sums over a period are reported in kWh/m2: watts held for one hour, over 1000.
pub fn kwh_from_w(mean_w_m2: f64, hours: f64) -> f64 {
    mean_w_m2 * hours / 1000.0
}
