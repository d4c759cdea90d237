//! The weather file of the page. In: its bytes, unpacked. Out: conditions of rows, and the facts
//! that the page shows.

use std::path::Path;

use glam::DVec3;
use heliotile_comfort::people::climate::HourAir;
use heliotile_core::archive::Manifest;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::place::Place;
use heliotile_core::units::tilt_and_azimuth;
use heliotile_core::weather::air::Air;
use heliotile_core::weather::clear::clear_moment;
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_core::weather::row::WeatherRow;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::sun::Location;
use heliotile_weather::distance::far_apart;
use heliotile_weather::formats::weather_file::parse_weather_as;
use heliotile_weather::series::{Weather, WeatherReport};
use serde_json::json;

use crate::answer::{Answer, Numbers};
use crate::asked::Span;
use crate::failure::{Failure, worded_text};

/// Minutes of a day.
const DAY_MIN: f64 = 1440.0;

/// Year in which the sun is shown if no weather file has one, as for its paths.
const YEAR: i32 = 2021;

/// Weather file that is loaded.
pub struct LoadedWeather {
    pub weather: Weather,
    /// Number of sun positions in an interval.
    steps: usize,
    /// `[row]`: condition of the row, once it was asked for.
    conditions: Vec<Option<Condition>>,
    /// Reason why the air of the file cannot be read; `None` if it can.
    without_air: Option<String>,
}

impl LoadedWeather {
    /// Reads a weather file as `heliotile replay` does. A file without a place takes the scene's
    /// place.
    pub fn read(name: &str, bytes: &[u8], options: &WeatherOptions, manifest: &Manifest) -> Result<Self> {
        let (place, steps_an_hour) = (manifest.place, manifest.settings.steps());
        let mut weather = parse_weather_as(Path::new(name), bytes, options, &mut || Ok(place))?;
        let apart = place.and_then(|place| far_apart(&place, &weather));
        weather.report.warnings.extend(apart);
        Ok(LoadedWeather {
            steps: weather.steps_of(steps_an_hour),
            conditions: vec![None; weather.rows.len()],
            weather,
            without_air: None,
        })
    }

    /// Returns the file with the reason why its air cannot be read.
    pub fn without_air(self, why: Error) -> Self {
        LoadedWeather { without_air: Some(Failure::from(why).message), ..self }
    }

    /// Returns an error if the air of the file cannot be read.
    pub fn expect_air(&self) -> Result<()> {
        let hint = "mend the file, or set the air by numbers";
        self.without_air.as_ref().map_or(Ok(()), |why| Err(Error::argument("weather", why.clone(), hint)))
    }

    /// Returns the air of one row.
    pub fn air(&self, row: usize) -> Result<Air> {
        self.expect_air()?;
        self.weather.air.get(row).copied().ok_or_else(|| {
            let what = format!("the file has no air of row {row}");
            Error::argument("weather", what, "load a file with air temperature, humidity and wind")
        })
    }

    /// Returns the air of the rows of a span; in a file without air, all values are unknown.
    pub fn airs(&self, span: Span) -> Vec<HourAir> {
        let hours = self.weather.interval_hours;
        let rows = self.weather.rows.iter().enumerate().filter(|(_, row)| counts(span, row));
        rows.map(|(i, _)| HourAir { hours, ..HourAir::new(self.weather.air.get(i).copied().unwrap_or_default()) })
            .collect()
    }

    /// Returns one row and its condition.
    pub fn condition(&self, row: usize) -> Result<(WeatherRow, Condition)> {
        let found = self.weather.rows.get(row).copied();
        let condition = self.of_rows(found.into_iter().collect()).pop();
        found.zip(condition).ok_or_else(|| {
            let what = format!("there is no row {row} of {}", self.weather.rows.len());
            Error::argument("hour", what, "name a row of the weather file")
        })
    }

    /// Returns the conditions of some rows.
    fn of_rows(&self, rows: Vec<WeatherRow>) -> Vec<Condition> {
        let (place, air, report) = (String::new(), Vec::new(), WeatherReport::default());
        Weather { place, rows, air, report, ..self.weather }.conditions(self.steps)
    }

    /// Returns the labels of the intervals of a span: their starts.
    pub fn labels(&self, span: Span) -> Vec<String> {
        let rows = self.weather.rows.iter().filter(|row| counts(span, row));
        rows.map(|row| row.interval.label()).collect()
    }

    /// Returns the conditions of a span, and for each row of the file true if it lies in the span.
    pub fn conditions(&mut self, span: Span) -> (Vec<Condition>, Vec<bool>) {
        let chosen: Vec<bool> = self.weather.rows.iter().map(|row| counts(span, row)).collect();
        let missing: Vec<usize> = (0..chosen.len()).filter(|&i| chosen[i] && self.conditions[i].is_none()).collect();
        let made = self.of_rows(missing.iter().map(|&i| self.weather.rows[i]).collect());
        missing.into_iter().zip(made).for_each(|(i, condition)| self.conditions[i] = Some(condition));
        let taken = self.conditions.iter().zip(&chosen).filter(|(_, chosen)| **chosen);
        (taken.filter_map(|(condition, _)| condition.clone()).collect(), chosen)
    }

    /// Returns the first date of the file on a day of the year.
    fn date(&self, day_of_year: u32) -> Option<Date> {
        let mut dates = self.weather.rows.iter().map(|row| row.interval.date);
        dates.find(|date| date.day_of_year() == day_of_year)
    }

    /// Answers the facts about the file that the page shows.
    pub fn info(&self, name: &str) -> Answer {
        let Weather { rows, site, report, place, .. } = &self.weather;
        let of = |value: &dyn Fn(&WeatherRow) -> f64| rows.iter().map(|row| value(row) as f32).collect::<Vec<f32>>();
        let day = |value: &dyn Fn(Date) -> u32| rows.iter().map(|row| value(row.interval.date)).collect::<Vec<u32>>();
        let narrow = |values: Vec<u32>| values.iter().map(|value| *value as u8).collect::<Vec<u8>>();
        let short = |values: Vec<u32>| values.iter().map(|value| *value as u16).collect::<Vec<u16>>();
        let minutes = |row: &WeatherRow| row.interval.middle_min().rem_euclid(DAY_MIN) as u16;
        let azimuths = of(&|row| tilt_and_azimuth(row.sun).1);
        let altitudes = of(&|row| 90.0 - tilt_and_azimuth(row.sun).0);
        Answer::of(json!({
            "name": name,
            "rows": rows.len(),
            "labels": rows.iter().map(|row| row.interval.label()).collect::<Vec<_>>(),
            "warnings": report.warnings.iter().map(worded_text).collect::<Vec<_>>(),
            "latitude": site.latitude_deg,
            "longitude": site.longitude_deg,
            "zone": site.zone_hours,
            "place": place.split_whitespace().collect::<Vec<_>>().join(" "),
        }))
        .with("month", Numbers::U8(&narrow(day(&|date| date.month))))
        .with("day", Numbers::U8(&narrow(day(&|date| date.day))))
        .with("minutes", Numbers::U16(&rows.iter().map(minutes).collect::<Vec<u16>>()))
        .with("dayOfYear", Numbers::U16(&short(day(&Date::day_of_year))))
        .with("dni", Numbers::F32(&of(&|row| row.dni_w_m2)))
        .with("dhi", Numbers::F32(&of(&|row| row.dhi_w_m2)))
        .with("azimuth", Numbers::F32(&azimuths))
        .with("altitude", Numbers::F32(&altitudes))
    }
}

/// Returns true if a row lies in a span, by the day that the row counts to.
fn counts(span: Span, row: &WeatherRow) -> bool {
    match span {
        Span::Year => true,
        Span::Month { month } => row.interval.date.month == month,
        Span::Day { day_of_year } => row.interval.date.day_of_year() == day_of_year,
    }
}

/// Returns the location from which the sun is seen, with its clock: the weather file's, or else the
/// scene's with the time zone of its longitude.
pub fn location(weather: Option<&LoadedWeather>, place: Option<Place>) -> Result<Location> {
    let of_place = |place: Place| {
        let zone = (place.longitude_deg / 15.0).round();
        Location::new(place.latitude_deg, place.longitude_deg, zone, 0.0).ok()
    };
    weather.map(|loaded| loaded.weather.site).or_else(|| place.and_then(of_place)).ok_or_else(|| {
        let what = "neither the archive nor a weather file says where on Earth it is";
        Error::argument("sun", what, "load a weather file, or set the sun by azimuth and altitude")
    })
}

/// Answers the azimuth of the sun on a day of the year, degrees from true north, and its altitude
/// above the horizon.
pub fn sun(weather: Option<&LoadedWeather>, place: Option<Place>, day_of_year: u32, minutes: f64) -> Result<Answer> {
    let (tilt, azimuth) = tilt_and_azimuth(direction(weather, place, day_of_year, minutes)?);
    Ok(Answer::of(json!({ "azimuth": azimuth, "altitude": 90.0 - tilt })))
}

/// Answers DNI and DHI under a clear sky at a time of a day of the year, W/m2.
pub fn clear(weather: Option<&LoadedWeather>, place: Option<Place>, day_of_year: u32, minutes: f64) -> Result<Answer> {
    let condition = clear_moment(String::new(), direction(weather, place, day_of_year, minutes)?);
    Ok(Answer::of(json!({ "dni": condition.dni_w_m2, "dhi": condition.dhi_w_m2 })))
}

fn direction(weather: Option<&LoadedWeather>, place: Option<Place>, day_of_year: u32, minutes: f64) -> Result<DVec3> {
    Ok(location(weather, place)?.sun(date(weather, day_of_year)?, minutes))
}

/// Returns the date of a day of the year, in the year of the weather file if it has one.
pub fn date(weather: Option<&LoadedWeather>, day_of_year: u32) -> Result<Date> {
    let of_year = || {
        let first = Date::new(YEAR, 1, 1)?.day_number();
        Date::of_day_number(first.saturating_add(i32::try_from(day_of_year).ok()?.saturating_sub(1)))
    };
    let date = weather.and_then(|loaded| loaded.date(day_of_year)).or_else(of_year);
    date.ok_or_else(|| Error::argument("dayOfYear", day_of_year.to_string(), "give 1 to 366"))
}
