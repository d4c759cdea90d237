//! SolarCal: increase of the mean radiant temperature by the sun. In: sun, sky, shading, posture.
//! Out: effective radiant field and increase of the mean radiant temperature.
//!
//! ANSI/ASHRAE Standard 55, appendix C (2017 to 2023), after Arens, Hoyt, Zhou, Huang, Zhang and
//! Schiavon, "Modeling the comfort effects of short-wave solar radiation indoors", Building and
//! Environment 88, 2015. Outdoors the transmittance of glass is 1.

use std::ops::RangeInclusive;

/// Posture of a person in the sun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SunPosture {
    /// Sitting upright.
    Sitting,
    /// Standing upright.
    Standing,
    /// Lying on the back: the factors of a standing person, turned.
    Supine,
}

impl SunPosture {
    /// Returns the share of the body's surface that exchanges radiation with the surroundings
    /// (appendix C, f_eff).
    const fn radiant_share(self) -> f64 {
        match self {
            SunPosture::Sitting => 0.696,
            SunPosture::Standing | SunPosture::Supine => 0.725,
        }
    }
}

/// Position of the sun relative to a person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunAngles {
    /// Altitude of the sun above the horizon, degrees: 0 to 90.
    pub altitude_deg: f64,
    /// Horizontal angle between the sun and the direction that the person faces, degrees: 0 to 180.
    /// The standard calls it SHARP.
    pub from_front_deg: f64,
}

/// A person in the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolarGainInput {
    /// Position of the sun.
    pub sun: SunAngles,
    /// Direct normal irradiance, W/m2; 0 or more. The standard states a range of 200 to 1000.
    pub beam_normal_w_m2: f64,
    /// Diffuse horizontal irradiance, W/m2; `None` for the standard's assumption of 0.2 of the
    /// direct normal irradiance.
    pub diffuse_horizontal_w_m2: Option<f64>,
    /// Total solar transmittance of glass and shades: 0 to 1, 1 outdoors.
    pub transmittance: f64,
    /// Share of the sky vault that the body sees (f_svv): 0 to 1.
    pub sky_view_fraction: f64,
    /// Share of the body that the sun falls on (f_bes): 0 to 1, 1 without shade.
    pub exposed_fraction: f64,
    /// Share of shortwave irradiance that skin and clothing absorb: 0 to 1, usually 0.7.
    pub shortwave_absorptivity: f64,
    /// Reflectance of the floor or ground: 0 to 1, in the standard 0.6.
    pub floor_reflectance: f64,
    /// Posture of the person.
    pub posture: SunPosture,
}

/// Effect of the sun on a person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolarGain {
    /// Effective radiant field: net gain over the body's surface as longwave irradiance, W/m2.
    pub effective_radiant_field_w_m2: f64,
    /// Increase of the mean radiant temperature, K.
    pub mean_radiant_increase_k: f64,
}

/// Longwave emissivity of the body (appendix C).
const LONGWAVE_EMISSIVITY: f64 = 0.95;
/// Radiation heat transfer coefficient, W/m2 K (appendix C, h_r).
const RADIATION_COEFFICIENT_W_M2_K: f64 = 6.0;
/// Diffuse horizontal irradiance over direct normal irradiance (appendix C).
const STANDARD_DIFFUSE_SHARE: f64 = 0.2;

/// Returns the solar gain of a person by appendix C, or `None` if an input is NaN or outside its
/// range.
pub fn solar_gain(input: &SolarGainInput) -> Option<SolarGain> {
    let shares = [
        input.transmittance,
        input.sky_view_fraction,
        input.exposed_fraction,
        input.shortwave_absorptivity,
        input.floor_reflectance,
    ];
    let beam_w_m2 = input.beam_normal_w_m2;
    let diffuse_w_m2 = input.diffuse_horizontal_w_m2.unwrap_or(STANDARD_DIFFUSE_SHARE * beam_w_m2);
    let are_irradiances = [beam_w_m2, diffuse_w_m2].iter().all(|value| (0.0..f64::INFINITY).contains(value));
    if !are_irradiances || !shares.iter().all(|share| (0.0..=1.0).contains(share)) {
        return None;
    }
    let projected = projected_area_factor(&input.sun, input.posture)?;
    let horizontal_w_m2 = beam_w_m2 * input.sun.altitude_deg.to_radians().sin() + diffuse_w_m2;
    let direct = projected * input.exposed_fraction * beam_w_m2;
    let of_sky = 0.5 * input.sky_view_fraction * diffuse_w_m2;
    let of_floor = 0.5 * input.sky_view_fraction * horizontal_w_m2 * input.floor_reflectance;
    let radiant_share = input.posture.radiant_share();
    let solar_w_m2 = radiant_share * input.transmittance * (direct + of_sky + of_floor);
    let effective_radiant_field_w_m2 = solar_w_m2 * input.shortwave_absorptivity / LONGWAVE_EMISSIVITY;
    let mean_radiant_increase_k = effective_radiant_field_w_m2 / (RADIATION_COEFFICIENT_W_M2_K * radiant_share);
    Some(SolarGain { effective_radiant_field_w_m2, mean_radiant_increase_k })
}

/// Returns the projected area of a person towards the sun over the body's radiant surface (f_p),
/// bilinear in the standard's table; `None` for NaN and angles outside 0..=90 and 0..=180 degrees.
pub fn projected_area_factor(sun: &SunAngles, posture: SunPosture) -> Option<f64> {
    const ALTITUDES_DEG: RangeInclusive<f64> = 0.0..=90.0;
    const FROM_FRONT_DEG: RangeInclusive<f64> = 0.0..=180.0;
    if !ALTITUDES_DEG.contains(&sun.altitude_deg) || !FROM_FRONT_DEG.contains(&sun.from_front_deg) {
        return None;
    }
    match posture {
        SunPosture::Sitting => in_table(&SITTING_FACTORS, sun),
        SunPosture::Standing => in_table(&STANDING_FACTORS, sun),
        SunPosture::Supine => in_table(&STANDING_FACTORS, &as_seen_by_supine(sun)),
    }
}

/// Returns the sun in the frame of a supine person: the feet point to where the person would face
/// if sitting up, and the face looks up (appendix C).
fn as_seen_by_supine(sun: &SunAngles) -> SunAngles {
    let (sin_altitude, cos_altitude) = sun.altitude_deg.to_radians().sin_cos();
    let (sin_front, cos_front) = sun.from_front_deg.to_radians().sin_cos();
    SunAngles {
        altitude_deg: (cos_front.abs() * cos_altitude).clamp(0.0, 1.0).asin().to_degrees(),
        from_front_deg: (sin_front * cos_altitude).atan2(sin_altitude).to_degrees(),
    }
}

/// Degrees between two rows and two columns of the tables.
const STEP_DEG: f64 = 15.0;
/// Rows of the tables: angles from the front.
const ROWS: usize = 13;
/// Columns of the tables: altitudes.
const COLUMNS: usize = 7;

/// Two neighbouring entries of a table around an angle, and the angle's distance from the first
/// one: 0 to 1.
struct Between {
    first: usize,
    share: f64,
}

impl Between {
    fn of(angle_deg: f64, entries: usize) -> Self {
        let steps = angle_deg / STEP_DEG;
        // `as` saturates: a tiny negative angle of rounding is 0.
        let first = (steps as usize).min(entries - 2);
        Between { first, share: steps - first as f64 }
    }

    fn mix(&self, values: impl Iterator<Item = f64>) -> Option<f64> {
        let mut values = values.skip(self.first);
        Some((1.0 - self.share) * values.next()? + self.share * values.next()?)
    }
}

/// Interpolates bilinearly in a table.
fn in_table(table: &[[f64; COLUMNS]; ROWS], sun: &SunAngles) -> Option<f64> {
    let (row, column) = (Between::of(sun.from_front_deg, ROWS), Between::of(sun.altitude_deg, COLUMNS));
    let [first, second, ..] = table.get(row.first..)? else { return None };
    let of_row = |values: &[f64; COLUMNS]| column.mix(values.iter().copied());
    Some((1.0 - row.share) * of_row(first)? + row.share * of_row(second)?)
}

/// `[angle from the front, 0 to 180 by 15 degrees][altitude, 0 to 90 by 15 degrees]`: projected
/// area factors of a standing person by appendix C (after Fanger, Thermal comfort, 1970), as in
/// pythermalcomfort 4.8.1.
const STANDING_FACTORS: [[f64; COLUMNS]; ROWS] = [
    [0.350, 0.350, 0.314, 0.258, 0.206, 0.144, 0.082],
    [0.342, 0.342, 0.310, 0.252, 0.200, 0.140, 0.082],
    [0.330, 0.330, 0.300, 0.244, 0.190, 0.132, 0.082],
    [0.310, 0.310, 0.275, 0.228, 0.175, 0.124, 0.082],
    [0.283, 0.283, 0.251, 0.208, 0.160, 0.114, 0.082],
    [0.252, 0.252, 0.228, 0.188, 0.150, 0.108, 0.082],
    [0.230, 0.230, 0.214, 0.180, 0.148, 0.108, 0.082],
    [0.242, 0.242, 0.222, 0.180, 0.153, 0.112, 0.082],
    [0.274, 0.274, 0.245, 0.203, 0.165, 0.116, 0.082],
    [0.304, 0.304, 0.270, 0.220, 0.174, 0.121, 0.082],
    [0.328, 0.328, 0.290, 0.234, 0.183, 0.125, 0.082],
    [0.344, 0.344, 0.304, 0.244, 0.190, 0.128, 0.082],
    [0.347, 0.347, 0.308, 0.246, 0.191, 0.128, 0.082],
];

/// Projected area factors of a sitting person, indexed as [`STANDING_FACTORS`], from the same
/// source.
const SITTING_FACTORS: [[f64; COLUMNS]; ROWS] = [
    [0.290, 0.324, 0.305, 0.303, 0.262, 0.224, 0.177],
    [0.292, 0.328, 0.294, 0.288, 0.268, 0.227, 0.177],
    [0.288, 0.332, 0.298, 0.290, 0.264, 0.222, 0.177],
    [0.274, 0.326, 0.294, 0.289, 0.252, 0.214, 0.177],
    [0.254, 0.308, 0.280, 0.276, 0.241, 0.202, 0.177],
    [0.230, 0.282, 0.262, 0.260, 0.233, 0.193, 0.177],
    [0.216, 0.260, 0.248, 0.244, 0.220, 0.186, 0.177],
    [0.234, 0.258, 0.236, 0.227, 0.208, 0.180, 0.177],
    [0.262, 0.260, 0.224, 0.208, 0.196, 0.176, 0.177],
    [0.280, 0.260, 0.210, 0.192, 0.184, 0.170, 0.177],
    [0.298, 0.256, 0.194, 0.174, 0.168, 0.168, 0.177],
    [0.306, 0.250, 0.180, 0.156, 0.156, 0.166, 0.177],
    [0.300, 0.240, 0.168, 0.152, 0.152, 0.164, 0.177],
];

#[cfg(test)]
mod tests {
    use super::*;

    fn factor(altitude_deg: f64, from_front_deg: f64, posture: SunPosture) -> Option<f64> {
        projected_area_factor(&SunAngles { altitude_deg, from_front_deg }, posture)
    }

    const OUTDOORS: SolarGainInput = SolarGainInput {
        sun: SunAngles { altitude_deg: 30.0, from_front_deg: 90.0 },
        beam_normal_w_m2: 800.0,
        diffuse_horizontal_w_m2: Some(100.0),
        transmittance: 1.0,
        sky_view_fraction: 1.0,
        exposed_fraction: 1.0,
        shortwave_absorptivity: 0.7,
        floor_reflectance: 0.2,
        posture: SunPosture::Standing,
    };

    /// At the entries of the tables the factors are the entries, 182 of 182, and half way between
    /// four entries their mean, to 1e-12.
    #[test]
    fn factors_equal_the_tables_and_means_between() {
        for (table, posture) in [(&STANDING_FACTORS, SunPosture::Standing), (&SITTING_FACTORS, SunPosture::Sitting)] {
            for (row, values) in table.iter().enumerate() {
                for (column, value) in values.iter().enumerate() {
                    let got = factor(STEP_DEG * column as f64, STEP_DEG * row as f64, posture).expect("in the table");
                    assert!((got - value).abs() < 1e-12, "{row} {column}: {got}");
                }
            }
        }
        let mean = (0.258 + 0.206 + 0.252 + 0.200) / 4.0;
        assert!((factor(52.5, 7.5, SunPosture::Standing).expect("in the table") - mean).abs() < 1e-12);
    }

    /// A sun at the zenith meets a supine person as a horizontal sun in front meets a standing one,
    /// 0.35. A sun at the feet or the head does as the zenith, 0.082, and one at the side as a
    /// horizontal sun at the side, 0.230.
    #[test]
    fn a_supine_person_is_a_standing_one_turned() {
        for (altitude, front, expected) in
            [(90.0, 40.0, 0.350), (0.0, 0.0, 0.082), (0.0, 180.0, 0.082), (0.0, 90.0, 0.230)]
        {
            let got = factor(altitude, front, SunPosture::Supine).expect("in the table");
            assert!((got - expected).abs() < 1e-9, "{altitude} {front}: {got}");
        }
    }

    /// By hand, outdoors: 0.725 (0.214 800 + 0.5 100 + 0.5 (800 sin 30 + 100) 0.2) 0.7 / 0.95 is
    /// 144.878 W/m2 and 33.305 K, within 1e-3.
    #[test]
    fn the_outdoor_gain_agrees_with_hand_computation() {
        let got = solar_gain(&OUTDOORS).expect("within the ranges");
        assert!((got.effective_radiant_field_w_m2 - 144.877_9).abs() < 1e-3, "{got:?}");
        assert!((got.mean_radiant_increase_k - 33.305_3).abs() < 1e-3, "{got:?}");
    }

    /// Without a measured value diffuse irradiance is 0.2 of the beam.
    #[test]
    fn unmeasured_diffuse_is_a_fifth_of_the_beam() {
        let of = |diffuse_horizontal_w_m2| solar_gain(&SolarGainInput { diffuse_horizontal_w_m2, ..OUTDOORS });
        assert_eq!(of(None), of(Some(160.0)));
        assert_ne!(of(None), of(Some(100.0)));
    }

    /// NaN and values outside the ranges give `None`: 8 of 8.
    #[test]
    fn values_outside_the_ranges_have_no_gain() {
        let at = |altitude_deg, from_front_deg| SunAngles { altitude_deg, from_front_deg };
        for input in [
            SolarGainInput { sun: at(-0.1, 0.0), ..OUTDOORS },
            SolarGainInput { sun: at(90.1, 0.0), ..OUTDOORS },
            SolarGainInput { sun: at(10.0, 180.1), ..OUTDOORS },
            SolarGainInput { sun: at(10.0, f64::NAN), ..OUTDOORS },
            SolarGainInput { beam_normal_w_m2: -1.0, ..OUTDOORS },
            SolarGainInput { diffuse_horizontal_w_m2: Some(f64::NAN), ..OUTDOORS },
            SolarGainInput { floor_reflectance: 1.1, ..OUTDOORS },
            SolarGainInput { exposed_fraction: f64::NAN, ..OUTDOORS },
        ] {
            assert_eq!(solar_gain(&input), None, "{input:?}");
        }
    }
}
