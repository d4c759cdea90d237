//! Longwave emission of black surfaces and the sky. In: temperatures. Out: the emission that a
//! condition needs for longwave irradiance.

/// Stefan-Boltzmann constant, W/m2 K4 (CODATA 2018).
const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;

/// 0 degrees Celsius, K.
pub const ZERO_CELSIUS_K: f64 = 273.15;

/// Returns the exitance of a black surface, W/m2 (Stefan 1879, Boltzmann 1884): sigma T^4.
pub fn black_body_w_m2(celsius: f64) -> f64 {
    STEFAN_BOLTZMANN * (celsius + ZERO_CELSIUS_K).powi(4)
}

/// Returns the temperature of a black surface of this exitance, degrees Celsius: the inverse of
/// [`black_body_w_m2`]. `None` below 0 W/m2.
pub fn black_body_c(w_m2: f64) -> Option<f64> {
    (0.0..f64::INFINITY).contains(&w_m2).then(|| (w_m2 / STEFAN_BOLTZMANN).sqrt().sqrt() - ZERO_CELSIUS_K)
}

/// Longwave irradiance of a receiver that sees nothing but sky, ground or obstructions, W/m2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Irradiance from the open sky, horizontal.
    pub sky_w_m2: f64,
    /// Irradiance from the ground, a black body.
    pub ground_w_m2: f64,
    /// Irradiance from obstructions, black bodies.
    pub obstruction_w_m2: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A black surface emits 315.66 W/m2 at 0 degrees Celsius, 418.77 at 20 and nothing at absolute
    /// zero (sigma 273.15^4 and 293.15^4 by hand, to 0.01).
    #[test]
    fn black_bodies_emit_by_the_fourth_power() {
        for (celsius, expected) in [(0.0, 315.66), (20.0, 418.77), (-273.15, 0.0)] {
            assert!((black_body_w_m2(celsius) - expected).abs() < 0.01, "{celsius}: {}", black_body_w_m2(celsius));
            assert!(black_body_c(black_body_w_m2(celsius)).is_some_and(|back| (back - celsius).abs() < 1e-9));
        }
        assert_eq!((black_body_c(-1.0), black_body_c(f64::NAN)), (None, None));
    }
}
