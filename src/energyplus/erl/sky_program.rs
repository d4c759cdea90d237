//! The sky of Perez and others (1990) in the EnergyPlus runtime language. In: names. Out: lines
//! that compute, in each time step, how much of the diffuse light comes from around the sun and
//! from the horizon. EnergyPlus itself uses this model for the direct light of surfaces.
//!
//! The coefficients are those of [`heliotile_core::sky::perez1990`]. The extraterrestrial
//! irradiance is the mean of the year, which changes F1 by less than 0.003.

use heliotile_core::sky::perez::{BIN_ENDS, KAPPA};
use heliotile_core::sky::perez1990::{AIR_MASS, MIN_COSINE, TABLE};
use heliotile_core::weather::time::sun::SOLAR_CONSTANT_W_M2;

/// Returns lines that set `F1`, `F2` and `Around`, the divisor of circumsolar light on a level
/// surface. `Sine` is the sine of the sun's altitude, above 0.
pub fn brightening_lines(names: &Names) -> Vec<String> {
    let n = |what: &str| names.of(what);
    let (dni, dhi, alt) = (n("DNI"), n("DHI"), n("Alt"));
    let [a, b, c] = AIR_MASS;
    let mut lines = vec![
        "SET F1 = 0".to_owned(),
        "SET F2 = 0".into(),
        format!("SET Around = @Max Sine {MIN_COSINE:.9}"),
        format!("IF {dhi} > 0"),
        format!("SET Zenith = 90 - {alt}"),
        format!("SET Left = {b} - Zenith"),
        format!("SET Mass = 1 / (Sine + ({a} / (Left ^ {})))", -c),
        "SET Zenith = @DegToRad Zenith".into(),
        format!("SET Cubed = {KAPPA} * (Zenith ^ 3)"),
        format!("SET Clear = (1 + ({dni} / {dhi}) + Cubed) / (1 + Cubed)"),
        format!("SET Bright = {dhi} * Mass / {SOLAR_CONSTANT_W_M2}"),
    ];
    for (bin, row) in TABLE.iter().enumerate() {
        lines.push(match (bin, BIN_ENDS.get(bin)) {
            (0, Some(end)) => format!("IF Clear < {end}"),
            (_, Some(end)) => format!("ELSEIF Clear < {end}"),
            (_, None) => "ELSE".into(),
        });
        let [f11, f12, f13, f21, f22, f23] = *row;
        for (name, [fixed, by_brightness, by_zenith]) in [("F1", [f11, f12, f13]), ("F2", [f21, f22, f23])] {
            lines.push(format!(
                "SET {name} = {} + (Bright * {}) + (Zenith * {})",
                signed(fixed),
                signed(by_brightness),
                signed(by_zenith)
            ));
        }
    }
    lines.extend(["ENDIF".to_owned(), "SET F1 = @Max F1 0".into(), "ENDIF".into()]);
    lines
}

/// Prefix of the names of all added objects.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names(String);

impl Names {
    /// Returns the first prefix of `HT1_`, `HT2_` ... that no name in `taken` begins with, in any
    /// case of letters.
    pub fn free<'a>(taken: impl Iterator<Item = &'a str>) -> Names {
        let taken: Vec<String> = taken.map(str::to_uppercase).collect();
        let free = (1_u32..).map(|number| format!("HT{number}_"));
        Names(free.into_iter().find(|prefix| !taken.iter().any(|name| name.starts_with(prefix))).unwrap_or_default())
    }

    /// Returns the name `what` with the prefix.
    pub fn of(&self, what: &str) -> String {
        format!("{}{what}", self.0)
    }
}

/// Writes a number in the runtime language, which takes no minus sign behind an operator.
pub(super) fn signed(value: f64) -> String {
    let digits = format!("{:.6}", value.abs());
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    if value < 0.0 && digits != "0" { format!("(0 - {digits})") } else { digits.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each of the 8 bins has its two lines, and each block its end: 2 IF blocks, one of them a
    /// chain of 8.
    #[test]
    fn each_bin_of_perez_has_its_two_lines() {
        let lines = brightening_lines(&Names::free(std::iter::empty()));
        let count = |word: &str| lines.iter().filter(|line| line.starts_with(word)).count();
        assert_eq!((count("SET F1 = ") - 2, count("SET F2 = ") - 1), (8, 8));
        assert_eq!((count("IF "), count("ELSEIF "), count("ELSE") - count("ELSEIF "), count("ENDIF")), (2, 6, 1, 2));
        assert!(
            lines.contains(&"SET F2 = (0 - 0.06) + (Bright * 0.072) + (Zenith * (0 - 0.022))".to_owned()),
            "{lines:#?}"
        );
    }
}
