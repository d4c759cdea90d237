//! Weather of several files as one series. In: weather of one station, a file for each stretch of
//! time. Out: one series in the order of time.

use std::path::PathBuf;

use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::weather::time::sun::Interval;

use crate::series::{Weather, WeatherReport};

/// Largest difference between the places of files of one station, degrees.
const SAME_PLACE_DEG: f64 = 0.05;

impl Weather {
    /// Joins the weather of several files, in any order. Fails if they are of different places or
    /// clocks, if their intervals have different lengths, or if they overlap in time.
    pub fn joined(mut parts: Vec<(PathBuf, Weather)>) -> Result<Weather> {
        let first = |weather: &Weather| weather.rows.first().map(|row| moment(&row.interval, row.interval.start_min));
        let last = |weather: &Weather| weather.rows.last().map(|row| moment(&row.interval, row.interval.end_min));
        parts.sort_by(|a, b| first(&a.1).partial_cmp(&first(&b.1)).unwrap_or(std::cmp::Ordering::Equal));
        for [(before, a), (file, b)] in parts.array_windows() {
            let apart = |a: f64, b: f64| (a - b).abs() > SAME_PLACE_DEG;
            let differ = match () {
                () if apart(a.site.latitude_deg, b.site.latitude_deg)
                    || apart(a.site.longitude_deg, b.site.longitude_deg) =>
                {
                    "is of another place than"
                }
                () if a.site.zone_hours != b.site.zone_hours => "has another clock than",
                () if a.interval_hours != b.interval_hours => "has intervals of another length than",
                () if first(b) < last(a) => "has the same days as",
                () => continue,
            };
            let hint = "put files of one station into the folder, one for each year: months of typical years overlap";
            return Err(
                Error::input(file, None, format!("{differ} {}", before.display()), hint).because(Problem::Misplaced)
            );
        }
        let with_air = parts.iter().all(|(_, weather)| !weather.air.is_empty());
        let joined = parts.into_iter().map(|(_, weather)| weather).reduce(|mut all, next| {
            all.rows.extend(next.rows);
            all.air.extend(next.air);
            all.report.warnings.extend(next.report.warnings);
            all
        });
        let mut joined =
            joined.ok_or_else(|| Error::argument("weather", "holds no weather", "give a folder with EPW files"))?;
        if !with_air {
            joined.air.clear();
        }
        joined.report = WeatherReport { warnings: joined.report.warnings, ..WeatherReport::default() };
        Ok(joined)
    }
}

/// Returns a moment of an interval's day as a number that rises with time.
fn moment(interval: &Interval, minutes: f64) -> f64 {
    f64::from(interval.date.day_number()) * 1440.0 + minutes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::weather_file::parse_weather;
    use std::path::Path;

    /// Returns two days of WEA from a day of January.
    fn days(name: &str, year: i32, day: u32, latitude: f64) -> (PathBuf, Weather) {
        let head = format!(
            "place Test_NLD\nlatitude {latitude}\nlongitude -4.3\ntime_zone -15\nsite_elevation 0\nweather_data_file_units 1\n"
        );
        let row = |i: u32| format!("1 {} {}.5 {} 50\n", day + i / 24, i % 24, if i % 24 == 12 { 300 } else { 0 });
        let text: String = std::iter::once(head).chain((0..48).map(row)).collect();
        let mut weather = parse_weather(Path::new(name), text.as_bytes()).expect("weather");
        for row in &mut weather.rows {
            let date = row.interval.date;
            row.interval.date =
                heliotile_core::weather::time::calendar::Date::new(year, date.month, date.day).expect("a date");
        }
        (name.into(), weather)
    }

    /// Files of 2019 and 2018 become 96 rows in the order of time. A third file is refused if it is
    /// of another place, or has a day of the others.
    #[test]
    fn years_are_joined_in_order() {
        let [a, b] = [days("2019.wea", 2019, 1, 52.0), days("2018.wea", 2018, 1, 52.0)];
        let joined = Weather::joined(vec![a.clone(), b.clone()]).expect("a series");
        let year = |row: usize| joined.rows[row].interval.date.year;
        assert_eq!((joined.rows.len(), year(0), year(95)), (96, 2018, 2019));
        for (other, says) in [
            (days("far.wea", 2020, 1, 40.0), "far.wea: is of another place than 2019.wea"),
            (days("late.wea", 2019, 2, 52.0), "late.wea: has the same days as 2019.wea"),
        ] {
            let error = Weather::joined(vec![a.clone(), b.clone(), other]).expect_err(says).to_string();
            assert!(error.contains(says), "{error}");
        }
        assert!(Weather::joined(Vec::new()).is_err());
    }
}
