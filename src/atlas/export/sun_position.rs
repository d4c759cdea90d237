//! A sun above the horizon. In: two numbers, or their text. Out: a direction.

use std::str::FromStr;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use heliotile_core::units::direction_from_degrees;

/// Position of a sun above the horizon, as `[azimuth, altitude]`, degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "[f64; 2]", try_from = "[f64; 2]")]
pub struct SunPosition {
    azimuth_deg: f64,
    altitude_deg: f64,
}

impl SunPosition {
    /// Returns a sun at an azimuth, clockwise from true north, and an altitude, degrees. An error:
    /// a number that is out of range.
    pub fn new(azimuth_deg: f64, altitude_deg: f64) -> Result<Self, String> {
        if !(-360.0..=360.0).contains(&azimuth_deg) {
            return Err(format!("the azimuth is {azimuth_deg}, it must be from -360 to 360"));
        }
        if altitude_deg <= 0.0 {
            return Err(format!("the sun is at {altitude_deg} degrees, not above the horizon: it lights nothing"));
        }
        // False for NaN.
        if !(0.0..=90.0).contains(&altitude_deg) {
            return Err(format!("the altitude is {altitude_deg}, it must be above 0 and at most 90"));
        }
        Ok(SunPosition { azimuth_deg, altitude_deg })
    }

    /// Returns the azimuth, degrees clockwise from true north.
    pub fn azimuth_deg(self) -> f64 {
        self.azimuth_deg
    }

    /// Returns the altitude above the horizon, degrees.
    pub fn altitude_deg(self) -> f64 {
        self.altitude_deg
    }

    /// Returns the direction to the sun, with y to true north.
    pub fn direction(self) -> DVec3 {
        direction_from_degrees(self.azimuth_deg, self.altitude_deg)
    }
}

impl From<SunPosition> for [f64; 2] {
    fn from(sun: SunPosition) -> [f64; 2] {
        [sun.azimuth_deg, sun.altitude_deg]
    }
}

impl TryFrom<[f64; 2]> for SunPosition {
    type Error = String;

    fn try_from([azimuth_deg, altitude_deg]: [f64; 2]) -> Result<Self, String> {
        SunPosition::new(azimuth_deg, altitude_deg)
    }
}

/// Parses `azimuth,altitude` in degrees.
impl FromStr for SunPosition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let hint = "give azimuth,altitude in degrees, as in 180,45";
        let (azimuth, altitude) = text.split_once(',').ok_or(hint)?;
        let number = |part: &str| part.trim().parse::<f64>().map_err(|_| format!("`{part}` is not a number: {hint}"));
        SunPosition::new(number(azimuth)?, number(altitude)?)
    }
}

heliotile_requests::parse_by_text!(SunPosition: heliotile_requests::Form::TEXT);

#[cfg(test)]
mod tests {
    use super::*;

    /// A sun in the south at 45 degrees is the same as text and as JSON; 5 texts that are no sun
    /// are refused.
    #[test]
    fn only_suns_above_the_horizon_are_accepted() {
        let sun: SunPosition = "180, 45".parse().expect("a sun");
        assert_eq!(serde_json::from_str::<SunPosition>("[180, 45]").expect("a sun"), sun);
        assert_eq!(serde_json::to_string(&sun).expect("JSON"), "[180.0,45.0]");
        assert!(sun.direction().abs_diff_eq(DVec3::new(0.0, -0.5, 0.5) * 2_f64.sqrt(), 1e-12), "{sun:?}");
        for text in ["180", "south,45", "361,45", "180,-5", "180,91"] {
            assert!(text.parse::<SunPosition>().is_err(), "{text}");
        }
    }
}
