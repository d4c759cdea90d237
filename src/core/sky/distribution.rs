//! Distribution of radiance over a sky, relative to itself: parameters and a function of two angles
//! that Perez' and the CIE's skies share.

use glam::DVec3;

/// Relative radiance: gradation(zenith angle) x indicatrix(angle from the sun), each clipped at 0.
/// With offset 0 it is Perez, Seals and Michalsky (1993) equation 1; with offset exp(d pi/2) it is
/// ISO 15469:2004. With slope 2 and all else 0 it is the CIE traditional overcast sky of Moon and
/// Spencer (1942).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distribution {
    /// Factor of the gradation from zenith to horizon.
    pub a: f64,
    /// Exponent of the gradation.
    pub b: f64,
    /// Increase of the gradation with the cosine of the zenith angle.
    pub slope: f64,
    /// Factor of the glow around the sun.
    pub c: f64,
    /// Exponent of the glow by radian from the sun.
    pub d: f64,
    /// Factor of the light scattered back, as the square of the cosine from the sun.
    pub e: f64,
    /// Subtracted from the glow's exponential: 0 by Perez, exp(d pi/2) by the CIE.
    pub offset: f64,
}

/// Smallest cos(zenith angle) of the gradation, as in gendaylit: b / cos stays finite at the
/// horizon.
const SMALLEST_COSINE: f64 = 0.01;

/// Smallest cos(zenith angle) of the gradation where b > 0, which Perez' fits give for low suns.
/// The sky then brightens towards the horizon as exp(b / cos). With [`SMALLEST_COSINE`] that would
/// reach e^30, and all light would come from the lowest patches. The scans behind the fits end near
/// 6 degrees of altitude, whose sine is about 0.1.
const SMALLEST_COSINE_RISING: f64 = 0.1;

impl Distribution {
    /// Returns 1 + a exp(b / cos zeta) + slope cos zeta, not below 0.
    pub fn gradation(&self, cos_zenith: f64) -> f64 {
        let floor = if self.b > 0.0 { SMALLEST_COSINE_RISING } else { SMALLEST_COSINE };
        (1.0 + self.a * (self.b / cos_zenith.max(floor)).exp() + self.slope * cos_zenith).max(0.0)
    }

    /// Returns 1 + c (exp(d gamma) - offset) + e cos^2 gamma, not below 0.
    pub fn indicatrix(&self, gamma_rad: f64, cos_gamma: f64) -> f64 {
        let glow = self.c * ((self.d * gamma_rad).exp() - self.offset);
        (1.0 + glow + self.e * cos_gamma * cos_gamma).max(0.0)
    }

    /// Returns the relative radiance in a direction (unit, z >= 0) for a sun direction (unit).
    pub fn relative_radiance(&self, direction: DVec3, sun: DVec3) -> f64 {
        let cos_gamma = direction.dot(sun).clamp(-1.0, 1.0);
        self.gradation(direction.z) * self.indicatrix(cos_gamma.acos(), cos_gamma)
    }
}
