//! Air and sky of a weather file's row, as far as longwave radiation needs them. In: the cells of a
//! row. Out: the longwave irradiance of the open sky, as given or computed.

use crate::weather::emission::{ZERO_CELSIUS_K, black_body_w_m2};

/// Air of a row; `None` for a missing value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Air {
    /// Temperature of the air, degrees Celsius.
    pub dry_bulb_c: Option<f64>,
    /// Dew point of the air, degrees Celsius.
    pub dew_point_c: Option<f64>,
    /// Horizontal infrared radiation intensity, W/m2.
    pub infrared_w_m2: Option<f64>,
    /// Opaque sky cover, tenths.
    pub opaque_sky_tenths: Option<f64>,
    /// Wind at 10 m above the ground, m/s.
    pub wind_m_s: Option<f64>,
}

impl Air {
    /// Returns air of a temperature and a relative humidity in percent, above 0, without other
    /// values.
    pub fn of_humidity(dry_bulb_c: f64, humidity_percent: f64) -> Self {
        let dew_point_c = Some(dew_point_c(dry_bulb_c, humidity_percent));
        Air { dry_bulb_c: Some(dry_bulb_c), dew_point_c, ..Air::default() }
    }

    /// Returns the longwave irradiance of an open horizontal surface, W/m2: as given, else
    /// computed; `None` if it cannot be computed.
    pub fn sky_w_m2(&self) -> Option<f64> {
        let computed = || {
            let emissivity = sky_emissivity(self.dry_bulb_c?, self.dew_point_c?, self.opaque_sky_tenths?);
            Some(emissivity * black_body_w_m2(self.dry_bulb_c?))
        };
        self.infrared_w_m2.or_else(computed)
    }

    /// Returns the names of the values that the computation needs and the row lacks.
    pub fn lacks(&self) -> Vec<&'static str> {
        let needed = [
            (self.dry_bulb_c, "dry bulb temperature"),
            (self.dew_point_c, "dew point temperature"),
            (self.opaque_sky_tenths, "opaque sky cover"),
        ];
        needed.into_iter().filter(|(value, _)| value.is_none()).map(|(_, name)| name).collect()
    }
}

/// Returns the emissivity of the sky: Clark and Allen, "The estimation of atmospheric radiation for
/// clear and cloudy skies", 1978, for its clear part, times Walton, "Thermal analysis research
/// program reference manual", 1983, p. 21, for clouds. Both are taken as in EnergyPlus,
/// "Engineering reference", section "Sky radiation modeling", which states no range.
///
/// There 0 degrees Celsius is 273 K. With 273.15 K, as in EnergyPlus itself, the column of a file
/// that was computed so comes out within its rounding. A dew point above the temperature is an
/// error of the file. The result is at most 1, that of a black body.
fn sky_emissivity(dry_bulb_c: f64, dew_point_c: f64, opaque_sky_tenths: f64) -> f64 {
    let dew_point_k = dry_bulb_c.min(dew_point_c) + ZERO_CELSIUS_K;
    let n = opaque_sky_tenths;
    let clear = 0.787 + 0.764 * (dew_point_k / ZERO_CELSIUS_K).ln();
    (clear * (1.0 + 0.0224 * n - 0.0035 * n * n + 0.00028 * n * n * n)).min(1.0)
}

/// Returns the dew point from temperature and relative humidity in percent, above 0, by the Magnus
/// formula over water with the coefficients of Alduchov and Eskridge, "Improved Magnus form
/// approximation of saturation vapor pressure", Journal of Applied Meteorology 35, 1996, eq. 21
/// (0.4 % of the pressure from -40 to 50 degrees Celsius).
pub fn dew_point_c(dry_bulb_c: f64, humidity_percent: f64) -> f64 {
    const A: f64 = 17.625;
    const B_C: f64 = 243.04;
    let exponent = (humidity_percent / 100.0).ln() + A * dry_bulb_c / (B_C + dry_bulb_c);
    B_C * exponent / (A - exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn air(dry_bulb_c: f64, dew_point_c: f64, opaque_sky_tenths: f64) -> Air {
        let [dry_bulb_c, dew_point_c, opaque_sky_tenths] = [dry_bulb_c, dew_point_c, opaque_sky_tenths].map(Some);
        Air { dry_bulb_c, dew_point_c, opaque_sky_tenths, ..Air::default() }
    }

    /// By hand: at 20 and a dew point of 10 degrees Celsius a clear sky has an emissivity of
    /// 0.787 + 0.764 ln(283.15 / 273.15) = 0.81447, 341.1 W/m2. Full cover times 1.154 makes it
    /// 0.93990, 393.6 W/m2; half cover times 1.0595, 361.4 W/m2. The example of the engineering
    /// reference, 293 and 283 K, is 340.6 there and 340.2 here.
    #[test]
    fn sky_radiation_agrees_with_hand_computation() {
        for (air, expected) in [
            (air(20.0, 10.0, 0.0), 341.07),
            (air(20.0, 10.0, 10.0), 393.60),
            (air(20.0, 10.0, 5.0), 361.37),
            (air(19.85, 9.85, 0.0), 340.21),
            // A dew point above the temperature counts as the temperature: 0.787 sigma 273.15^4.
            (air(0.0, 9.0, 0.0), 248.42),
            // 0.787 + 0.764 ln(308.15 / 273.15) = 0.87911, x 1.154 = 1.0145 is cut to 1: sigma
            // 308.15^4.
            (air(35.0, 35.0, 10.0), 511.28),
        ] {
            let got = air.sky_w_m2().expect("all is given");
            assert!((got - expected).abs() < 0.05, "{air:?}: {got}");
        }
    }

    /// Saturated air is at its dew point. At 25 degrees Celsius and 50 % the dew point is 13.86 (by
    /// hand: ln 0.5 + 17.625 x 25 / 268.04 = 0.95072, x 243.04 / 16.67428), to 0.01.
    #[test]
    fn saturated_air_is_at_its_dew_point() {
        for (dry_bulb_c, humidity, expected) in [(25.0, 50.0, 13.857), (-5.0, 100.0, -5.0), (30.0, 100.0, 30.0)] {
            assert!((dew_point_c(dry_bulb_c, humidity) - expected).abs() < 0.01, "{dry_bulb_c}");
        }
    }

    /// A given value, 237 W/m2, is taken. Without one of the three inputs nothing is computed, and
    /// its name is reported: 3 of 3.
    #[test]
    fn given_radiation_counts_and_missing_inputs_are_named() {
        let whole = air(20.0, 10.0, 5.0);
        assert_eq!(Air { infrared_w_m2: Some(237.0), dry_bulb_c: None, ..whole }.sky_w_m2(), Some(237.0));
        for (air, name) in [
            (Air { dry_bulb_c: None, ..whole }, "dry bulb temperature"),
            (Air { dew_point_c: None, ..whole }, "dew point temperature"),
            (Air { opaque_sky_tenths: None, ..whole }, "opaque sky cover"),
        ] {
            assert_eq!((air.sky_w_m2(), air.lacks()), (None, vec![name]));
        }
    }
}
