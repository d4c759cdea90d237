//! The sky of Perez and others (1990) for tilted surfaces. In: DNI, DHI and the sun's height. Out:
//! the two brightening coefficients and the divisor of a condition's circumsolar light.
//!
//! Perez, Ineichen, Seals, Michalsky and Stewart, "Modeling daylight availability and irradiance
//! components from direct and global irradiance", Solar Energy 44(5), 1990, equation 9: an open
//! surface of tilt s, on which the sun's rays fall at an angle of cosine a, gets DHI [(1 - F1) (1 +
//! cos s) / 2 + F1 max(a, 0) / b + F2 sin s], b = max(cos 85 deg, cos z). EnergyPlus and pvlib use
//! it. Range of the data: thirteen sites, suns above some 5 degrees.

use std::f64::consts::FRAC_PI_2;

use crate::sky::perez::{BIN_ENDS, clearness};
use crate::weather::conditions::Condition;

/// Table 6 of the paper, all sites composite: per bin of clearness F11, F12, F13, F21, F22, F23.
/// pvlib 0.16.1 has these numbers as `allsitescomposite1990`.
pub const TABLE: [[f64; 6]; 8] = [
    [-0.008, 0.588, -0.062, -0.060, 0.072, -0.022],
    [0.130, 0.683, -0.151, -0.019, 0.066, -0.029],
    [0.330, 0.487, -0.221, 0.055, -0.064, -0.026],
    [0.568, 0.187, -0.295, 0.109, -0.152, -0.014],
    [0.873, -0.392, -0.362, 0.226, -0.462, 0.001],
    [1.132, -1.237, -0.412, 0.288, -0.823, 0.056],
    [1.060, -1.600, -0.359, 0.264, -1.127, 0.131],
    [0.678, -0.327, -0.250, 0.156, -1.377, 0.251],
];

/// Cosine of 85 degrees: the smallest divisor of circumsolar light.
pub const MIN_COSINE: f64 = 0.087_155_742_747_658_17;

/// Differences of a sky from an isotropic one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brightening {
    /// Share of DHI that comes from around the sun, F1, not below 0.
    pub f1: f64,
    /// Irradiance that a band at the horizon adds to a wall, over DHI, F2; below 0 under overcast
    /// skies.
    pub f2: f64,
    /// Divisor that turns circumsolar light on a horizontal surface into light normal to the sun.
    pub b: f64,
}

/// The isotropic dome alone.
const ISOTROPIC: Brightening = Brightening { f1: 0.0, f2: 0.0, b: 1.0 };

/// Returns the coefficients of a condition. For several suns the weighted mean cosine of their
/// zenith angles counts: an open horizontal surface then gets as much as from one sun. A sky
/// without a sun above the horizon is isotropic.
pub fn coefficients(condition: &Condition) -> Brightening {
    let cos_zenith: f64 = condition.suns.iter().map(|instant| instant.weight * instant.sun.z).sum();
    if condition.suns.is_empty() || cos_zenith <= 0.0 {
        return ISOTROPIC;
    }
    brightening(condition.dni_w_m2, condition.dhi_w_m2, condition.extraterrestrial_w_m2, cos_zenith)
}

/// Returns the coefficients for a sun at a height; isotropic without diffuse light.
pub fn brightening(dni_w_m2: f64, dhi_w_m2: f64, extraterrestrial_w_m2: f64, cos_zenith: f64) -> Brightening {
    let zenith_rad = cos_zenith.clamp(0.0, 1.0).acos();
    let epsilon = clearness(dni_w_m2, dhi_w_m2, zenith_rad);
    let delta = dhi_w_m2 * air_mass(zenith_rad) / extraterrestrial_w_m2;
    if !(epsilon.is_finite() && delta.is_finite()) {
        return ISOTROPIC;
    }
    let bin = BIN_ENDS.partition_point(|end| *end <= epsilon);
    let [f11, f12, f13, f21, f22, f23] = TABLE.get(bin).copied().unwrap_or_default();
    Brightening {
        f1: (f11 + f12 * delta + f13 * zenith_rad).max(0.0),
        f2: f21 + f22 * delta + f23 * zenith_rad,
        b: cos_zenith.max(MIN_COSINE),
    }
}

/// Constants of [`air_mass`]: a factor, degrees, an exponent.
pub const AIR_MASS: [f64; 3] = [0.50572, 96.07995, -1.6364];

/// Returns the relative optical air mass: Kasten and Young, "Revised optical air mass tables and
/// approximation formula", Applied Optics 28(22), 1989, equation 3; zenith angles of 0 to 90
/// degrees, where it is 38. pvlib uses this formula; the paper of 1990 used Kasten's of 1966.
pub fn air_mass(zenith_rad: f64) -> f64 {
    let zenith_rad = zenith_rad.clamp(0.0, FRAC_PI_2);
    let [factor, degrees, exponent] = AIR_MASS;
    1.0 / (zenith_rad.cos() + factor * (degrees - zenith_rad.to_degrees()).powf(exponent))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::units::direction_from_degrees;

    /// Worked by hand: DNI = DHI = 100 W/m2 and a sun at the zenith give epsilon 2, the fifth bin,
    /// and with an air mass of 1 / 1.000288 = 0.999712 delta 0.0731318, so F1 = 0.873 - 0.392 delta
    /// and F2 = 0.226 - 0.462 delta, to 1e-6.
    #[test]
    fn brightness_factors_agree_with_hand_computation() {
        let of = brightening(100.0, 100.0, 1367.0, 1.0);
        let delta = 0.073_131_8;
        assert!((of.f1 - (0.873 - 0.392 * delta)).abs() < 1e-6, "{of:?}");
        assert!((of.f2 - (0.226 - 0.462 * delta)).abs() < 1e-6 && of.b == 1.0, "{of:?}");
    }

    /// Suns at 30 and 50 degrees with equal weights have b = (sin 30 + sin 50) / 2 (1e-12), a sun
    /// at 2 degrees has cos 85 deg. No sun makes an isotropic sky, and so do 0 and 5e-324 W/m2 of
    /// diffuse light.
    #[test]
    fn without_suns_the_sky_is_isotropic() {
        let suns = [30.0, 50.0].map(|altitude| direction_from_degrees(100.0, altitude));
        let of = |suns: &[DVec3], dhi| coefficients(&Condition::new("c".into(), suns, DVec3::NEG_Z, 300.0, dhi));
        assert!((of(&suns, 100.0).b - (suns[0].z + suns[1].z) / 2.0).abs() < 1e-12);
        assert_eq!(of(&[direction_from_degrees(0.0, 2.0)], 100.0).b, MIN_COSINE);
        assert!((MIN_COSINE - 85.0_f64.to_radians().cos()).abs() < 1e-15);
        for none in [of(&[], 100.0), of(&suns, 0.0), of(&suns, 5e-324)] {
            assert_eq!(none, ISOTROPIC);
        }
    }
}
