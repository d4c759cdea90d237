//! Suns and skies under which errors are estimated. In: a weather file or none, a number. Out: that
//! many conditions.

use std::path::Path;

use glam::{DMat3, DVec3};

use crate::settings::BuildSettings;
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::Observer;
use heliotile_core::replay::schedule_csv::ReadFile;
use heliotile_core::site::place::Place;
use heliotile_core::units::direction_from_degrees;
use heliotile_core::weather::clear::clear_sky;
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_weather::formats::weather_file::parse_weather_as;
use heliotile_weather::series::Weather;

/// Lowest and highest ([`HIGHEST_DEG`]) altitude of the suns, degrees. Below there is hardly any
/// energy; above, few places have the sun.
const LOWEST_DEG: f64 = 4.0;
const HIGHEST_DEG: f64 = 72.0;

/// Returns suns from all sides, for no particular place on Earth: even in azimuth and in the sine
/// of the altitude. Half of the skies are clear, a quarter half covered, a quarter overcast, with
/// round numbers of the size that weather files have.
fn spread(count: usize) -> Vec<Condition> {
    let (low, high) = (LOWEST_DEG.to_radians().sin(), HIGHEST_DEG.to_radians().sin());
    let condition = |i: usize| {
        let sine = low + (high - low) * mirrored_bits(i as u32);
        let altitude_deg = sine.asin().to_degrees();
        // Multiples of the golden section are even on a circle for any number of suns.
        let azimuth_deg = (i as f64 * 0.618_033_988_749_894_9).fract() * 360.0;
        let (clear, clear_dhi) = clear_sky(sine);
        // The kind of sky has a sequence of its own (Roberts 2018), or some kinds would have high
        // suns only.
        let (dni, dhi) = match (i as f64 * 0.754_877_666_246_692_8).fract() * 4.0 {
            kind if kind < 2.0 => (clear, clear_dhi),
            kind if kind < 3.0 => (0.45 * clear, 80.0 + 220.0 * sine),
            _ => (0.0, 40.0 + 330.0 * sine),
        };
        let sun = direction_from_degrees(azimuth_deg, altitude_deg);
        Condition::new(format!("{i}"), &[sun], sun, dni, dhi)
    };
    (0..count).map(condition).collect()
}

/// Returns true if the sun is up and there is any light.
pub fn is_lit(condition: &Condition) -> bool {
    !condition.suns.is_empty() && condition.dni_w_m2 + condition.dhi_w_m2 > 0.0
}

/// Number of hours with the sun up in a year.
const LIT_HOURS: usize = 4380;

/// Returns a year of hours with `steps` sun positions each, for timing: suns from all sides that
/// move by 15 degrees.
fn spread_year(steps: usize) -> Vec<Condition> {
    let moving = |condition: Condition| {
        let turned = |step: usize| DMat3::from_rotation_z((step as f64 / steps as f64 - 0.5) * 15_f64.to_radians());
        let suns: Vec<DVec3> = (0..steps).map(|step| turned(step) * condition.sky_sun).collect();
        Condition::new(condition.label, &suns, condition.sky_sun, condition.dni_w_m2, condition.dhi_w_m2)
    };
    spread(LIT_HOURS).into_iter().map(moving).collect()
}

/// Returns a term of van der Corput's sequence in base 2: 0, 1/2, 1/4, 3/4, ...
fn mirrored_bits(i: u32) -> f64 {
    f64::from(i.reverse_bits()) / 2.0_f64.powi(32)
}

/// Source of the conditions of an estimate.
pub enum ErrorConditions {
    /// Suns from all sides, for no particular place on Earth.
    Spread,
    /// Weather file and its name.
    Weather(String, Box<Weather>),
}

impl ErrorConditions {
    /// Reads a weather file by `files`, or returns suns from all sides without one. Warns of
    /// doubtful values in the file.
    pub fn read(
        file: Option<&Path>,
        options: &WeatherOptions,
        place: Option<Place>,
        files: ReadFile,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let Some(path) = file else { return Ok(ErrorConditions::Spread) };
        let weather = parse_weather_as(path, &files(path)?, options, &mut || Ok(place))?;
        weather.report.warnings.iter().for_each(|warning| observer.warn(warning));
        ErrorConditions::of_weather(path, weather)
    }

    /// Creates conditions from a weather file, and fails if it has no hour with light.
    pub fn of_weather(path: &Path, weather: Weather) -> Result<Self> {
        if !weather.conditions(1).iter().any(is_lit) {
            let hint = "give a weather file with hours of daylight";
            return Err(Error::input(path, None, "has no hour with light", hint));
        }
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        Ok(ErrorConditions::Weather(name, Box::new(weather)))
    }

    /// Returns the name of the conditions, for people and the manifest.
    pub fn name(&self) -> &str {
        match self {
            ErrorConditions::Spread => "suns from all sides",
            ErrorConditions::Weather(name, _) => name,
        }
    }

    /// Returns `count` conditions: suns from all sides, or hours of the weather file with light,
    /// evenly chosen, with the sun positions that `replay` uses by default.
    pub fn some(&self, count: usize) -> Vec<Condition> {
        let ErrorConditions::Weather(_, weather) = self else { return spread(count) };
        let lit: Vec<Condition> =
            weather.conditions(BuildSettings::default().steps.into()).into_iter().filter(is_lit).collect();
        let count = count.min(lit.len());
        (0..count).map(|i| lit[i * lit.len() / count].clone()).collect()
    }

    /// Returns all hours of a year with `steps` sun positions each.
    pub fn year(&self, steps: usize) -> Vec<Condition> {
        match self {
            ErrorConditions::Spread => spread_year(steps),
            ErrorConditions::Weather(_, weather) => weather.conditions(steps),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 60 to 68 of 256 conditions have no sun. The highest DNI is that of a clear sky at 72 degrees
    /// (940 to 1,000 W/m2). 50 or more suns come from each of the four quarters. The mean altitudes
    /// of clear and overcast skies differ by less than 3 degrees.
    #[test]
    fn suns_from_all_sides() {
        let all = spread(256);
        let altitude_deg = |dark: bool| {
            let some: Vec<f64> =
                all.iter().filter(|c| (c.dni_w_m2 == 0.0) == dark).map(|c| c.sky_sun.z.asin().to_degrees()).collect();
            (some.len(), some.iter().sum::<f64>() / some.len() as f64)
        };
        let ((dark, low), (_, high)) = (altitude_deg(true), altitude_deg(false));
        assert!((60..=68).contains(&dark) && (high - low).abs() < 3.0, "{dark} {low} {high}");
        let most = all.iter().map(|c| c.dni_w_m2).fold(0.0, f64::max);
        assert!((940.0..1000.0).contains(&most), "{most}");
        for quarter in 0..4 {
            let signs = (quarter & 1 == 0, quarter & 2 == 0);
            let there = all.iter().filter(|c| (c.sky_sun.x > 0.0, c.sky_sun.y > 0.0) == signs).count();
            assert!(there >= 50, "{quarter}: {there}");
        }
    }
}
