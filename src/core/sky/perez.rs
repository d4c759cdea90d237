//! Perez all-weather sky: from DNI, DHI and the sun's altitude to the five parameters of the
//! radiance distribution.
//!
//! Perez, Seals and Michalsky, "All-weather model for sky luminance distribution - preliminary
//! configuration and validation", Solar Energy 50(3), 1993, with the erratum in 51(5). Range of the
//! data behind it: clearness 1 to about 12, brightness about 0.01 to 0.6. The limits on brightness
//! are those of gendaylit (Delaunay; Wienold).

use std::f64::consts::FRAC_PI_2;

use crate::sky::distribution::Distribution;

/// Upper ends of the first seven clearness bins (1990 paper, table 1); the eighth is open.
pub const BIN_ENDS: [f64; 7] = [1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2];

/// Table 1 of the paper: per bin a1..a4, b1..b4, c1..c4, d1..d4, e1..e4. Compared with three public
/// implementations.
const COEFFICIENTS: [[[f64; 4]; 5]; 8] = [
    [
        [1.3525, -0.2576, -0.2690, -1.4366],
        [-0.7670, 0.0007, 1.2734, -0.1233],
        [2.8000, 0.6004, 1.2375, 1.0000],
        [1.8734, 0.6297, 0.9738, 0.2809],
        [0.0356, -0.1246, -0.5718, 0.9938],
    ],
    [
        [-1.2219, -0.7730, 1.4148, 1.1016],
        [-0.2054, 0.0367, -3.9128, 0.9156],
        [6.9750, 0.1774, 6.4477, -0.1239],
        [-1.5798, -0.5081, -1.7812, 0.1080],
        [0.2624, 0.0672, -0.2190, -0.4285],
    ],
    [
        [-1.1000, -0.2515, 0.8952, 0.0156],
        [0.2782, -0.1812, -4.5000, 1.1766],
        [24.7219, -13.0812, -37.7000, 34.8438],
        [-5.0000, 1.5218, 3.9229, -2.6204],
        [-0.0156, 0.1597, 0.4199, -0.5562],
    ],
    [
        [-0.5484, -0.6654, -0.2672, 0.7117],
        [0.7234, -0.6219, -5.6812, 2.6297],
        [33.3389, -18.3000, -62.2500, 52.0781],
        [-3.5000, 0.0016, 1.1477, 0.1062],
        [0.4659, -0.3296, -0.0876, -0.0329],
    ],
    [
        [-0.6000, -0.3566, -2.5000, 2.3250],
        [0.2937, 0.0496, -5.6812, 1.8415],
        [21.0000, -4.7656, -21.5906, 7.2492],
        [-3.5000, -0.1554, 1.4062, 0.3988],
        [0.0032, 0.0766, -0.0656, -0.1294],
    ],
    [
        [-1.0156, -0.3670, 1.0078, 1.4051],
        [0.2875, -0.5328, -3.8500, 3.3750],
        [14.0000, -0.9999, -7.1406, 7.5469],
        [-3.4000, -0.1078, -1.0750, 1.5702],
        [-0.0672, 0.4016, 0.3017, -0.4844],
    ],
    [
        [-1.0000, 0.0211, 0.5025, -0.5119],
        [-0.3000, 0.1922, 0.7023, -1.6317],
        [19.0000, -5.0000, 1.2438, -1.9094],
        [-4.0000, 0.0250, 0.3844, 0.2656],
        [1.0468, -0.3788, -2.4517, 1.4656],
    ],
    [
        [-1.0500, 0.0289, 0.4260, 0.3590],
        [-0.3250, 0.1156, 0.7781, 0.0025],
        [31.0625, -14.5000, -46.1148, 55.3750],
        [-7.2312, 0.4050, 13.3500, 0.6234],
        [1.5000, -0.6426, 1.8564, 0.5636],
    ],
];

/// Factor of the cubed zenith angle, radians, in the clearness (1990 paper, equation 1).
pub const KAPPA: f64 = 1.041;

/// Returns the sky clearness epsilon, 1 (overcast) and up (Perez, Ineichen, Seals, Michalsky and
/// Stewart, Solar Energy 44(5), 1990, equation 1). `dhi` > 0.
pub fn clearness(dni_w_m2: f64, dhi_w_m2: f64, zenith_rad: f64) -> f64 {
    let z3 = KAPPA * zenith_rad.powi(3);
    ((dhi_w_m2 + dni_w_m2) / dhi_w_m2 + z3) / (1.0 + z3)
}

/// Returns the sky brightness delta (equation 2 of the paper of 1990): DHI x air mass / E0.
pub fn brightness(dhi_w_m2: f64, extraterrestrial_w_m2: f64, zenith_rad: f64) -> f64 {
    dhi_w_m2 * air_mass(zenith_rad) / extraterrestrial_w_m2
}

/// Returns the relative optical air mass of Kasten, "A new table and approximation formula for the
/// relative optical air mass", Archiv fuer Meteorologie B 14, 1966; zenith angles 0 to 90 deg,
/// where it is 36.5.
fn air_mass(zenith_rad: f64) -> f64 {
    let zenith_rad = zenith_rad.clamp(0.0, FRAC_PI_2);
    1.0 / (zenith_rad.cos() + 0.15 * (93.885 - zenith_rad.to_degrees()).powf(-1.253))
}

/// Returns the distribution of a sky; without diffuse light the uniform one. `sun_cos_zenith` below
/// 0 counts as 0.
pub fn distribution(dni_w_m2: f64, dhi_w_m2: f64, extraterrestrial_w_m2: f64, sun_cos_zenith: f64) -> Distribution {
    if dhi_w_m2 <= 0.0 || extraterrestrial_w_m2 <= 0.0 {
        return Distribution::default();
    }
    let zenith_rad = sun_cos_zenith.clamp(0.0, 1.0).acos();
    let epsilon = clearness(dni_w_m2, dhi_w_m2, zenith_rad);
    let delta = brightness(dhi_w_m2, extraterrestrial_w_m2, zenith_rad);
    parameters(epsilon, delta, zenith_rad)
}

/// Returns the distribution with the five parameters (1993 paper: linear in the zenith angle and in
/// delta, with exponential forms of c and d in the first bin).
pub fn parameters(epsilon: f64, delta: f64, zenith_rad: f64) -> Distribution {
    // Between overcast and intermediate skies the fit breaks down for dark skies; gendaylit raises
    // the brightness.
    let darkest = if epsilon > 1.065 && epsilon < 2.8 { 0.2 } else { 0.01 };
    let delta = delta.clamp(darkest, 0.6);
    let bin = BIN_ENDS.partition_point(|end| *end <= epsilon);
    let set = COEFFICIENTS.get(bin).copied().unwrap_or_default();
    let [a, b, mut c, mut d, e] = set.map(|x| x[0] + x[1] * zenith_rad + delta * (x[2] + x[3] * zenith_rad));
    if bin == 0 {
        let [_, _, c4, d4, _] = set;
        c = (delta * (c4[0] + c4[1] * zenith_rad)).powf(c4[2]).exp() - c4[3];
        d = d4[2] + delta * d4[3] - (delta * (d4[0] + d4[1] * zenith_rad)).exp();
    }
    Distribution { a, b, c, d, e, ..Distribution::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::direction_from_degrees;

    /// Kasten's air mass is 0.9995 at the zenith, 1.993 at 60 deg (2 less 0.4 %) and 36.5 at the
    /// horizon.
    #[test]
    fn air_masses_agree_with_kasten() {
        for (degrees, expected, tolerance) in [(0.0_f64, 0.9995, 1e-4), (60.0, 1.993, 1e-3), (90.0, 36.5, 0.1)] {
            let m = air_mass(degrees.to_radians());
            assert!((m - expected).abs() < tolerance, "{degrees}: {m}");
        }
    }

    /// Worked by hand for epsilon 7, delta 0.1, zenith 0: a = -1.05 + 0.0426, b = -0.325 + 0.07781,
    /// c = 31.0625 - 4.61148, d = -7.2312 + 1.335, e = 1.5 + 0.18564, to 1e-12.
    #[test]
    fn a_clear_sky_agrees_with_hand_computation() {
        let p = parameters(7.0, 0.1, 0.0);
        let expected = [-1.0074, -0.247_19, 26.451_02, -5.8962, 1.685_64];
        for (value, hand) in [p.a, p.b, p.c, p.d, p.e].into_iter().zip(expected) {
            assert!((value - hand).abs() < 1e-12, "{value} {hand}");
        }
    }

    /// The overcast bin uses its own c and d: for epsilon 1, delta 0.3, zenith 1, c = exp((0.3 x
    /// 3.4004)^1.2375) - 1 = 1.787 and d = -exp(0.3 x 2.5031) + 0.9738 + 0.08427 = -1.061, both to
    /// 1e-3.
    #[test]
    fn the_overcast_bin_uses_its_own_c_and_d() {
        let p = parameters(1.0, 0.3, 1.0);
        assert!((p.c - 1.787).abs() < 1e-3, "{}", p.c);
        assert!((p.d + 1.061).abs() < 1e-3, "{}", p.d);
    }

    /// Clearness is 1 without sun and grows with it: DNI = DHI at the zenith gives exactly 2.
    #[test]
    fn clearness_is_1_without_sun_and_grows_with_it() {
        for zenith in [0.0, 0.7, FRAC_PI_2] {
            assert!((clearness(0.0, 50.0, zenith) - 1.0).abs() < 1e-15);
        }
        assert_eq!(clearness(50.0, 50.0, 0.0), 2.0);
    }

    /// Radiance is finite and never negative over 13 sun altitudes x 9 DNI x 8 DHI x 60 directions:
    /// DHI from 5e-324 to 1e6 and DNI to 1e6 W/m2, including the sun on the horizon and at the
    /// zenith.
    #[test]
    fn radiance_is_never_negative() {
        let mut checked = 0;
        for altitude in [0.0, 1e-6, 0.1, 1.0, 5.0, 10.0, 20.0, 35.0, 50.0, 65.0, 80.0, 89.9, 90.0] {
            let sun = direction_from_degrees(123.0, altitude);
            for dni in [0.0, 1e-9, 1.0, 20.0, 100.0, 400.0, 900.0, 1e4, 1e6] {
                for dhi in [5e-324, 1e-12, 0.1, 3.0, 40.0, 250.0, 1000.0, 1e6] {
                    let sky = distribution(dni, dhi, 1367.0, sun.z);
                    for i in 0..60_u32 {
                        let direction = direction_from_degrees(f64::from(i) * 37.0, f64::from(i % 10) * 10.0);
                        let value = sky.relative_radiance(direction, sun);
                        assert!(value.is_finite() && value >= 0.0, "{altitude} {dni} {dhi}: {value}");
                        checked += 1;
                    }
                }
            }
        }
        assert_eq!(checked, 13 * 9 * 8 * 60);
    }
}
