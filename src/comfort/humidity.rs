//! Water vapour in air. In: temperatures in degrees Celsius, relative humidity in percent. Out:
//! pressures in hPa.
//!
//! Relative humidity is over liquid water at all temperatures, as weather stations report it
//! (WMO-No. 8, Guide to Instruments and Methods of Observation).

use std::ops::RangeInclusive;

use heliotile_core::weather::emission::ZERO_CELSIUS_K;

/// Range of temperatures of the saturation pressure, degrees Celsius.
const RANGE_C: RangeInclusive<f64> = -100.0..=100.0;

/// Returns the saturation pressure of water vapour over liquid water, hPa, or `None` outside
/// -100..=100 degrees Celsius.
///
/// Hardy, "ITS-90 formulations for vapor pressure, frostpoint temperature, dewpoint temperature,
/// and enhancement factors in the range -100 to +100 C", Third International Symposium on Humidity
/// and Moisture, 1998. The operational UTCI uses this formula, too (function `es` of UTCI_approx,
/// version a 0.002).
pub fn saturation_pressure_hpa(temperature_c: f64) -> Option<f64> {
    RANGE_C.contains(&temperature_c).then(|| {
        let k = temperature_c + ZERO_CELSIUS_K;
        let inverse_powers = (-2.8365744e3 / k - 6.028076559e3) / k;
        let powers = -2.737830188e-2 + k * (1.6261698e-5 + k * (7.0229056e-10 + k * -1.8680009e-13));
        0.01 * (inverse_powers + 1.954263612e1 + k * powers + 2.7150305 * k.ln()).exp()
    })
}

/// Returns the vapour pressure of air, hPa, from its temperature and relative humidity, or `None`
/// outside -100..=100 degrees Celsius or 0..=100 %.
pub fn vapour_pressure_hpa(air_temperature_c: f64, relative_humidity_percent: f64) -> Option<f64> {
    let share = Some(relative_humidity_percent / 100.0).filter(|share| (0.0..=1.0).contains(share))?;
    Some(share * saturation_pressure_hpa(air_temperature_c)?)
}

/// Returns the relative humidity of air, percent, from its temperature and dew point, or `None`
/// outside -100..=100 degrees Celsius.
///
/// A dew point above the temperature is an error of the weather file; the air then counts as
/// saturated, 100 %.
pub fn relative_humidity_percent(air_temperature_c: f64, dew_point_c: f64) -> Option<f64> {
    let share = saturation_pressure_hpa(dew_point_c)? / saturation_pressure_hpa(air_temperature_c)?;
    Some(100.0 * share.min(1.0))
}

/// Returns the saturation pressure that the PET uses, hPa: over ice below 0 degrees Celsius, over
/// water from there on.
///
/// ASHRAE Handbook Fundamentals, 2017, chapter 1, equations 5 and 6, after Hyland and Wexler, 1983;
/// -100 to 200 degrees Celsius. The reference implementation pythermalcomfort uses it, so that
/// equal inputs give equal PET.
pub(super) fn ashrae_saturation_pressure_hpa(temperature_c: f64) -> f64 {
    let k = temperature_c + ZERO_CELSIUS_K;
    let exponent = if temperature_c < 0.0 {
        let powers = -9.677843e-3 + k * (6.2215701e-7 + k * (2.0747825e-9 + k * -9.484024e-13));
        -5.6745359e3 / k + 6.3925247 + k * powers + 4.1635019 * k.ln()
    } else {
        let powers = -4.8640239e-2 + k * (4.1764768e-5 + k * -1.4452093e-8);
        -5.8002206e3 / k + 1.3914993 + k * powers + 6.5459673 * k.ln()
    };
    0.01 * exponent.exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Saturation pressure over water is 6.11657 hPa at the triple point, 0.01 degrees Celsius,
    /// 23.392 at 20, 123.52 at 50 and 1014.18 at 100 (IAPWS-95), within 0.01 %.
    #[test]
    fn saturation_pressures_agree_with_iapws() {
        for (temperature_c, expected) in [(0.01, 6.116_57), (20.0, 23.392), (50.0, 123.52), (100.0, 1014.18)] {
            let got = saturation_pressure_hpa(temperature_c).expect("within the range");
            assert!((got / expected - 1.0).abs() < 1e-4, "{temperature_c}: {got}");
        }
    }

    /// The pressure of the PET agrees with ITS-90 within 0.1 % above 0 degrees Celsius. At -20 it
    /// is the pressure over ice, 1.0326 hPa (IAPWS), within 0.1 %.
    #[test]
    fn the_pressure_of_the_pet_agrees_with_its_90() {
        for temperature_c in 0..=99 {
            let temperature_c = f64::from(temperature_c);
            let its = saturation_pressure_hpa(temperature_c).expect("within the range");
            let ashrae = ashrae_saturation_pressure_hpa(temperature_c);
            assert!((ashrae / its - 1.0).abs() < 1e-3, "{temperature_c}: {its} {ashrae}");
        }
        assert!((ashrae_saturation_pressure_hpa(-20.0) / 1.0326 - 1.0).abs() < 1e-3);
    }

    /// Half saturated air has half the pressure. Humidity from a dew point gives back the dew
    /// point's pressure within 1e-12 of it. A dew point above the temperature is 100 %.
    #[test]
    fn a_dew_point_gives_back_its_pressure() {
        let full = saturation_pressure_hpa(25.0).expect("within the range");
        assert_eq!(vapour_pressure_hpa(25.0, 50.0), Some(0.5 * full));
        for (air_c, dew_c) in [(25.0, 13.0), (-5.0, -20.0), (30.0, 30.0)] {
            let percent = relative_humidity_percent(air_c, dew_c).expect("within the range");
            let (left, right) = (vapour_pressure_hpa(air_c, percent), saturation_pressure_hpa(dew_c));
            let (left, right) = (left.expect("within the range"), right.expect("within the range"));
            assert!((left / right - 1.0).abs() < 1e-12, "{air_c} {dew_c}: {left} {right}");
        }
        assert_eq!(relative_humidity_percent(10.0, 12.0), Some(100.0));
    }

    /// NaN, infinity and values outside the ranges give `None`: 5 of 5.
    #[test]
    fn values_outside_the_ranges_have_no_pressure() {
        assert_eq!(saturation_pressure_hpa(f64::NAN), None);
        assert_eq!(saturation_pressure_hpa(100.1), None);
        assert_eq!(vapour_pressure_hpa(20.0, 100.1), None);
        assert_eq!(vapour_pressure_hpa(20.0, f64::NAN), None);
        assert_eq!(relative_humidity_percent(20.0, f64::NEG_INFINITY), None);
    }
}
