//! The time steps of EnergyPlus over a weather file. In: the file, steps an hour. Out: sun and sky
//! of each step as EnergyPlus has them.
//!
//! EnergyPlus takes the values of an hour for its middle and interpolates linearly between them; a
//! step has the sun and the light of its end. With one step an hour both are those of the middle
//! (measured in 25.2: light equal to all digits of the report).

use std::path::Path;

use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::row::WeatherRow;
use heliotile_core::weather::time::sun::extraterrestrial_w_m2;
use heliotile_weather::series::Weather;

/// Hours of a year, and of a leap year.
const HOURS: [usize; 2] = [8760, 8784];

/// Sun and sky of the steps that have light.
pub struct Steps {
    /// Number of all steps, dark ones too.
    pub count: usize,
    /// Steps in an hour.
    pub an_hour: usize,
    /// Numbers of the lit steps, ascending, `[lit]`.
    pub lit: Vec<usize>,
    /// Sun and sky of the lit steps, `[lit]`.
    pub conditions: Vec<Condition>,
    /// Month from 1 and depth of snow, cm, which determine the ground's reflectance, `[lit]`.
    pub grounds: Vec<(u32, Option<f64>)>,
}

impl Steps {
    /// Computes the steps of a whole year of hourly weather. An error: the file holds no whole
    /// year.
    pub fn new(weather: &Weather, file: &Path, an_hour: usize) -> Result<Steps> {
        let rows = &weather.rows;
        let at = |row: Option<&WeatherRow>| row.map(|r| (r.interval.date.month, r.interval.date.day));
        let is_year = HOURS.contains(&rows.len())
            && weather.interval_hours == 1.0
            && (at(rows.first()), at(rows.last())) == (Some((1, 1)), Some((12, 31)));
        if !is_year {
            let what = format!("has {} rows that are not the hours of one year from 1 January", rows.len());
            return Err(Error::input(file, None, what, "give the EPW file of a year, as EnergyPlus runs it")
                .because(Problem::Lacks("hours")));
        }
        let an_hour = an_hour.max(1);
        let count = rows.len() * an_hour;
        let mut steps = Steps { count, an_hour, lit: Vec::new(), conditions: Vec::new(), grounds: Vec::new() };
        for (hour, row) in rows.iter().enumerate() {
            for step in 0..an_hour {
                let share = if an_hour == 1 { 0.5 } else { (step + 1) as f64 / an_hour as f64 };
                let [dni_w_m2, dhi_w_m2] = at_end(rows, hour, share);
                let date = row.interval.date;
                let sun = weather.site.sun(date, row.interval.start_min + 60.0 * share);
                if sun.z <= 0.0 || dni_w_m2 + dhi_w_m2 <= 0.0 {
                    continue;
                }
                let condition = Condition::new(String::new(), &[sun], sun, dni_w_m2, dhi_w_m2);
                let extraterrestrial_w_m2 = extraterrestrial_w_m2(date);
                steps.conditions.push(Condition { extraterrestrial_w_m2, ..condition });
                steps.lit.push(hour * an_hour + step);
                steps.grounds.push((date.month, row.snow_depth_cm));
            }
        }
        Ok(steps)
    }
}

/// Interpolates DNI and DHI where a share of an hour has passed, on the line between the middles of
/// hours.
fn at_end(rows: &[WeatherRow], hour: usize, share: f64) -> [f64; 2] {
    let away = (share - 0.5).abs();
    let other = if share < 0.5 { hour.saturating_sub(1) } else { (hour + 1).min(rows.len().saturating_sub(1)) };
    let of = |hour: usize| rows.get(hour).map_or([0.0; 2], |row| [row.dni_w_m2, row.dhi_w_m2]);
    let (here, there) = (of(hour), of(other));
    [0, 1].map(|i| (1.0 - away) * here[i] + away * there[i])
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_files::input::weather::read_weather;

    /// DNI and DHI are those that EnergyPlus 25.2 reports for 10 June of Golden, hour 6, which has
    /// 51 and 37 W/m2 before 465 and 86: at a quarter to 6, 154.5 and 49.25 with the sun at 11.76
    /// degrees; with one step an hour, 51 and 37 at 9.07. Three days are no year.
    #[test]
    fn steps_have_the_dni_and_dhi_of_energyplus() {
        let file = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/weather").join(name);
        let path = file("golden_tmy3.epw");
        let weather = read_weather(&path).expect("a weather file");
        let hour = 160 * 24 + 5;
        for (an_hour, step, dni, dhi, altitude) in
            [(4, hour * 4 + 2, 154.5, 49.25, 11.7618), (1, hour, 51.0, 37.0, 9.0746)]
        {
            let steps = Steps::new(&weather, &path, an_hour).expect("a year");
            assert_eq!(steps.count, 8760 * an_hour);
            let at = steps.lit.binary_search(&step).expect("a step by day");
            let condition = &steps.conditions[at];
            assert_eq!((condition.dni_w_m2, condition.dhi_w_m2, steps.grounds[at].0), (dni, dhi, 6));
            assert!((condition.sky_sun.z.asin().to_degrees() - altitude).abs() < 0.15, "{:?}", condition.sky_sun);
        }
        let days = read_weather(&file("golden_3_days.epw")).expect("a weather file");
        assert!(Steps::new(&days, &path, 4).is_err());
    }
}
