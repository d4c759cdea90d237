//! Luminous efficacy of sunlight. In: a condition with its dew point. Out: lumens a watt of the
//! sun's and of the sky's light.
//!
//! Perez, Ineichen, Seals, Michalsky and Stewart, "Modeling daylight availability and irradiance
//! components from direct and global irradiance", Solar Energy 44(5), 1990, equations 7 and 8 with
//! table 4; the precipitable water by equation 3. Range of the data: thirteen sites, suns above
//! some 5 degrees. The authors state an RMSE of some 3 to 8 % of the illuminance.

use crate::site::bands::SourceScale;
use crate::sky::perez::{BIN_ENDS, brightness, clearness};
use crate::weather::conditions::Condition;

/// Table 4, diffuse efficacy: a, b, c, d of each bin of clearness. Four public implementations have
/// the same numbers.
const DIFFUSE: [[f64; 4]; 8] = [
    [97.24, -0.46, 12.00, -8.91],
    [107.22, 1.15, 0.59, -3.95],
    [104.97, 2.96, -5.53, -8.77],
    [102.39, 5.59, -13.95, -13.90],
    [100.71, 5.94, -22.75, -23.74],
    [106.42, 3.83, -36.15, -28.83],
    [141.88, 1.90, -53.24, -14.03],
    [152.23, 0.35, -45.27, -7.98],
];

/// Table 4, direct efficacy: a, b, c, d of each bin of clearness.
const DIRECT: [[f64; 4]; 8] = [
    [57.20, -4.55, -2.98, 117.12],
    [98.99, -3.46, -1.21, 12.38],
    [109.83, -4.90, -1.71, -8.81],
    [110.34, -5.84, -1.99, -4.56],
    [106.36, -3.97, -1.75, -6.16],
    [107.19, -1.25, -1.51, -26.73],
    [105.75, 0.77, -1.26, -34.44],
    [101.18, 1.58, -1.10, -8.29],
];

/// Precipitable water without a known dew point, cm: as in gendaylit, that of a dew point of 11
/// degrees Celsius.
const USUAL_WATER_CM: f64 = 2.0;

/// Range of the brightness behind the fits; outside of it the logarithm would give wild values.
const BRIGHTNESSES: [f64; 2] = [0.01, 0.6];

/// Returns the precipitable water, cm, for the dew point at the ground (equation 3 of the paper,
/// after Wright, Perez and Michalsky 1989).
fn water_cm(dew_point_c: f64) -> f64 {
    (0.07 * dew_point_c - 0.075).exp()
}

/// Returns the efficacy of a condition's direct and diffuse light, lm/W: the factors from
/// irradiance to illuminance, lux.
pub fn luminous_efficacy(condition: &Condition) -> SourceScale {
    let dew_point_c = condition.air.and_then(|air| air.dew_point_c);
    let dni_w_m2 = if condition.suns.is_empty() { 0.0 } else { condition.dni_w_m2 };
    let zenith_rad = condition.sky_sun.z.clamp(0.0, 1.0).acos();
    let water_cm = dew_point_c.map_or(USUAL_WATER_CM, water_cm);
    // Without diffuse light the tiny divisor makes the sky as clear as can be.
    let epsilon = clearness(dni_w_m2, condition.dhi_w_m2.max(f64::MIN_POSITIVE), zenith_rad);
    let delta = brightness(condition.dhi_w_m2, condition.extraterrestrial_w_m2, zenith_rad);
    efficacies(epsilon, delta, zenith_rad, water_cm)
}

/// Returns the efficacy for a clearness, a brightness, the sun's zenith angle and precipitable
/// water, lm/W.
fn efficacies(epsilon: f64, delta: f64, zenith_rad: f64, water_cm: f64) -> SourceScale {
    let [darkest, brightest] = BRIGHTNESSES;
    let delta = delta.clamp(darkest, brightest);
    let bin = BIN_ENDS.partition_point(|end| *end <= epsilon);
    let of = |table: &[[f64; 4]; 8]| table.get(bin).copied().unwrap_or_default();
    let ([a, b, c, d], [e, f, g, h]) = (of(&DIFFUSE), of(&DIRECT));
    let sky = a + b * water_cm + c * zenith_rad.cos() + d * delta.ln();
    let sun = e + f * water_cm + g * (5.73 * zenith_rad - 5.0).exp() + h * delta;
    SourceScale { sun: sun.max(0.0), sky: sky.max(0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::direction_from_degrees;
    use crate::weather::air::Air;

    /// Table 4, global efficacy: a, b, c, d of each bin of clearness.
    const GLOBAL: [[f64; 4]; 8] = [
        [96.63, -0.47, 11.50, -9.16],
        [107.54, 0.79, 1.79, -1.19],
        [98.73, 0.70, 4.40, -6.95],
        [92.72, 0.56, 8.36, -8.31],
        [86.73, 0.98, 7.10, -10.94],
        [88.34, 1.39, 6.06, -7.60],
        [78.63, 1.47, 4.93, -11.37],
        [99.65, 1.86, -4.46, -3.15],
    ];

    /// By hand for epsilon 7, delta 0.1, the zenith and 2 cm of water: sky 152.23 + 0.70 - 45.27 +
    /// 18.375 = 126.035, sun 101.18 + 3.16 - 1.10 exp(-5) - 0.829 = 103.504, both to 0.001 lm/W. A
    /// dew point of 10.97 degrees Celsius is 2 cm of water to 0.001.
    #[test]
    fn efficacies_agree_with_hand_computation() {
        let found = efficacies(7.0, 0.1, 0.0, 2.0);
        assert!((found.sky - 126.035).abs() < 1e-3 && (found.sun - 103.504).abs() < 1e-3, "{found:?}");
        assert!((water_cm(10.973_53) - 2.0).abs() < 1e-3);
    }

    /// Direct normal and diffuse horizontal illuminance of 5 conditions agree with ladybug-core
    /// 0.44.62 (`tools/peers/bands.py`) to 0.8 %. ladybug-core takes the air mass of Kasten and
    /// Young, and 0.08 a degree of the dew point for the water.
    #[test]
    fn illuminance_agrees_with_ladybug() {
        for (altitude, dni, dhi, dew_point, direct_lx, diffuse_lx) in [
            (10.0, 300.0, 98.0, 5.0, 18_128.0, 11_795.0),
            (30.0, 700.0, 150.0, 10.0, 66_236.0, 20_987.0),
            (60.0, 850.0, 114.0, 15.0, 89_332.0, 15_133.0),
            (45.0, 0.0, 250.0, 8.0, 0.0, 29_232.0),
            (20.0, 100.0, 146.0, -3.0, 9_087.0, 16_858.0),
        ] {
            let sun = direction_from_degrees(180.0, altitude);
            let mut condition = Condition::new("c".into(), &[sun], sun, dni, dhi);
            condition.air = Some(Air { dew_point_c: Some(dew_point), ..Air::default() });
            let scale = luminous_efficacy(&condition);
            for (found, expected) in [(scale.sun * dni, direct_lx), (scale.sky * dhi, diffuse_lx)] {
                assert!((found - expected).abs() <= 0.008 * expected, "{altitude}: {found} {expected}");
            }
        }
    }

    /// Direct and diffuse light by their own models add up to the global light by its model. Over 6
    /// altitudes x 5 DNI x 4 DHI x 3 dew points they differ by less than 3.5 % in the mean and 15 %
    /// at most: three fits of separate data leave that much.
    #[test]
    fn direct_and_diffuse_light_make_the_global_light() {
        let (mut sum, mut largest, mut count) = (0.0, 0.0_f64, 0);
        for altitude in [10.0, 20.0, 30.0, 45.0, 60.0, 75.0] {
            let sun = direction_from_degrees(180.0, altitude);
            for dni in [0.0, 100.0, 300.0, 600.0, 900.0] {
                for dhi in [60.0, 100.0, 150.0, 250.0] {
                    for dew_point in [-5.0, 8.0, 20.0] {
                        let mut condition = Condition::new("c".into(), &[sun], sun, dni, dhi);
                        condition.air = Some(Air { dew_point_c: Some(dew_point), ..Air::default() });
                        let scale = luminous_efficacy(&condition);
                        let zenith = sun.z.acos();
                        let bin = BIN_ENDS.partition_point(|end| *end <= clearness(dni, dhi, zenith));
                        let [a, b, c, d] = GLOBAL[bin];
                        let delta = brightness(dhi, 1367.0, zenith);
                        let global = a + b * water_cm(dew_point) + c * sun.z + d * delta.ln();
                        let (whole, parts) = (global * (dhi + dni * sun.z), scale.sky * dhi + scale.sun * dni * sun.z);
                        let off = (parts / whole - 1.0).abs();
                        (sum, largest, count) = (sum + off, largest.max(off), count + 1);
                    }
                }
            }
        }
        let mean = sum / f64::from(count);
        assert!(count == 360 && mean < 0.035 && largest < 0.15, "{mean} {largest}");
    }

    /// Efficacies are finite and not below 0 over 5 altitudes x 5 DNI x 5 DHI: 125 conditions,
    /// including nights and a sun without a sky.
    #[test]
    fn efficacies_are_never_negative() {
        for altitude in [-5.0, 0.1, 2.0, 40.0, 90.0] {
            let sun = direction_from_degrees(90.0, altitude);
            for dni in [0.0, 1e-9, 50.0, 900.0, 1e6] {
                for dhi in [0.0, 1e-12, 5.0, 300.0, 1e6] {
                    let scale = luminous_efficacy(&Condition::new("c".into(), &[sun], sun, dni, dhi));
                    assert!(
                        [scale.sun, scale.sky].iter().all(|v| v.is_finite() && (0.0..683.0).contains(v)),
                        "{scale:?}"
                    );
                }
            }
        }
    }
}
