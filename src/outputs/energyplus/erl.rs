//! Programs in EnergyPlus's runtime language. In: names, which tables a surface has. Out: lines that set the actuator of each surface to
//! its reflected light over what EnergyPlus itself takes from the ground.
//!
//! What the actuator `View Factor To Ground` multiplies is the radiation that the ground reflects, GSR (output `Site Ground Reflected Solar
//! Radiation Rate per Area`); DHI and DNI are those of the site. The ground's reflectance of the hour is
//! GSR / (DNI sin(altitude) + DHI), with months and snow as EnergyPlus has them.

use super::sun_tables::NOMINAL_W_M2;

/// Less radiation from the ground than this is night, W/m2.
const NIGHT_W_M2: f64 = 0.01;

/// Names of what is added, which all begin alike.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names(String);

/// What the programs read of the site: the names behind the prefix, and the outputs.
pub const SENSORS: [(&str, &str); 5] = [
    ("DNI", "Site Direct Solar Radiation Rate per Area"),
    ("DHI", "Site Diffuse Solar Radiation Rate per Area"),
    ("GSR", "Site Ground Reflected Solar Radiation Rate per Area"),
    ("Azi", "Site Solar Azimuth Angle"),
    ("Alt", "Site Solar Altitude Angle"),
];

/// Variables that the first program sets for all others: what tables of suns and of the sky are multiplied by, the ground's reflectance.
pub const SHARED: [&str; 3] = ["B", "D", "R"];

impl Names {
    /// The first of `HT1`, `HT2` ... that none of `taken` begins with.
    pub fn free<'a>(taken: impl Iterator<Item = &'a str>) -> Names {
        let taken: Vec<String> = taken.map(str::to_uppercase).collect();
        let free = (1_u32..).map(|number| format!("HT{number}_"));
        Names(free.into_iter().find(|prefix| !taken.iter().any(|name| name.starts_with(prefix))).unwrap_or_default())
    }

    /// A name of its own.
    pub fn of(&self, what: &str) -> String {
        format!("{}{what}", self.0)
    }
}

/// Tables of a surface: what does not depend on the ground, what does, the sun in mirrors.
pub const TABLES: [&str; 3] = ["P", "Q", "S"];

/// Coefficients of one surface.
pub struct SurfaceTerms {
    /// Number behind the prefix of its actuator.
    pub actuator: usize,
    /// Number of its tables.
    pub tables: usize,
    /// Which of [`TABLES`] it has.
    pub has: [bool; 3],
    /// Under the sky, W/m2 by W/m2 of DHI: the same two parts.
    pub sky: [f64; 2],
}

/// The program that runs first. In `bare_months` the ground reflects nothing, whatever the model says.
pub fn sun_program(names: &Names, bare_months: &[usize]) -> Vec<String> {
    let n = |what: &str| names.of(what);
    let (b, d, r, gsr, dni, dhi, alt) = (n("B"), n("D"), n("R"), n("GSR"), n("DNI"), n("DHI"), n("Alt"));
    let mut lines = vec![
        format!("SET {b} = 0"),
        format!("SET {d} = 0"),
        format!("SET {r} = 0"),
        format!("IF {gsr} > {NIGHT_W_M2}"),
        format!("SET {d} = {dhi} / {gsr}"),
        format!("SET Beam = 0"),
        format!("IF {alt} > 0"),
        format!("SET {b} = {} * {dni} / {gsr}", 1.0 / NOMINAL_W_M2),
        format!("SET Sine = @Sin (@DegToRad {alt})"),
        "SET Beam = ".to_owned() + &dni + " * Sine",
        "ENDIF".into(),
        format!("SET {r} = {gsr} / (Beam + {dhi})"),
    ];
    for month in bare_months {
        lines.extend([format!("IF Month == {month}"), format!("SET {r} = 0"), "ENDIF".into()]);
    }
    lines.push("ENDIF".into());
    lines
}

/// Lines that set one actuator.
pub fn surface_lines(names: &Names, terms: &SurfaceTerms) -> Vec<String> {
    let n = |what: &str| names.of(what);
    let (azi, alt, actuator) = (n("Azi"), n("Alt"), n(&format!("A{}", terms.actuator)));
    let [sky, sky_ground] = terms.sky;
    let mut lines = vec![format!("SET {actuator} = {} * ({sky:.6} + {} * {sky_ground:.6})", n("D"), n("R"))];
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

    /// Of two prefixes that the model has, in any case, the third is taken.
    #[test]
    fn free_names() {
        let names = Names::free(["ht1_sun", "HT2_A", "wall", "HT3"].into_iter());
        assert_eq!(names.of("A1"), "HT3_A1");
    }

    /// A surface with all tables reads 3, one with neither none; blocks close.
    #[test]
    fn lines() {
        let names = Names::free(std::iter::empty());
        let of = |has| surface_lines(&names, &SurfaceTerms { actuator: 4, tables: 2, has, sky: [0.25, 0.5] });
        let count = |lines: &[String], word: &str| lines.iter().filter(|line| line.contains(word)).count();
        assert_eq!(count(&of([true; 3]), "@CurveValue"), 3);
        assert_eq!(of([false; 3]), ["SET HT1_A4 = HT1_D * (0.250000 + HT1_R * 0.500000)"]);
        let sun = sun_program(&names, &[2]);
        assert_eq!((count(&sun, "IF "), count(&sun, "ENDIF"), count(&sun, "Month == 2")), (3, 3, 1));
    }
}
