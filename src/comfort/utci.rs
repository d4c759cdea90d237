//! Universal Thermal Climate Index. In: air temperature, mean radiant temperature, wind at 10 m,
//! relative humidity. Out: the UTCI in degrees Celsius, and its stress category.
//!
//! The UTCI is the air temperature of a reference climate that strains a walking person as much as
//! the real climate does. The reference has 50 % relative humidity (at most 20 hPa), a mean radiant
//! temperature equal to that of the air, and 0.5 m/s of wind at 10 m. Sources: Bröde and others,
//! 2012, as in `utci_polynomial`.

use crate::humidity::vapour_pressure_hpa;
use crate::utci_polynomial::{PolynomialInput, utci_excess_k};
use std::ops::RangeInclusive;

/// Least wind at 10 m of the UTCI, m/s: that of the reference climate.
pub const CALM_M_S: f64 = 0.5;

/// Range of the air temperature, degrees Celsius.
const AIR_RANGE_C: RangeInclusive<f64> = -50.0..=50.0;
/// Largest mean radiant temperature less the air temperature, K.
pub const MAX_RADIANT_EXCESS_K: f64 = 70.0;

/// Range of the mean radiant temperature less the air temperature, K: -30 to 70, and a little more,
/// because a difference of temperatures is not exact.
const RADIANT_EXCESS_RANGE_K: RangeInclusive<f64> = -30.000_001..=MAX_RADIANT_EXCESS_K + 1e-6;
/// Range of the wind at 10 m, m/s.
const WIND_RANGE_M_S: RangeInclusive<f64> = CALM_M_S..=17.0;
/// Largest vapour pressure, hPa: a dew point of 32.9 degrees Celsius. UTCI_a002.f90 refuses more,
/// because the polynomial was not fitted there.
const MAX_VAPOUR_HPA: f64 = 50.0;

/// Climate that a UTCI is computed for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UtciInput {
    /// Air temperature, degrees Celsius: -50 to 50.
    pub air_temperature_c: f64,
    /// Mean radiant temperature, degrees Celsius: from 30 K below to 70 K above the air
    /// temperature.
    pub mean_radiant_temperature_c: f64,
    /// Wind at 10 m above the ground, m/s: 0.5 to 17.
    pub wind_10m_m_s: f64,
    /// Relative humidity, percent: 0 to 100, with at most 50 hPa of vapour.
    pub relative_humidity_percent: f64,
}

impl UtciInput {
    /// Returns this climate with at least 0.5 m/s of wind.
    ///
    /// The UTCI is not defined below 0.5 m/s. Outdoor studies count calm air as 0.5 m/s, the wind
    /// of the reference climate (as does ladybug-comfort), because a walking person makes more wind
    /// than that. Winds above 17 m/s, below 0 and NaN stay unchanged.
    pub fn with_calm_raised(self) -> Self {
        let is_calm = (0.0..CALM_M_S).contains(&self.wind_10m_m_s);
        UtciInput { wind_10m_m_s: if is_calm { CALM_M_S } else { self.wind_10m_m_s }, ..self }
    }
}

/// Returns the UTCI, degrees Celsius, or `None` if an input is outside its range or NaN.
///
/// Wind below 0.5 m/s gives `None`: [`UtciInput::with_calm_raised`] is for users who count it as
/// 0.5 m/s.
pub fn utci_c(input: &UtciInput) -> Option<f64> {
    let air_temperature_c = Some(input.air_temperature_c).filter(|value| AIR_RANGE_C.contains(value))?;
    let wind_10m_m_s = Some(input.wind_10m_m_s).filter(|value| WIND_RANGE_M_S.contains(value))?;
    let radiant_excess_k = Some(input.mean_radiant_temperature_c - air_temperature_c)
        .filter(|value| RADIANT_EXCESS_RANGE_K.contains(value))?;
    let vapour_hpa = vapour_pressure_hpa(air_temperature_c, input.relative_humidity_percent)
        .filter(|value| *value <= MAX_VAPOUR_HPA)?;
    let vapour_pressure_kpa = vapour_hpa / 10.0;
    let input = PolynomialInput { air_temperature_c, wind_10m_m_s, radiant_excess_k, vapour_pressure_kpa };
    Some(air_temperature_c + utci_excess_k(&input))
}

/// Category of thermal stress of a UTCI (Bröde and others, 2012).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StressCategory {
    /// Name in the literature.
    pub name: &'static str,
    /// Highest UTCI of the category, degrees Celsius; infinity for the hottest one. A UTCI on a
    /// limit belongs to the colder category, as in pythermalcomfort.
    pub upper_limit_c: f64,
}

impl StressCategory {
    /// All categories from cold to hot.
    pub const ALL: [StressCategory; 10] = [
        StressCategory { name: "extreme cold stress", upper_limit_c: -40.0 },
        StressCategory { name: "very strong cold stress", upper_limit_c: -27.0 },
        StressCategory { name: "strong cold stress", upper_limit_c: -13.0 },
        StressCategory { name: "moderate cold stress", upper_limit_c: 0.0 },
        StressCategory { name: "slight cold stress", upper_limit_c: 9.0 },
        StressCategory { name: "no thermal stress", upper_limit_c: 26.0 },
        StressCategory { name: "moderate heat stress", upper_limit_c: 32.0 },
        StressCategory { name: "strong heat stress", upper_limit_c: 38.0 },
        StressCategory { name: "very strong heat stress", upper_limit_c: 46.0 },
        StressCategory { name: "extreme heat stress", upper_limit_c: f64::INFINITY },
    ];
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(values: [f64; 4]) -> UtciInput {
        let [air_temperature_c, mean_radiant_temperature_c, wind_10m_m_s, relative_humidity_percent] = values;
        UtciInput { air_temperature_c, mean_radiant_temperature_c, wind_10m_m_s, relative_humidity_percent }
    }

    /// At 18 climates over the whole range the UTCI is that of pythermalcomfort 4.8.1 within 1e-6
    /// K.
    #[test]
    fn utci_agrees_with_pythermalcomfort() {
        for (values, expected) in [
            ([-50.0, -80.0, 0.5, 0.0], -52.790298),
            ([-50.0, 20.0, 17.0, 100.0], -88.957932),
            ([-40.0, -40.0, 5.0, 80.0], -55.829060),
            ([-25.0, 10.0, 12.0, 60.0], -52.939985),
            ([-10.0, -20.0, 8.0, 90.0], -37.744324),
            ([0.0, 0.0, 0.5, 50.0], 0.685702),
            ([0.0, 60.0, 3.0, 100.0], 15.301178),
            ([5.0, 5.0, 17.0, 30.0], -30.831972),
            ([10.0, 70.0, 1.0, 70.0], 30.023501),
            ([15.0, 15.0, 6.0, 50.0], 4.565696),
            ([20.0, 90.0, 2.0, 40.0], 37.233311),
            ([25.0, 25.0, 1.0, 50.0], 24.612126),
            ([30.0, 95.0, 0.7, 60.0], 47.515920),
            ([35.0, 35.0, 10.0, 80.0], 41.058740),
            ([40.0, 10.0, 4.0, 20.0], 34.056243),
            ([45.0, 80.0, 15.0, 10.0], 55.105430),
            ([50.0, 120.0, 0.5, 40.0], 69.806428),
            ([50.0, 20.0, 17.0, 5.0], 52.937459),
        ] {
            let got = utci_c(&input(values)).expect("within the range");
            assert!((got - expected).abs() < 1e-6, "{values:?}: {got}");
        }
    }

    /// NaN in any input, and each input just outside its range, give `None`: 15 of 15. On the
    /// limits there is a value.
    #[test]
    fn inputs_outside_the_ranges_have_no_utci() {
        let inside = [25.0, 30.0, 2.0, 50.0];
        assert!(utci_c(&input(inside)).is_some());
        for (place, values) in [
            (0, vec![f64::NAN, -50.1, 50.1, f64::INFINITY]),
            (1, vec![f64::NAN, -5.1, 95.1]),
            (2, vec![f64::NAN, 0.49, 17.1, -1.0]),
            (3, vec![f64::NAN, -0.1, 100.1, f64::NEG_INFINITY]),
        ] {
            for value in values {
                let mut outside = inside;
                *outside.get_mut(place).expect("four inputs") = value;
                assert_eq!(utci_c(&input(outside)), None, "{outside:?}");
            }
        }
        for limits in
            [[-50.0, -80.0, 0.5, 0.0], [-50.0, 20.0, 17.0, 100.0], [50.0, 20.0, 0.5, 0.0], [50.0, 120.0, 17.0, 40.0]]
        {
            assert!(utci_c(&input(limits)).is_some_and(f64::is_finite), "{limits:?}");
        }
        assert_eq!(utci_c(&input([50.0, 50.0, 1.0, 41.0])), None, "50.6 hPa of vapour");
    }

    /// Calm air that is raised counts as 0.5 m/s. Other winds, 17.5, -1 and NaN m/s among them,
    /// stay.
    #[test]
    fn calm_air_counts_as_half_a_metre_per_second() {
        let of = |wind| input([25.0, 40.0, wind, 50.0]).with_calm_raised();
        assert_eq!(utci_c(&of(0.0)), utci_c(&input([25.0, 40.0, 0.5, 50.0])));
        assert_eq!((of(0.3).wind_10m_m_s, of(3.0).wind_10m_m_s), (0.5, 3.0));
        for wind in [17.5, -1.0, f64::NAN] {
            assert_eq!(utci_c(&of(wind)), None);
        }
    }

    /// Limits rise from category to category, and neighbours have names of their own.
    #[test]
    fn categories_go_from_cold_to_hot() {
        for (colder, hotter) in StressCategory::ALL.into_iter().zip(StressCategory::ALL.into_iter().skip(1)) {
            assert!(colder.upper_limit_c < hotter.upper_limit_c, "{colder:?}");
            assert_ne!(colder.name, hotter.name);
        }
    }
}
