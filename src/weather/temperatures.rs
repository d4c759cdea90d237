//! Temperatures of the surfaces that receivers see. In: temperatures from the user, the air of a
//! weather file. Out: the emission of sky, ground and obstructions in each chosen row.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::series::Weather;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::replay::schedule_csv::{Column, ReadFile, Rows, parse_schedule};
use heliotile_core::site::material::Class;
use heliotile_core::text::message;
use heliotile_core::weather::emission::{Emission, black_body_w_m2};

/// Column of a schedule, with the range of its temperatures. No surface on Earth is colder, and a
/// higher number is in kelvin, not in degrees Celsius.
const CELSIUS: Column = Column { name: "temperature_c", low: -100.0, high: 150.0 };

/// A temperature that a user gives: `ground=12.5` degrees Celsius, or `obstruction=walls.csv`, a
/// schedule.
#[derive(Clone, Debug, PartialEq)]
pub struct Temperature {
    /// Class of the surfaces: ground or obstructions.
    pub class: Class,
    /// Temperature of the surfaces.
    pub of: Given,
}

/// A temperature in degrees Celsius, constant or from a schedule.
#[derive(Clone, Debug, PartialEq)]
pub enum Given {
    /// One temperature for all rows.
    Constant(f64),
    /// A file with a column `temperature_c`.
    Schedule(PathBuf),
}

impl Temperature {
    /// Returns the file of a schedule.
    pub fn file(&self) -> Option<&Path> {
        match &self.of {
            Given::Constant(_) => None,
            Given::Schedule(file) => Some(file),
        }
    }
}

impl FromStr for Temperature {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (name, value) = text.split_once('=').unwrap_or((text, ""));
        let class = Class::of_name(name).ok_or_else(|| {
            format!("`{name}` cannot have a temperature; give `ground` or `obstruction`, as in ground=12.5")
        })?;
        let of = match value.parse::<f64>() {
            Ok(celsius) if CELSIUS.holds(celsius) => Given::Constant(celsius),
            Ok(_) => return Err(format!("`{value}` is not from {} to {} degrees Celsius", CELSIUS.low, CELSIUS.high)),
            Err(_) if value.is_empty() => return Err("give degrees Celsius or a CSV file after the equals sign".into()),
            Err(_) => Given::Schedule(value.into()),
        };
        Ok(Temperature { class, of })
    }
}

/// Returns the emission in the chosen rows of a weather file, which was read from `file` with its
/// air. Surfaces without a given temperature have that of the air; of several given ones the last
/// counts. `files` returns the bytes of schedules.
pub fn emissions(
    weather: &Weather,
    file: &Path,
    chosen: &[bool],
    given: &[Temperature],
    files: ReadFile,
) -> Result<Vec<Emission>> {
    let dates: Vec<_> = weather.rows.iter().map(|row| row.interval.date).collect();
    let schedule = |class| match given.iter().rev().find(|temperature| temperature.class == class) {
        Some(Temperature { of: Given::Constant(celsius), .. }) => Ok(Some(vec![*celsius; dates.len()])),
        Some(Temperature { of: Given::Schedule(path), .. }) => {
            parse_schedule(path, &files(path)?, CELSIUS, Rows::Dated(&dates)).map(Some)
        }
        None => Ok(None),
    };
    let (ground, obstruction) = (schedule(Class::Ground)?, schedule(Class::Obstruction)?);
    let mut emissions = Vec::new();
    for (i, row) in weather.rows.iter().enumerate().filter(|(i, _)| chosen.get(*i) == Some(&true)) {
        let air = weather.air.get(i).copied().unwrap_or_default();
        let sky_w_m2 = air.sky_w_m2().ok_or_else(|| {
            let what = format!("horizontal infrared radiation is missing and cannot be computed without {}", {
                air.lacks().join(" and ")
            });
            let hint = "fill in horizontal infrared radiation (EPW: column 13), or the values that are missing; or \
                        leave such rows out with {from} and {to}; or leave out the column `longwave`";
            Error::input(file, row.line, what, hint).because(Problem::Lacks("infrared"))
        })?;
        let of_surface = |given: &Option<Vec<f64>>, name: &str| {
            let given = given.as_ref().and_then(|values| values.get(i)).copied();
            let celsius = given.or(air.dry_bulb_c).ok_or_else(|| {
                let what =
                    format!("dry bulb temperature is missing; `longwave` uses it as the temperature of the {name}");
                let hint = message!("fill in dry bulb temperature (EPW: column 7), or give a temperature, as in {{temperature}} {name}=12.5");
                Error::input(file, row.line, what, hint).because(Problem::Lacks("temperature"))
            })?;
            Ok(black_body_w_m2(celsius))
        };
        emissions.push(Emission {
            sky_w_m2,
            ground_w_m2: of_surface(&ground, "ground")?,
            obstruction_w_m2: of_surface(&obstruction, "obstruction")?,
        });
    }
    Ok(emissions)
}

heliotile_requests::parse_by_text!(Temperature: heliotile_requests::Form::TEXT => Temperature::file);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::epw::parse_epw_with_air;

    /// 12.5 is a constant, a name a file. Six wrong texts, one of them a number in kelvin, are
    /// refused with the values allowed.
    #[test]
    fn wrong_temperatures_are_refused_with_the_range() {
        let read = |text: &str| text.parse::<Temperature>();
        assert_eq!(read("ground=-5.5"), Ok(Temperature { class: Class::Ground, of: Given::Constant(-5.5) }));
        let file = read("obstruction=a=b.csv").expect("a file");
        assert_eq!((file.class, file.file()), (Class::Obstruction, Some(Path::new("a=b.csv"))));
        for (text, expected) in [
            ("roof=12", "`ground` or `obstruction`"),
            ("12", "`ground` or `obstruction`"),
            ("ground", "after the equals sign"),
            ("ground=", "after the equals sign"),
            ("ground=285.65", "-100 to 150 degrees Celsius"),
            ("ground=NaN", "-100 to 150 degrees Celsius"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.contains(expected), "{error}");
        }
    }

    /// 24 of the 72 rows of Golden are chosen. The first has the file's 237 W/m2, and ground and
    /// obstructions at its -5.7 degrees Celsius send 290.1. With 12.5 and then 0 given for the
    /// ground it sends 315.7, and a schedule of 20 in March makes obstructions send 418.8.
    #[test]
    fn surfaces_emit_at_the_temperature_of_the_air() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/weather/golden_3_days.epw");
        let weather = parse_epw_with_air(&path, &std::fs::read(&path).expect("data")).expect("weather");
        let chosen: Vec<bool> = (0..72).map(|i| i < 24).collect();
        let walls = |name: &Path| {
            assert_eq!(name, Path::new("walls.csv"));
            let months: String = (1..=12).map(|m| if m == 3 { "20\n" } else { "-9\n" }).collect();
            Ok(format!("temperature_c\n{months}").into_bytes())
        };
        let first = |given: &[&str]| {
            let given: Vec<Temperature> = given.iter().map(|text| text.parse().expect("a temperature")).collect();
            let emissions = emissions(&weather, &path, &chosen, &given, &walls).expect("emissions");
            assert_eq!(emissions.len(), 24);
            [emissions[0].sky_w_m2, emissions[0].ground_w_m2, emissions[0].obstruction_w_m2]
        };
        let near = |got: [f64; 3], expected: [f64; 3]| {
            assert!(got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.05), "{got:?} {expected:?}");
        };
        near(first(&[]), [237.0, 290.12, 290.12]);
        near(first(&["ground=12.5", "ground=0"]), [237.0, 315.66, 290.12]);
        near(first(&["obstruction=walls.csv"]), [237.0, 290.12, 418.77]);
    }
}
