//! Sky models: the radiance of the sky relative to itself. In: a model and a condition. Out: a
//! [`Distribution`], a function of two angles. The code that integrates it to DHI sets the level
//! (W/m2/sr).

use std::fmt;
use std::str::FromStr;

use glam::DVec3;
use heliotile_requests::{Problem, Wrong};

use crate::sky::distribution::Distribution;
use crate::sky::{perez, perez1990};
use crate::weather::conditions::Condition;

/// Model of how the radiance of the sky is distributed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum SkyModel {
    /// Perez all-weather model (1993), from DNI and DHI.
    #[default]
    Perez,
    /// Model of tilted surfaces by Perez and others, 1990 ([`perez1990`]): an isotropic dome, light
    /// at the sun and a band at the horizon.
    Perez1990,
    /// Uniform sky.
    Uniform,
    /// CIE standard general sky, or the traditional overcast sky.
    Cie(CieType),
}

/// Parts of a sky, as irradiances of an open receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SkyParts {
    /// Irradiance of a horizontal receiver from the radiance that [`SkyModel::distribution`]
    /// spreads; with Perez 1990 it may be below 0.
    pub dome_w_m2: f64,
    /// Irradiance normal to the sun, from the directions of the suns.
    pub circumsolar_w_m2: f64,
    /// Irradiance of a wall from a band at the horizon; may be below 0.
    pub horizon_w_m2: f64,
}

/// Number of a CIE sky: a standard general sky, 1 (overcast, steep) to 15 (white-blue turbid), or
/// 16, the traditional overcast sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CieType(u8);

impl CieType {
    /// The traditional overcast sky, three times as bright at the zenith as at the horizon.
    /// Daylight rules such as the vertical sky component use it.
    pub const TRADITIONAL_OVERCAST: CieType = CieType(16);

    /// Iterates over all 16 types.
    pub fn all() -> impl Iterator<Item = CieType> {
        (1..=Self::TRADITIONAL_OVERCAST.0).map(CieType)
    }

    /// Returns the type of a number, or `None` outside 1..=16.
    pub fn new(number: u8) -> Option<Self> {
        CieType::all().find(|known| known.0 == number)
    }

    fn distribution(self) -> Distribution {
        let Some([a, b, c, d, e]) = CIE.get(usize::from(self.0) - 1).copied() else {
            return Distribution { slope: 2.0, ..Distribution::default() };
        };
        let offset = (d * std::f64::consts::FRAC_PI_2).exp();
        Distribution { a, b, c, d, e, offset, slope: 0.0 }
    }
}

/// Parameters a, b (gradation) and c, d, e (indicatrix) of the 15 types: ISO 15469:2004 / CIE S
/// 011:2003, table 1.
const CIE: [[f64; 5]; 15] = [
    [4.0, -0.70, 0.0, -1.0, 0.00],
    [4.0, -0.70, 2.0, -1.5, 0.15],
    [1.1, -0.80, 0.0, -1.0, 0.00],
    [1.1, -0.80, 2.0, -1.5, 0.15],
    [0.0, -1.00, 0.0, -1.0, 0.00],
    [0.0, -1.00, 2.0, -1.5, 0.15],
    [0.0, -1.00, 5.0, -2.5, 0.30],
    [0.0, -1.00, 10.0, -3.0, 0.45],
    [-1.0, -0.55, 2.0, -1.5, 0.15],
    [-1.0, -0.55, 5.0, -2.5, 0.30],
    [-1.0, -0.55, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 24.0, -2.8, 0.15],
];

impl SkyModel {
    /// Name, meaning and model of each sky without a number. `cie:1` to `cie:16` name the others.
    pub const NAMED: [(&'static str, &'static str, SkyModel); 3] = [
        ("perez", "all-weather, 1993", SkyModel::Perez),
        ("perez1990", "tilted surfaces, as in EnergyPlus and pvlib", SkyModel::Perez1990),
        ("uniform", "the same radiance everywhere", SkyModel::Uniform),
    ];

    /// Iterates over all models.
    pub fn all() -> impl Iterator<Item = SkyModel> {
        Self::NAMED.iter().map(|(.., sky)| *sky).chain(CieType::all().map(SkyModel::Cie))
    }

    /// Returns the names of all models, for messages: `perez, perez1990, uniform, cie:1 to cie:16`.
    pub fn names() -> String {
        let names: Vec<&str> = Self::NAMED.iter().map(|(name, ..)| *name).collect();
        format!("{}, cie:1 to cie:{}", names.join(", "), CieType::TRADITIONAL_OVERCAST.0)
    }

    /// Returns the names of all models and their meanings, for help texts.
    pub fn described() -> String {
        let named: Vec<String> = Self::NAMED.iter().map(|(name, meaning, _)| format!("{name} ({meaning})")).collect();
        let last = CieType::TRADITIONAL_OVERCAST.0;
        format!(
            "Sky radiance distribution: {}, or cie:1 to cie:{last} (the traditional overcast sky)",
            named.join(", ")
        )
    }

    /// Returns the distribution of the dome of a condition's sky.
    pub fn distribution(self, condition: &Condition) -> Distribution {
        match self {
            SkyModel::Uniform | SkyModel::Perez1990 => Distribution::default(),
            SkyModel::Cie(number) => number.distribution(),
            // DNI of a sun below the horizon is an error of the input and must not brighten the
            // sky.
            SkyModel::Perez => perez::distribution(
                if condition.suns.is_empty() { 0.0 } else { condition.dni_w_m2 },
                condition.dhi_w_m2,
                condition.extraterrestrial_w_m2,
                condition.sky_sun.z,
            ),
        }
    }

    /// Returns the parts of a condition's diffuse light; for all models but Perez 1990 all of it
    /// comes from the dome.
    pub fn parts(self, condition: &Condition) -> SkyParts {
        let dhi_w_m2 = condition.dhi_w_m2;
        if !self.brightens() || dhi_w_m2 <= 0.0 {
            return SkyParts { dome_w_m2: dhi_w_m2, ..SkyParts::default() };
        }
        let of = perez1990::coefficients(condition);
        SkyParts {
            dome_w_m2: dhi_w_m2 * (1.0 - of.f1),
            circumsolar_w_m2: dhi_w_m2 * of.f1 / of.b,
            horizon_w_m2: dhi_w_m2 * of.f2,
        }
    }

    /// Returns true if skies of this model may have light beside the dome.
    pub fn brightens(self) -> bool {
        self == SkyModel::Perez1990
    }

    /// Returns the relative radiance of the dome in a direction (unit, z >= 0).
    pub fn relative_radiance(self, condition: &Condition, direction: DVec3) -> f64 {
        self.distribution(condition).relative_radiance(direction, condition.sky_sun)
    }
}

impl FromStr for SkyModel {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let cie = || {
            let number = text.strip_prefix("cie:")?.parse().ok()?;
            CieType::new(number).map(SkyModel::Cie)
        };
        let named = SkyModel::NAMED.iter().find(|(name, ..)| *name == text).map(|(.., sky)| *sky);
        named.or_else(cie).ok_or_else(|| Wrong {
            problem: Problem::Unknown {
                found: text.to_owned(),
                known: SkyModel::all().map(|sky| sky.to_string()).collect(),
            },
            what: format!("`{text}` is not a sky model"),
            hint: format!("give one of {}", SkyModel::names()),
        })
    }
}

impl fmt::Display for SkyModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SkyModel::Cie(CieType(number)) => write!(f, "cie:{number}"),
            named => {
                let known = SkyModel::NAMED.iter().find(|(.., sky)| sky == named);
                f.write_str(known.map_or("", |(name, ..)| name))
            }
        }
    }
}

heliotile_requests::parse_by_text!(SkyModel: heliotile_requests::Form::TEXT);

crate::serde_by_text!(SkyModel);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::direction_from_degrees;

    /// All 19 models have different names, and each name reads as its model.
    #[test]
    fn names_read_as_their_models() {
        let names: std::collections::BTreeSet<String> = SkyModel::all().map(|sky| sky.to_string()).collect();
        assert_eq!(names.len(), 19);
        assert!(SkyModel::all().all(|sky| sky.to_string().parse::<SkyModel>().is_ok_and(|read| read == sky)));
    }

    fn cie(number: u8) -> Distribution {
        CieType::new(number).expect("a type").distribution()
    }

    /// CIE 1 at the zenith is 1 + 4 exp(-0.7) = 2.986 times the horizon, the 3:1 of Moon and
    /// Spencer (1942) within 0.5 %.
    #[test]
    fn cie_1_is_3_to_1_from_zenith_to_horizon() {
        let sky = cie(1);
        let sun = direction_from_degrees(180.0, 40.0);
        let ratio = sky.relative_radiance(DVec3::Z, sun) / sky.relative_radiance(DVec3::X, sun);
        assert!((ratio - (1.0 + 4.0 * (-0.7_f64).exp())).abs() < 1e-12);
        assert!((ratio / 3.0 - 1.0).abs() < 0.005, "{ratio}");
    }

    /// CIE 16 is (1 + 2 sin a) / 3 of its zenith at 7 altitudes, beside a sun at 40 degrees, to
    /// 1e-12.
    #[test]
    fn cie_16_follows_the_sine_of_the_altitude() {
        let (sky, sun) = (CieType::TRADITIONAL_OVERCAST.distribution(), direction_from_degrees(180.0, 40.0));
        let zenith = sky.relative_radiance(DVec3::Z, sun);
        for altitude in [0.0, 10.0, 25.0, 42.0, 60.0, 75.0, 90.0_f64] {
            let found = sky.relative_radiance(direction_from_degrees(200.0, altitude), sun) / zenith;
            assert!((found - (1.0 + 2.0 * altitude.to_radians().sin()) / 3.0).abs() < 1e-12, "{altitude}: {found}");
        }
    }

    /// CIE 5 is 1 everywhere; CIE 12 (clear) at 90 deg from the sun is its gradation, as the offset
    /// cancels, to 1e-12.
    #[test]
    fn cie_5_is_uniform_and_cie_12_its_gradation() {
        let sun = direction_from_degrees(180.0, 30.0);
        for altitude in [0.0, 20.0, 90.0] {
            let d = direction_from_degrees(70.0, altitude);
            assert_eq!(cie(5).relative_radiance(d, sun), 1.0);
        }
        let across = direction_from_degrees(90.0, 0.0);
        let sky = cie(12);
        assert!((sky.relative_radiance(across, sun) - sky.gradation(0.0)).abs() < 1e-12);
    }

    /// All 16 types are finite and not negative over 10,000 pairs of directions, including the sun
    /// on the horizon and at the zenith.
    #[test]
    fn general_skies_are_finite_and_not_negative() {
        for number in 1..=16 {
            let sky = cie(number);
            for i in 0..10_000_u32 {
                let sun = direction_from_degrees(0.0, f64::from(i % 10) * 10.0);
                let d = direction_from_degrees(f64::from(i) * 0.77, f64::from(i / 100) * 90.0 / 99.0);
                let value = sky.relative_radiance(d, sun);
                assert!(value.is_finite() && value >= 0.0, "type {number}: {value}");
            }
        }
    }

    /// All 19 names read as their models; the error for other names lists the choices.
    #[test]
    fn unknown_sky_models_are_refused_with_the_choices() {
        let mut all = vec![SkyModel::Perez, SkyModel::Perez1990, SkyModel::Uniform];
        all.extend((1..=16).filter_map(CieType::new).map(SkyModel::Cie));
        assert_eq!(all.len(), 19);
        assert!(SkyModel::all().eq(all.iter().copied()));
        for model in all {
            assert_eq!(model.to_string().parse::<SkyModel>().expect("own name"), model);
        }
        for bad in ["", "Perez ", "cie", "cie:", "cie:0", "cie:17", "cie:256", "cie:-1"] {
            let text = bad.parse::<SkyModel>().expect_err(bad).to_string();
            assert!(text.contains("perez, perez1990, uniform, cie:1 to cie:16"), "{text}");
        }
    }
}
