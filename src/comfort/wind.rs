//! Wind at the height of a person. In: wind at 10 m above the ground, m/s. Out: wind at another
//! height, m/s.

/// Height of the wind that weather stations report, metres.
pub const STATION_HEIGHT_M: f64 = 10.0;

/// Height of the centre of gravity of a standing person, metres, for which PET and mean radiant
/// temperature are computed (VDI 3787 part 2).
pub const BODY_HEIGHT_M: f64 = 1.1;

/// Roughness length of short grass, metres, which the UTCI assumes.
pub const GRASS_ROUGHNESS_M: f64 = 0.01;

/// Height and ground for which the wind is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindProfile {
    /// Height above the ground, metres; more than the roughness length.
    pub height_m: f64,
    /// Roughness length of the ground, metres; less than 10.
    pub roughness_m: f64,
}

impl Default for WindProfile {
    /// Returns the profile at a standing person on short grass.
    fn default() -> Self {
        WindProfile { height_m: BODY_HEIGHT_M, roughness_m: GRASS_ROUGHNESS_M }
    }
}

/// Returns the wind at a height, m/s, from the wind at 10 m by the logarithmic profile, or `None`
/// where the profile has no value.
///
/// v(z) = v(10 m) ln(z / z0) / ln(10 m / z0): neutral air over open, even ground. With z0 = 0.01 m
/// it is the profile of the UTCI (Bröde and others, "Deriving the operational procedure for the
/// Universal Thermal Climate Index (UTCI)", International Journal of Biometeorology 56, 2012),
/// which makes 0.68 of the wind at 1.1 m. Between buildings wind is not a function of height: Lee,
/// Park and Mayer, International Journal of Biometeorology, 2024, found errors of up to 7 K in the
/// UTCI. The wind there needs a model of the flow.
pub fn wind_at_height_m_s(wind_10m_m_s: f64, profile: &WindProfile) -> Option<f64> {
    let WindProfile { height_m, roughness_m } = *profile;
    let is_profile = roughness_m > 0.0 && roughness_m < STATION_HEIGHT_M && height_m > roughness_m;
    (is_profile && height_m.is_finite() && (0.0..f64::INFINITY).contains(&wind_10m_m_s))
        .then(|| wind_10m_m_s * (height_m / roughness_m).ln() / (STATION_HEIGHT_M / roughness_m).ln())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At 10 m the wind is that of the station. At 1.1 m over grass 0.5 m/s become 0.34 (ln 110 /
    /// ln 1000 = 0.68046), within 1e-4.
    #[test]
    fn the_wind_profile_agrees_with_hand_computation() {
        let at = |height_m| WindProfile { height_m, ..WindProfile::default() };
        assert_eq!(wind_at_height_m_s(3.0, &at(10.0)), Some(3.0));
        let calm = wind_at_height_m_s(0.5, &WindProfile::default()).expect("a profile");
        assert!((calm - 0.5 * 0.680_46).abs() < 1e-4, "{calm}");
        assert_eq!(wind_at_height_m_s(0.0, &WindProfile::default()), Some(0.0));
    }

    /// A height below the roughness length, no roughness, a roughness of 10 m, wind below 0 and NaN
    /// give `None`: 6 of 6.
    #[test]
    fn impossible_profiles_have_no_wind() {
        for (wind_m_s, height_m, roughness_m) in [
            (1.0, 0.4, 0.5),
            (1.0, 1.1, 0.0),
            (1.0, 11.0, 10.0),
            (-1.0, 1.1, 0.01),
            (f64::NAN, 1.1, 0.01),
            (1.0, f64::NAN, 0.01),
        ] {
            assert_eq!(wind_at_height_m_s(wind_m_s, &WindProfile { height_m, roughness_m }), None);
        }
    }
}
