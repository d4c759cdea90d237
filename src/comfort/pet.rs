//! Physiological Equivalent Temperature. In: climate at a body, a person. Out: the PET in degrees
//! Celsius.
//!
//! The PET is the air temperature of a room without sun and draught in which the body's heat
//! balance is the same, with core and skin as warm as in the real climate. The room has a mean
//! radiant temperature equal to that of the air, 0.1 m/s of wind and 12 hPa of vapour. The person
//! wears 0.9 clo and works at 80 W there. Sources: Höppe, 1999; Walther and Goestchel, 2018; titles
//! in `pet_body`. The results are those of `pet_steady` in pythermalcomfort 4.8.1 (MIT licence).

use crate::bracketed_root::{Bracket, bracketed_root};
use crate::humidity::ashrae_saturation_pressure_hpa;
use crate::pet_balance::{BodyClimate, HeatBalance};
use crate::pet_body::{Body, Clothing, MET_W, ROOM_ACTIVITY_W, ROOM_CLOTHING_CLO};
use std::ops::RangeInclusive;

pub use crate::pet_body::{PetPerson, PetPosture, Sex};

/// Air pressure at sea level, hPa.
pub const SEA_LEVEL_HPA: f64 = 1013.25;

/// Climate at a person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PetClimate {
    /// Air temperature, degrees Celsius: -50 to 50.
    pub air_temperature_c: f64,
    /// Mean radiant temperature, degrees Celsius: -60 to 120.
    pub mean_radiant_temperature_c: f64,
    /// Wind at the body, 1.1 m above the ground, m/s: 0 to 30.
    pub wind_m_s: f64,
    /// Relative humidity, percent: 0 to 100.
    pub relative_humidity_percent: f64,
    /// Air pressure, hPa: 500 to 1100; [`SEA_LEVEL_HPA`] where it is not known.
    pub pressure_hpa: f64,
}

/// Wind of the reference room, m/s.
const ROOM_WIND_M_S: f64 = 0.1;
/// Vapour pressure of the reference room, hPa.
const ROOM_VAPOUR_HPA: f64 = 12.0;
/// Range of room temperatures in which the PET is looked for, degrees Celsius.
const ROOM_BRACKET: Bracket = Bracket { low: -150.0, high: 180.0, tolerance: 1e-8 };

/// Returns the PET, degrees Celsius, or `None` if an input is outside its range or NaN.
///
/// In air of more than 50 hPa of vapour, a dew point of 33 degrees Celsius, the model's sweating
/// may jump at the balance (see `pet_balance`). The value is then that of the jump. The solver of
/// pythermalcomfort mostly does not converge there: results differ by up to 2.3 K. Elsewhere they
/// are equal within 1e-6 K.
pub fn pet_c(climate: &PetClimate, person: &PetPerson) -> Option<f64> {
    if !(is_climate(climate) && is_person(person)) {
        return None;
    }
    let body = Body::new(person);
    let relative_pressure = climate.pressure_hpa / SEA_LEVEL_HPA;
    let saturation_hpa = ashrae_saturation_pressure_hpa(climate.air_temperature_c);
    let outdoors = BodyClimate {
        air_c: climate.air_temperature_c,
        radiant_c: climate.mean_radiant_temperature_c,
        vapour_hpa: climate.relative_humidity_percent / 100.0 * saturation_hpa,
        pressure_hpa: climate.pressure_hpa,
        convection_w_m2_k: body.convection_w_m2_k(climate.wind_m_s, relative_pressure),
    };
    let clothing = Clothing::new(person.clothing_clo, &body);
    let nodes = HeatBalance::new(&body, &clothing, &outdoors, MET_W * person.activity_met).nodes()?;
    // The room keeps the temperatures of core, skin and clothing of the real climate.
    let room_clothing = Clothing::new(ROOM_CLOTHING_CLO, &body);
    let convection_w_m2_k = body.convection_w_m2_k(ROOM_WIND_M_S, relative_pressure);
    let sum_in_room_w_m2 = |room_c| {
        let vapour_hpa = ROOM_VAPOUR_HPA;
        let room = BodyClimate { air_c: room_c, radiant_c: room_c, vapour_hpa, convection_w_m2_k, ..outdoors };
        HeatBalance::new(&body, &room_clothing, &room, ROOM_ACTIVITY_W).sum_w_m2(&nodes)
    };
    bracketed_root(sum_in_room_w_m2, &ROOM_BRACKET)
}

fn is_climate(climate: &PetClimate) -> bool {
    const RANGES: [RangeInclusive<f64>; 5] = [-50.0..=50.0, -60.0..=120.0, 0.0..=30.0, 0.0..=100.0, 500.0..=1100.0];
    let PetClimate { air_temperature_c, mean_radiant_temperature_c, wind_m_s, relative_humidity_percent, pressure_hpa } =
        climate;
    let values = [air_temperature_c, mean_radiant_temperature_c, wind_m_s, relative_humidity_percent, pressure_hpa];
    RANGES.iter().zip(values).all(|(range, value)| range.contains(value))
}

fn is_person(person: &PetPerson) -> bool {
    const RANGES: [RangeInclusive<f64>; 5] = [0.5..=4.0, 0.05..=2.5, 15.0..=110.0, 35.0..=200.0, 1.3..=2.3];
    let PetPerson { activity_met, clothing_clo, age_years, weight_kg, height_m, .. } = person;
    let values = [activity_met, clothing_clo, age_years, weight_kg, height_m];
    RANGES.iter().zip(values).all(|(range, value)| range.contains(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn climate(values: [f64; 4]) -> PetClimate {
        let [air_temperature_c, mean_radiant_temperature_c, wind_m_s, relative_humidity_percent] = values;
        PetClimate {
            air_temperature_c,
            mean_radiant_temperature_c,
            wind_m_s,
            relative_humidity_percent,
            pressure_hpa: SEA_LEVEL_HPA,
        }
    }

    /// In the reference room the PET is the air temperature within 1e-6 K, for the two postures.
    #[test]
    fn the_reference_room_has_its_air_temperature() {
        for room_c in [12.0, 18.0, 21.0, 25.0, 35.0, 45.0] {
            let humidity = 100.0 * ROOM_VAPOUR_HPA / ashrae_saturation_pressure_hpa(room_c);
            for posture in [PetPosture::Sitting, PetPosture::Standing] {
                let person = PetPerson { posture, ..PetPerson::VDI_3787 };
                let got = pet_c(&climate([room_c, room_c, ROOM_WIND_M_S, humidity]), &person).expect("a PET");
                assert!((got - room_c).abs() < 1e-6, "{room_c}: {got}");
            }
        }
    }

    /// On a grid of 9 air temperatures, 25 mean radiant temperatures, 8 winds and 6 humidities (-30
    /// to 50 and -30 to 90 degrees, 0.05 to 15 m/s, 5 to 100 %) each of the 10800 cases has a PET,
    /// and each PET rises with the mean radiant temperature.
    #[test]
    fn pet_converges_and_rises_with_radiation() {
        let mut cases = 0;
        for air_c in (-30..=50).step_by(10).map(f64::from) {
            for wind_m_s in [0.05, 0.1, 0.3, 1.0, 2.0, 4.0, 8.0, 15.0] {
                for humidity in [5.0, 20.0, 40.0, 60.0, 80.0, 100.0] {
                    let mut former = f64::NEG_INFINITY;
                    for radiant_c in (-30..=90).step_by(5).map(f64::from) {
                        let values = [air_c, radiant_c, wind_m_s, humidity];
                        let pet = pet_c(&climate(values), &PetPerson::default()).expect("a PET");
                        assert!(pet.is_finite() && pet > former, "{values:?}: {pet} after {former}");
                        former = pet;
                        cases += 1;
                    }
                }
            }
        }
        assert_eq!(cases, 10_800);
    }

    /// For 10 climates and persons the PET is that of pythermalcomfort 4.8.1, without its rounding,
    /// within 1e-4 K.
    #[test]
    fn pet_agrees_with_pythermalcomfort() {
        let default = PetPerson::default();
        for (values, pressure_hpa, person, expected) in [
            ([-30.0, -30.0, 15.00, 50.0], 1013.25, default, -41.8570),
            (
                [-20.0, 30.0, 1.00, 80.0],
                900.00,
                PetPerson {
                    activity_met: 2.00,
                    clothing_clo: 1.50,
                    posture: PetPosture::Standing,
                    sex: Sex::Female,
                    age_years: 60.0,
                    weight_kg: 60.0,
                    height_m: 1.60,
                },
                -9.6242,
            ),
            ([0.0, 0.0, 0.05, 100.0], 1013.25, PetPerson { sex: Sex::Female, ..default }, -0.6945),
            (
                [10.0, 60.0, 3.00, 30.0],
                1013.25,
                PetPerson {
                    activity_met: 1.00,
                    clothing_clo: 0.50,
                    posture: PetPosture::Standing,
                    age_years: 35.0,
                    height_m: 1.75,
                    ..default
                },
                13.2618,
            ),
            ([20.0, 20.0, 0.10, 50.0], 1013.25, default, 19.9239),
            (
                [25.0, 70.0, 1.00, 40.0],
                700.00,
                PetPerson {
                    activity_met: 3.00,
                    clothing_clo: 0.30,
                    age_years: 80.0,
                    weight_kg: 90.0,
                    height_m: 1.90,
                    ..default
                },
                43.8361,
            ),
            (
                [35.0, 75.0, 2.00, 30.0],
                1013.25,
                PetPerson {
                    clothing_clo: 2.20,
                    posture: PetPosture::Standing,
                    sex: Sex::Female,
                    age_years: 20.0,
                    weight_kg: 55.0,
                    height_m: 1.70,
                    ..default
                },
                48.8054,
            ),
            ([40.0, 40.0, 8.00, 20.0], 1013.25, PetPerson { clothing_clo: 0.10, ..default }, 30.1497),
            ([50.0, 90.0, 0.50, 10.0], 1013.25, PetPerson { posture: PetPosture::Standing, ..default }, 72.4736),
            ([30.0, 60.0, 1.00, 80.0], 1013.25, default, 44.6253),
        ] {
            let got = pet_c(&PetClimate { pressure_hpa, ..climate(values) }, &person).expect("a PET");
            assert!((got - expected).abs() < 1e-4, "{values:?} {person:?}: {got}");
        }
    }

    /// NaN, infinity and -1000 in any input give `None`: 30 of 30.
    #[test]
    fn impossible_inputs_have_no_pet() {
        let inside = climate([20.0, 30.0, 1.0, 50.0]);
        let person = PetPerson::default();
        assert!(pet_c(&inside, &person).is_some());
        for value in [f64::NAN, f64::INFINITY, -1000.0] {
            for outside in [
                PetClimate { air_temperature_c: value, ..inside },
                PetClimate { mean_radiant_temperature_c: value, ..inside },
                PetClimate { wind_m_s: value, ..inside },
                PetClimate { relative_humidity_percent: value, ..inside },
                PetClimate { pressure_hpa: value, ..inside },
            ] {
                assert_eq!(pet_c(&outside, &person), None, "{outside:?}");
            }
            for outside in [
                PetPerson { activity_met: value, ..person },
                PetPerson { clothing_clo: value, ..person },
                PetPerson { age_years: value, ..person },
                PetPerson { weight_kg: value, ..person },
                PetPerson { height_m: value, ..person },
            ] {
                assert_eq!(pet_c(&inside, &outside), None, "{outside:?}");
            }
        }
    }

    /// There is a finite PET at the corners of the ranges, 2048 climates and persons.
    #[test]
    fn corners_of_the_ranges_have_a_finite_pet() {
        let corner = |bits: u32, place: u32, low: f64, high: f64| if bits >> place & 1 == 0 { low } else { high };
        for bits in 0..2048 {
            let at = |place, low, high| corner(bits, place, low, high);
            let mut outdoors = climate([at(0, -50.0, 50.0), at(1, -60.0, 120.0), at(2, 0.0, 30.0), at(3, 0.0, 100.0)]);
            outdoors.pressure_hpa = at(4, 500.0, 1100.0);
            let person = PetPerson {
                activity_met: at(5, 0.5, 4.0),
                clothing_clo: at(6, 0.05, 2.5),
                posture: if bits >> 10 & 1 == 0 { PetPosture::Sitting } else { PetPosture::Standing },
                sex: Sex::Female,
                age_years: at(7, 15.0, 110.0),
                weight_kg: at(8, 35.0, 200.0),
                height_m: at(9, 1.3, 2.3),
            };
            assert!(pet_c(&outdoors, &person).is_some_and(f64::is_finite), "{outdoors:?} {person:?}");
        }
    }
}
