//! Units and the world frame: x east, y north, z up, metres; irradiance in W/m2, angles inside the
//! library in radians.

use std::str::FromStr;

use glam::DVec3;

/// Half the apparent diameter of the sun's disc (0.533 deg, mean over the year), in radians.
pub const SUN_RADIUS_RAD: f64 = 0.533 / 2.0 * std::f64::consts::PI / 180.0;

/// Returns the unit vector towards a point of the sky. Azimuth is clockwise from north, altitude
/// above the horizon, both in degrees.
pub fn direction_from_degrees(azimuth_deg: f64, altitude_deg: f64) -> DVec3 {
    let (sin_azimuth, cos_azimuth) = azimuth_deg.to_radians().sin_cos();
    let (sin_altitude, cos_altitude) = altitude_deg.to_radians().sin_cos();
    DVec3::new(cos_altitude * sin_azimuth, cos_altitude * cos_azimuth, sin_altitude)
}

/// Returns an energy in kWh/m2: a mean of W/m2 times hours, over 1000. Sums over a period are
/// reported in this unit.
pub fn kwh_from_w(mean_w_m2: f64, hours: f64) -> f64 {
    mean_w_m2 * hours / 1000.0
}

/// Returns the orientation of a surface: tilt in degrees (0 up, 90 level, 180 down) and azimuth in
/// degrees clockwise from y (north), 0 up to 360. A surface that faces straight up or down has
/// azimuth 0.
pub fn tilt_and_azimuth(normal: DVec3) -> (f64, f64) {
    let level = normal.x.hypot(normal.y);
    let azimuth = normal.x.atan2(normal.y).to_degrees();
    // Rounding of a tiny negative angle gives 360.
    let azimuth = if level < 1e-9 { 0.0 } else { azimuth.rem_euclid(360.0) % 360.0 };
    (level.atan2(normal.z).to_degrees(), azimuth)
}

/// A number of bytes: `2GiB`, `512MiB`, `800MB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bytes(
    /// The number of bytes.
    pub u64,
);

impl FromStr for Bytes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        let hint = "give a number and MiB, GiB, MB or GB, as in 512MiB";
        let unit = match &text[digits.len()..] {
            "GiB" | "G" => 1 << 30,
            "MiB" | "M" => 1 << 20,
            "GB" => 1_000_000_000,
            "MB" => 1_000_000,
            "B" => 1,
            "" => return Err(format!("there is no unit: {hint}")),
            other => return Err(format!("`{other}` is not a unit: {hint}")),
        };
        let number = digits.trim().parse::<f64>().ok().filter(|number| *number >= 0.0);
        let number = number.ok_or_else(|| format!("`{digits}` is not a number of bytes: {hint}"))?;
        // `as` saturates.
        Ok(Bytes((number * unit as f64) as u64))
    }
}

/// Reads a length in metres: `2m`, `50cm`, `20mm`, or a number of metres.
pub fn parse_metres(text: &str) -> Result<f64, String> {
    let hint = "give a length from 1mm to 10km, such as 2m, 50cm or 20mm";
    let text = text.trim();
    let units = [("mm", 1e-3), ("cm", 1e-2), ("km", 1e3), ("m", 1.0)];
    let unit = units.into_iter().find_map(|(name, metres)| Some((text.strip_suffix(name)?, metres)));
    let (digits, metres) = unit.unwrap_or((text, 1.0));
    let metres = metres * digits.trim().parse::<f64>().map_err(|_| format!("`{text}` is not a length: {hint}"))?;
    // The comparison is false for NaN.
    match (0.001..=10_000.0).contains(&metres) {
        true => Ok(metres),
        false => Err(format!("`{text}` is out of range: {hint}")),
    }
}

/// Reads a number of 0 or more.
pub fn parse_amount(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|value| value.is_finite() && *value >= 0.0);
    number.ok_or_else(|| "give a number of 0 or more".to_owned())
}

/// Reads a number above 0.
pub fn parse_positive(text: &str) -> Result<f64, String> {
    parse_amount(text).ok().filter(|value| *value > 0.0).ok_or_else(|| "give a number above 0".to_owned())
}

/// Reads a percentage, `2%`, `0.5 %` or `2`; `None` outside a range.
pub fn parse_percent(text: &str, range: std::ops::RangeInclusive<f64>) -> Option<f64> {
    let number = text.trim().trim_end_matches('%').trim_end().parse().ok()?;
    range.contains(&number).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six normals have the tilt and azimuth of the compass, within 1e-12 degrees.
    #[test]
    fn normals_have_the_tilt_and_azimuth_of_the_compass() {
        let half = 0.5_f64.sqrt();
        for (normal, tilt, azimuth) in [
            (DVec3::Z, 0.0, 0.0),
            (DVec3::NEG_Z, 180.0, 0.0),
            (DVec3::Y, 90.0, 0.0),
            (DVec3::X, 90.0, 90.0),
            (DVec3::NEG_X, 90.0, 270.0),
            (DVec3::new(0.0, -half, half), 45.0, 180.0),
        ] {
            let (t, a) = tilt_and_azimuth(normal);
            assert!((t - tilt).abs() < 1e-12 && (a - azimuth).abs() < 1e-12, "{normal}: {t} {a}");
        }
        assert_eq!(tilt_and_azimuth(DVec3::new(-1e-18, 1.0, 0.0)).1, 0.0);
    }

    /// Five lengths are read in their units, six texts are refused. Percentages keep their range.
    #[test]
    fn lengths_and_percentages_are_read() {
        for (text, metres) in [("2m", 2.0), ("50 cm", 0.5), ("20mm", 0.02), ("1.5", 1.5), ("0.5km", 500.0)] {
            assert_eq!(parse_metres(text), Ok(metres), "{text}");
        }
        for text in ["", "m", "2ft", "-1m", "nan", "1e9m"] {
            assert!(parse_metres(text).is_err(), "{text}");
        }
        for (text, value) in [("2%", Some(2.0)), ("0.5 %", Some(0.5)), ("3", Some(3.0)), ("80%", None), ("%", None)] {
            assert_eq!(parse_percent(text, 0.1..=50.0), value, "{text}");
        }
        assert!(parse_amount("-1").is_err() && parse_positive("0").is_err() && parse_positive("nan").is_err());
    }
}
