//! Programs in the EnergyPlus runtime language. In: names, the tables of a surface. Out: lines that
//! set the actuator of each surface to its reflected light, divided by the ground's light that
//! EnergyPlus itself uses.
//!
//! The actuator `View Factor To Ground` multiplies the radiation that the ground reflects, GSR
//! (output `Site Ground Reflected Solar Radiation Rate per Area`); DHI and DNI are those of the
//! site. The ground's reflectance of the hour is GSR / (DNI sin(altitude) + DHI), with months and
//! snow as EnergyPlus has them.

mod sky_program;

use crate::sun_tables::{NOMINAL_W_M2, ReflectedSky};
pub use sky_program::Names;
use sky_program::brightening_lines;
use sky_program::signed;

/// Ground-reflected radiation at or below which it is night, W/m2.
const NIGHT_W_M2: f64 = 0.01;

/// Sensors of the site: the name behind the prefix, and the output variable.
pub const SENSORS: [(&str, &str); 5] = [
    ("DNI", "Site Direct Solar Radiation Rate per Area"),
    ("DHI", "Site Diffuse Solar Radiation Rate per Area"),
    ("GSR", "Site Ground Reflected Solar Radiation Rate per Area"),
    ("Azi", "Site Solar Azimuth Angle"),
    ("Alt", "Site Solar Altitude Angle"),
];

/// Variables that the first program sets for all others: the factors of the tables of suns, of the
/// sky's dome and of its horizon, and the ground's reflectance.
pub const SHARED: [&str; 4] = ["B", "D", "H", "R"];

/// Tables of a surface: the part that does not depend on the ground, the part that does, the sun in
/// mirrors.
pub const TABLES: [&str; 3] = ["P", "Q", "S"];

/// Coefficients of one surface.
pub struct SurfaceTerms {
    /// Number of the surface's actuator, behind the prefix.
    pub actuator: usize,
    /// Number of the surface's tables.
    pub tables: usize,
    /// True for each of [`TABLES`] that the surface has.
    pub has: [bool; 3],
    /// Light under a uniform sky, W/m2 per W/m2 of DHI: the part that does not depend on the
    /// ground, and the part per ground reflectance.
    pub sky: [f64; 2],
    /// Light from the sky band at the horizon, W/m2 per W/m2: the two parts as in `sky`; 0 where
    /// the band does not count.
    pub horizon: [f64; 2],
}

/// Returns the lines of the program that runs first. In `bare_months` the ground reflects nothing,
/// whatever the model says.
pub fn sun_program(names: &Names, sky: ReflectedSky, bare_months: &[usize]) -> Vec<String> {
    let n = |what: &str| names.of(what);
    let (gsr, dni, dhi, alt) = (n("GSR"), n("DNI"), n("DHI"), n("Alt"));
    let [b, d, h, r] = SHARED.map(n);
    let mut lines: Vec<String> = [&b, &d, &h, &r].map(|shared| format!("SET {shared} = 0")).to_vec();
    lines.extend([
        format!("IF {gsr} > {NIGHT_W_M2}"),
        format!("SET {d} = {dhi} / {gsr}"),
        "SET Beam = 0".into(),
        format!("IF {alt} > 0"),
        format!("SET Sine = @Sin (@DegToRad {alt})"),
        format!("SET Beam = {dni} * Sine"),
        format!("SET Normal = {dni}"),
    ]);
    if sky == ReflectedSky::Perez1990 {
        lines.extend(brightening_lines(names));
        lines.extend([
            format!("SET Normal = {dni} + ({dhi} * F1 / Around)"),
            format!("SET {d} = {d} * (1 - F1)"),
            format!("SET {h} = {dhi} * F2 / {gsr}"),
        ]);
    }
    lines.extend([
        format!("SET {b} = {} * Normal / {gsr}", 1.0 / NOMINAL_W_M2),
        "ENDIF".into(),
        format!("SET {r} = {gsr} / (Beam + {dhi})"),
    ]);
    for month in bare_months {
        lines.extend([format!("IF Month == {month}"), format!("SET {r} = 0"), "ENDIF".into()]);
    }
    lines.push("ENDIF".into());
    lines
}

/// Returns the lines that set one actuator.
pub fn surface_lines(names: &Names, terms: &SurfaceTerms) -> Vec<String> {
    let n = |what: &str| names.of(what);
    let (azi, alt, actuator) = (n("Azi"), n("Alt"), n(&format!("A{}", terms.actuator)));
    let [sky, sky_ground] = terms.sky.map(signed);
    let mut lines = vec![format!("SET {actuator} = {} * ({sky} + {} * {sky_ground})", n("D"), n("R"))];
    let [low, low_ground] = terms.horizon.map(signed);
    if terms.horizon != [0.0; 2] {
        lines.push(format!("SET {actuator} = {actuator} + {} * ({low} + {} * {low_ground})", n("H"), n("R")));
    }
    if terms.has.contains(&true) {
        lines.push(format!("IF {} > 0", n("B")));
        let factors = [n("B"), format!("{} * {}", n("B"), n("R")), n("B")];
        for ((table, factor), _) in TABLES.into_iter().zip(factors).zip(terms.has).filter(|(_, has)| *has) {
            let index = n(&format!("{table}{}", terms.tables));
            lines.push(format!("SET Lit = @CurveValue {index} {azi} {alt}"));
            lines.push(format!("SET {actuator} = {actuator} + {factor} * Lit"));
        }
        lines.push("ENDIF".into());
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With two prefixes taken by the model, in any case of letters, the third is used.
    #[test]
    fn names_avoid_prefixes_of_the_model() {
        let names = Names::free(["ht1_sun", "HT2_A", "wall", "HT3"].into_iter());
        assert_eq!(names.of("A1"), "HT3_A1");
    }

    /// One of 3 numbers is below 0 after rounding: it is written as a difference, since EnergyPlus
    /// takes no minus behind another sign.
    #[test]
    fn numbers_below_zero_become_differences() {
        assert_eq!([0.5, -0.25, -1e-9].map(signed), ["0.5", "(0 - 0.25)", "0"]);
    }

    /// A surface with all tables reads 3, a surface without tables none; IF blocks are closed.
    #[test]
    fn a_surface_reads_only_the_tables_it_has() {
        let names = Names::free(std::iter::empty());
        let of = |has| {
            surface_lines(&names, &SurfaceTerms { actuator: 4, tables: 2, has, sky: [0.25, 0.5], horizon: [0.0; 2] })
        };
        let count = |lines: &[String], word: &str| lines.iter().filter(|line| line.contains(word)).count();
        assert_eq!(count(&of([true; 3]), "@CurveValue"), 3);
        assert_eq!(of([false; 3]), ["SET HT1_A4 = HT1_D * (0.25 + HT1_R * 0.5)"]);
        let sun = sun_program(&names, ReflectedSky::Uniform, &[2]);
        assert_eq!((count(&sun, "IF "), count(&sun, "ENDIF"), count(&sun, "Month == 2")), (3, 3, 1));
    }
}
