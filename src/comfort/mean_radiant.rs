//! Mean radiant temperature. In: shortwave and longwave irradiance of six directions, direct sun.
//! Out: the temperature of black surroundings from which a person absorbs the same radiation.
//!
//! Six directions: Höppe, "Ein neues Verfahren zur Bestimmung der mittleren Strahlungstemperatur im
//! Freien", Wetter und Leben 44, 1992; VDI 3787 part 2; Thorsson, Lindberg, Eliasson and Holmer,
//! "Different methods for estimating the mean radiant temperature in an outdoor urban setting",
//! International Journal of Climatology 27, 2007; Lindberg, Holmer and Thorsson, "SOLWEIG 1.0",
//! International Journal of Biometeorology 52, 2008. T = (S / (a_l sigma))^(1/4) with S = sum over
//! directions of F (a_k K + a_l L).
//!
//! A box gets too much sun from some azimuths and too little from others. The second function
//! counts the beam on a cylinder instead: Holmer, Lindberg, Rayner and Thorsson, "How to transform
//! the standing man from a box to a cylinder", 9th International Conference on Urban Climate, 2015.
//! SOLWEIG does so by default.

use heliotile_core::weather::emission::black_body_c;

/// Irradiance of six plane surfaces at the place of a person. Four of them are upright; their
/// azimuths need not be those of the compass, but two neighbours are 90 degrees apart.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectionalIrradiance {
    /// Irradiance of a horizontal surface that faces up, W/m2.
    pub from_above_w_m2: f64,
    /// Irradiance of a horizontal surface that faces down, W/m2.
    pub from_below_w_m2: f64,
    /// Irradiance of an upright surface that faces north, W/m2.
    pub from_north_w_m2: f64,
    /// Irradiance of an upright surface that faces east, W/m2.
    pub from_east_w_m2: f64,
    /// Irradiance of an upright surface that faces south, W/m2.
    pub from_south_w_m2: f64,
    /// Irradiance of an upright surface that faces west, W/m2.
    pub from_west_w_m2: f64,
}

impl DirectionalIrradiance {
    /// Returns one irradiance from all directions.
    pub fn uniform(w_m2: f64) -> Self {
        DirectionalIrradiance {
            from_above_w_m2: w_m2,
            from_below_w_m2: w_m2,
            from_north_w_m2: w_m2,
            from_east_w_m2: w_m2,
            from_south_w_m2: w_m2,
            from_west_w_m2: w_m2,
        }
    }

    /// Returns the mean over the body, W/m2: directions weighted by their angular factors.
    fn on_body_w_m2(&self, body: &RadiantBody) -> f64 {
        let sides = self.from_north_w_m2 + self.from_east_w_m2 + self.from_south_w_m2 + self.from_west_w_m2;
        body.side_factor * sides + body.vertical_factor * (self.from_above_w_m2 + self.from_below_w_m2)
    }
}

/// Radiation around a person.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RadiationField {
    /// Shortwave irradiance from the sun, the sky and surfaces that reflect them.
    pub shortwave: DirectionalIrradiance,
    /// Longwave irradiance from the sky, the ground and obstructions.
    pub longwave: DirectionalIrradiance,
}

/// Direct sun on a person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectSun {
    /// Irradiance of a surface normal to the beam, W/m2; 0 in shade.
    pub beam_normal_w_m2: f64,
    /// Altitude of the sun above the horizon, degrees; a sun below the horizon gives nothing.
    pub altitude_deg: f64,
}

/// Shape and surface of a person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadiantBody {
    /// Angular factor of each of the four sides.
    pub side_factor: f64,
    /// Angular factor of the direction above, and that of the one below. Four sides and these two
    /// make 1.
    pub vertical_factor: f64,
    /// Share of the body's surface that a horizontal beam falls on at right angles, from any
    /// azimuth. Only [`mean_radiant_temperature_of_cylinder_c`] uses it.
    pub cylinder_factor: f64,
    /// Share of shortwave irradiance that the body absorbs.
    pub shortwave_absorptivity: f64,
    /// Longwave emissivity of the body, which is its absorptivity.
    pub longwave_emissivity: f64,
}

impl RadiantBody {
    /// A standing person: 0.22, 0.06 (Höppe 1992, VDI 3787), 0.28 (Holmer and others 2015);
    /// absorptivity 0.7 and emissivity 0.97 (VDI 3787).
    ///
    /// The factors are those of ISO 7726:1998, annex B (read in table 4.4 of Brüel and Kjær's
    /// manual of the comfort analyser 1213), as the mean over azimuths and with the sum 1: 0.08 up
    /// and down, 0.23 right and left, 0.35 front and back give 0.08 / 1.32 = 0.06 and 0.29 / 1.32 =
    /// 0.22.
    pub const STANDING: RadiantBody = RadiantBody {
        side_factor: 0.22,
        vertical_factor: 0.06,
        cylinder_factor: 0.28,
        shortwave_absorptivity: 0.7,
        longwave_emissivity: 0.97,
    };

    /// A sitting person by ISO 7726:1998, computed as for [`RadiantBody::STANDING`]: 0.18, 0.22 and
    /// 0.30 give 0.18 / 1.4 = 0.13 and 0.26 / 1.4 = 0.185. The cylinder's factor, 0.20, is that of
    /// SOLWEIG.
    pub const SITTING: RadiantBody =
        RadiantBody { side_factor: 0.185, vertical_factor: 0.13, cylinder_factor: 0.20, ..Self::STANDING };
}

/// Returns the mean radiant temperature of a box, degrees Celsius, from irradiance of six
/// directions. The shortwave part includes direct sun.
///
/// `None` if the absorbed radiation is negative, infinite or NaN.
pub fn mean_radiant_temperature_c(field: &RadiationField, body: &RadiantBody) -> Option<f64> {
    temperature_c(field.shortwave.on_body_w_m2(body), field, body)
}

/// Returns the mean radiant temperature of an upright cylinder, degrees Celsius. The shortwave part
/// of `field` is diffuse and reflected light only: direct sun comes from `sun`.
///
/// The beam I of a sun at altitude h adds I cos h times the cylinder's factor, and I sin h times
/// the factor of the direction above. `None` if the absorbed radiation is negative, infinite or
/// NaN.
pub fn mean_radiant_temperature_of_cylinder_c(
    field: &RadiationField,
    sun: &DirectSun,
    body: &RadiantBody,
) -> Option<f64> {
    let beam_w_m2 = if sun.altitude_deg < 0.0 || sun.beam_normal_w_m2 == 0.0 {
        0.0
    } else {
        let (sin, cos) = sun.altitude_deg.to_radians().sin_cos();
        sun.beam_normal_w_m2 * (body.cylinder_factor * cos + body.vertical_factor * sin)
    };
    temperature_c(field.shortwave.on_body_w_m2(body) + beam_w_m2, field, body)
}

/// Returns the temperature of black surroundings that send the radiation that the body absorbs.
fn temperature_c(shortwave_w_m2: f64, field: &RadiationField, body: &RadiantBody) -> Option<f64> {
    let longwave_w_m2 = field.longwave.on_body_w_m2(body);
    let black_w_m2 = body.shortwave_absorptivity / body.longwave_emissivity * shortwave_w_m2 + longwave_w_m2;
    black_body_c(black_w_m2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::weather::emission::{ZERO_CELSIUS_K, black_body_w_m2};

    const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;

    const BODIES: [RadiantBody; 2] = [RadiantBody::STANDING, RadiantBody::SITTING];

    fn black(celsius: f64) -> DirectionalIrradiance {
        DirectionalIrradiance::uniform(black_body_w_m2(celsius))
    }

    fn dark(longwave: DirectionalIrradiance) -> RadiationField {
        RadiationField { longwave, ..RadiationField::default() }
    }

    /// The six angular factors of each body make 1. The factors of standing and sitting agree with
    /// ISO 7726 within 0.002 (above and below) and 0.001 (sides).
    #[test]
    fn angular_factors_add_up_to_1() {
        for body in BODIES {
            assert!((4.0 * body.side_factor + 2.0 * body.vertical_factor - 1.0).abs() < 1e-12, "{body:?}");
        }
        for (body, [vertical, lateral, sagittal]) in
            [(RadiantBody::STANDING, [0.08, 0.23, 0.35]), (RadiantBody::SITTING, [0.18, 0.22, 0.30])]
        {
            let sum: f64 = 2.0 * (vertical + lateral + sagittal);
            assert!((body.vertical_factor - vertical / sum).abs() < 2e-3, "{body:?}");
            assert!((body.side_factor - (lateral + sagittal) / 2.0 / sum).abs() < 1e-3, "{body:?}");
        }
    }

    /// In black surroundings of one temperature, without sun, the mean radiant temperature is that
    /// temperature within 1e-9 K.
    #[test]
    fn black_surroundings_give_their_own_temperature() {
        for celsius in [-60.0, -10.0, 0.0, 21.5, 75.0] {
            for body in BODIES {
                let got = mean_radiant_temperature_c(&dark(black(celsius)), &body).expect("a field");
                assert!((got - celsius).abs() < 1e-9, "{celsius}: {got}");
            }
        }
    }

    /// One warmer side of a standing person counts 0.22 of its fourth power: (0.22 313.15^4 + 0.78
    /// 293.15^4)^(1/4) is 297.943 K, by hand.
    #[test]
    fn one_warm_side_counts_by_its_angular_factor() {
        let DirectionalIrradiance { from_south_w_m2, .. } = black(40.0);
        let field = dark(DirectionalIrradiance { from_south_w_m2, ..black(20.0) });
        let got = mean_radiant_temperature_c(&field, &RadiantBody::STANDING).expect("a field");
        let expected = (0.22 * 313.15_f64.powi(4) + 0.78 * 293.15_f64.powi(4)).powf(0.25) - 273.15;
        assert!((got - expected).abs() < 1e-9, "{got} {expected}");
    }

    /// Uniform shortwave irradiance K adds 0.7 / 0.97 K to the longwave irradiance: the sum of
    /// 418.77 and 144.33 W/m2 belongs to 42.534 degrees, within 0.01.
    #[test]
    fn sunshine_adds_to_the_absorbed_longwave_irradiance() {
        let field = RadiationField { shortwave: DirectionalIrradiance::uniform(200.0), longwave: black(20.0) };
        let expected = ((418.77 + 0.7 / 0.97 * 200.0) / STEFAN_BOLTZMANN).powf(0.25) - 273.15;
        for body in BODIES {
            let got = mean_radiant_temperature_c(&field, &body).expect("a field");
            assert!((got - expected).abs() < 0.01, "{got} {expected}");
        }
    }

    /// A beam of 800 W/m2 adds 0.28 of it to a cylinder at altitude 0, 0.06 at 90, 0.28 cos 30 +
    /// 0.06 sin 30 at 30 and nothing at -1 degrees. The absorbed shortwave irradiance is that
    /// within 1e-9 W/m2.
    #[test]
    fn a_cylinder_absorbs_a_beam_by_its_altitude() {
        let field = dark(black(20.0));
        let longwave = STEFAN_BOLTZMANN * 293.15_f64.powi(4);
        let of_30 = 0.28 * 30.0_f64.to_radians().cos() + 0.06 * 0.5;
        for (altitude_deg, share) in [(0.0, 0.28), (90.0, 0.06), (30.0, of_30), (-1.0, 0.0)] {
            let sun = DirectSun { beam_normal_w_m2: 800.0, altitude_deg };
            let got = mean_radiant_temperature_of_cylinder_c(&field, &sun, &RadiantBody::STANDING).expect("a field");
            let absorbed = 0.97 * (STEFAN_BOLTZMANN * (got + ZERO_CELSIUS_K).powi(4) - longwave);
            assert!((absorbed - 0.7 * share * 800.0).abs() < 1e-9, "{altitude_deg}: {absorbed}");
        }
    }

    /// In the mean over all azimuths a box gets 0.22 (4 / pi) = 0.2801 of a horizontal beam, which
    /// is the cylinder's 0.28 within 0.0002.
    #[test]
    fn box_and_cylinder_agree_in_the_mean() {
        let steps = 3600;
        let of_azimuth = |step: i32| {
            let (sin, cos) = (f64::from(step) * std::f64::consts::TAU / f64::from(steps)).sin_cos();
            let shortwave = DirectionalIrradiance {
                from_north_w_m2: cos.max(0.0),
                from_south_w_m2: (-cos).max(0.0),
                from_east_w_m2: sin.max(0.0),
                from_west_w_m2: (-sin).max(0.0),
                ..DirectionalIrradiance::default()
            };
            shortwave.on_body_w_m2(&RadiantBody::STANDING)
        };
        let mean = (0..steps).map(of_azimuth).sum::<f64>() / f64::from(steps);
        assert!((mean - RadiantBody::STANDING.cylinder_factor).abs() < 2e-4, "{mean}");
    }

    /// NaN in a field or in the sun, negative absorption and an infinite beam give `None`. A field
    /// of 0 W/m2 is at absolute zero, -273.15.
    #[test]
    fn impossible_fields_have_no_temperature() {
        let body = RadiantBody::STANDING;
        assert_eq!(mean_radiant_temperature_c(&dark(DirectionalIrradiance::uniform(f64::NAN)), &body), None);
        assert_eq!(mean_radiant_temperature_c(&dark(DirectionalIrradiance::uniform(-1.0)), &body), None);
        assert_eq!(mean_radiant_temperature_c(&RadiationField::default(), &body), Some(-273.15));
        for (beam_normal_w_m2, altitude_deg) in [(f64::NAN, 10.0), (f64::INFINITY, 10.0), (500.0, f64::NAN)] {
            let sun = DirectSun { beam_normal_w_m2, altitude_deg };
            assert_eq!(mean_radiant_temperature_of_cylinder_c(&dark(black(20.0)), &sun, &body), None);
        }
    }
}
