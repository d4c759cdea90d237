//! An index of an hour as a function of the mean radiant temperature. In: the index as a function.
//! Out: its values between nodes of 1 K.
//!
//! Air, wind and humidity of an hour are equal at all places. An index takes microseconds, so it is
//! computed at some nodes an hour and not at each place.

/// Distance of nodes, K. With linear interpolation the UTCI and the PET are off by at most 0.01 K
/// (a test).
const STEP_K: f64 = 1.0;

/// Distance from the air temperature down to the first node, K.
const BELOW_K: f64 = 35.0;
/// Distance from the air temperature up to the last node, K.
const ABOVE_K: f64 = 90.0;

/// Values of an index in one hour, by mean radiant temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct IndexCurve {
    first_c: f64,
    /// `[node]`: the index, or NaN where it has no value.
    values: Vec<f32>,
}

impl IndexCurve {
    /// Returns the curve of an hour with air of `air_c` degrees Celsius. `index` gives a value for
    /// a mean radiant temperature, or `None`.
    pub fn new(air_c: f64, index: impl Fn(f64) -> Option<f64>) -> Self {
        let first_c = air_c - BELOW_K;
        let count = ((BELOW_K + ABOVE_K) / STEP_K) as usize;
        let node = |i: usize| index(first_c + STEP_K * i as f64).map_or(f32::NAN, |value| value as f32);
        IndexCurve { first_c, values: (0..=count).map(node).collect() }
    }

    /// Returns the index at a mean radiant temperature, degrees Celsius, or `None` where it has no
    /// value.
    pub fn at(&self, mean_radiant_c: f64) -> Option<f64> {
        let place = (mean_radiant_c - self.first_c) / STEP_K;
        if place.is_nan() || place < 0.0 {
            return None;
        }
        let before = place.floor();
        let share = place - before;
        let low = f64::from(*self.values.get(before as usize)?);
        let value = match self.values.get(before as usize + 1) {
            Some(high) if share > 0.0 => low + share * (f64::from(*high) - low),
            _ if share > 0.0 => return None,
            _ => low,
        };
        value.is_finite().then_some(value)
    }

    /// Returns the index at the highest mean radiant temperature at which it has a value, if this
    /// one is hotter: a lower bound, because both indices rise with the mean radiant temperature.
    pub fn least_beyond(&self, mean_radiant_c: f64) -> Option<f64> {
        let last = self.values.iter().rposition(|value| value.is_finite())?;
        let is_beyond = mean_radiant_c > self.first_c + STEP_K * last as f64;
        self.values.get(last).filter(|_| is_beyond).map(|value| f64::from(*value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pet::{PetClimate, PetPerson, SEA_LEVEL_HPA, pet_c};
    use crate::utci::{UtciInput, utci_c};

    /// Between nodes UTCI and PET of four climates are off by less than 0.01 K. Outside of their
    /// ranges there is no value.
    #[test]
    fn curves_stay_within_a_hundredth_of_a_kelvin() {
        for (air_c, wind_m_s, humidity) in [(-12.0, 6.0, 80.0), (5.0, 0.5, 95.0), (22.0, 2.0, 50.0), (36.0, 1.0, 30.0)]
        {
            let utci = |radiant_c: f64| {
                utci_c(&UtciInput {
                    air_temperature_c: air_c,
                    mean_radiant_temperature_c: radiant_c,
                    wind_10m_m_s: wind_m_s,
                    relative_humidity_percent: humidity,
                })
            };
            let pet = |radiant_c: f64| {
                let climate = PetClimate {
                    air_temperature_c: air_c,
                    mean_radiant_temperature_c: radiant_c,
                    wind_m_s,
                    relative_humidity_percent: humidity,
                    pressure_hpa: SEA_LEVEL_HPA,
                };
                pet_c(&climate, &PetPerson::VDI_3787)
            };
            let (of_utci, of_pet) = (IndexCurve::new(air_c, utci), IndexCurve::new(air_c, pet));
            for i in 0..600 {
                let radiant_c = air_c - 25.0 + 0.137 * f64::from(i);
                if let (Some(found), Some(expected)) = (of_utci.at(radiant_c), utci(radiant_c)) {
                    assert!((found - expected).abs() < 0.01, "{air_c} {radiant_c}: {found} {expected}");
                }
                let (found, expected) = (of_pet.at(radiant_c).expect("a PET"), pet(radiant_c).expect("a PET"));
                assert!((found - expected).abs() < 0.01, "{air_c} {radiant_c}: {found} {expected}");
            }
            assert_eq!((of_utci.at(air_c - 32.0), of_utci.at(air_c + 75.0)), (None, None));
            // Beyond 70 K above the air the UTCI at 70 K is a lower bound.
            let bound = of_utci.least_beyond(air_c + 75.0).zip(utci(air_c + 70.0));
            assert!(bound.is_some_and(|(bound, at_70)| (bound - at_70).abs() < 0.01), "{air_c}: {bound:?}");
            assert_eq!((of_utci.least_beyond(air_c + 69.5), of_utci.least_beyond(air_c - 32.0)), (None, None));
            assert!(of_pet.least_beyond(air_c + 91.0).is_some());
            assert_eq!((of_pet.at(air_c - 36.0), of_pet.at(air_c + 91.0), of_pet.at(f64::NAN)), (None, None, None));
        }
    }
}
