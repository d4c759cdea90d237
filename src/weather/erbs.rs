//! Diffuse share of global irradiance, for files that hold GHI only.
//!
//! Erbs, Klein and Duffie, "Estimation of the diffuse radiation fraction for hourly, daily and
//! monthly-average global radiation", Solar Energy 28(4), 1982, equation 1: hourly data of four
//! sites in the USA.

/// Returns DHI / GHI for a clearness index kt = GHI / (extraterrestrial irradiance x cos z).
pub fn diffuse_fraction(clearness_index: f64) -> f64 {
    let k = clearness_index;
    match k {
        _ if k <= 0.22 => 1.0 - 0.09 * k.max(0.0),
        _ if k <= 0.80 => 0.9511 + k * (-0.1604 + k * (4.388 + k * (-16.638 + k * 12.336))),
        _ => 0.165,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The three pieces meet within 0.002 at kt 0.22 and 0.80. By hand the share is 0.659 at kt
    /// 0.5, 1 at 0 and 0.165 above.
    #[test]
    fn the_pieces_of_erbs_meet() {
        for k in [0.22, 0.80] {
            let step = diffuse_fraction(k + 1e-9) - diffuse_fraction(k - 1e-9);
            assert!(step.abs() < 0.002, "{k}: {step}");
        }
        assert!((diffuse_fraction(0.5) - 0.6592).abs() < 1e-3, "{}", diffuse_fraction(0.5));
        assert_eq!((diffuse_fraction(0.0), diffuse_fraction(-1.0), diffuse_fraction(2.0)), (1.0, 1.0, 0.165));
    }
}
