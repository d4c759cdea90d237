//! Sums of a weather file by month, as the reader understood it. In: checked rows. Out: hours and
//! irradiation of each calendar month.

use crate::series::Weather;
use heliotile_core::units::kwh_from_w;
use heliotile_core::weather::row::WeatherRow;

/// Irradiation of a stretch of time, kWh/m2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WeatherSums {
    /// Length of the rows, hours.
    pub hours: f64,
    /// GHI as the file states it; `None` where a row with light states none.
    pub ghi_kwh_m2: Option<f64>,
    /// DNI that replays use.
    pub dni_kwh_m2: f64,
    /// DHI that replays use.
    pub dhi_kwh_m2: f64,
}

impl WeatherSums {
    /// Returns the sums of rows whose intervals last `interval_hours`.
    fn new<'r>(rows: impl Iterator<Item = &'r WeatherRow>, interval_hours: f64) -> Self {
        let nothing = WeatherSums { ghi_kwh_m2: Some(0.0), ..WeatherSums::default() };
        rows.fold(nothing, |sums, row| {
            let dark = row.dni_w_m2 == 0.0 && row.dhi_w_m2 == 0.0;
            let ghi_w_m2 = row.ghi_w_m2.or(dark.then_some(0.0));
            let ghi = sums.ghi_kwh_m2.zip(ghi_w_m2);
            WeatherSums {
                hours: sums.hours + interval_hours,
                ghi_kwh_m2: ghi.map(|(sum, ghi_w_m2)| sum + kwh_from_w(ghi_w_m2, interval_hours)),
                dni_kwh_m2: sums.dni_kwh_m2 + kwh_from_w(row.dni_w_m2, interval_hours),
                dhi_kwh_m2: sums.dhi_kwh_m2 + kwh_from_w(row.dhi_w_m2, interval_hours),
            }
        })
    }
}

impl Weather {
    /// Returns the sums of all rows.
    pub fn sums(&self) -> WeatherSums {
        WeatherSums::new(self.rows.iter(), self.interval_hours)
    }

    /// Returns the sums of each month that has rows, by its year and its number from 1 to 12, in
    /// the order of the file.
    pub fn monthly_sums(&self) -> Vec<((i32, u32), WeatherSums)> {
        let month = |row: &WeatherRow| (row.interval.date.year, row.interval.date.month);
        let months = self.rows.chunk_by(|row, next| month(row) == month(next));
        months.map(|rows| (month(&rows[0]), WeatherSums::new(rows.iter(), self.interval_hours))).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::formats::weather_file::parse_weather_as;
    use heliotile_core::weather::options::WeatherOptions;
    use heliotile_core::weather::time::clock_zone::ClockZone;

    /// Two hours of May and one of June, 400, 300 and 200 W/m2 of DHI, give 0.7 and 0.2 kWh/m2. The
    /// GHI of June, which the file leaves out, is not stated, and neither is that of all rows.
    #[test]
    fn months_add_up_and_an_absent_ghi_is_not_stated() {
        let text = "time,ghi,dni,dhi\n2021-05-31T10:00,500,200,400\n2021-05-31T11:00,400,100,300\n\
                    2021-05-31T12:00,0,0,0\n2021-06-01T10:00,,50,200\n2021-06-01T11:00,,0,0\n";
        let place = WeatherOptions {
            latitude_deg: Some(47.0),
            longitude_deg: Some(8.0),
            zone: Some(ClockZone::Hours(1.0)),
            ..WeatherOptions::default()
        };
        let weather = parse_weather_as(Path::new("w.csv"), text.as_bytes(), &place, &mut || Ok(None)).expect("weather");
        let months = weather.monthly_sums();
        let dhi: Vec<_> = months.iter().map(|(month, sums)| (*month, sums.dhi_kwh_m2)).collect();
        assert_eq!(dhi, [((2021, 5), 0.7), ((2021, 6), 0.2)]);
        assert_eq!(months[0].1.ghi_kwh_m2, Some(0.9));
        assert_eq!((months[1].1.ghi_kwh_m2, weather.sums().ghi_kwh_m2), (None, None));
        assert_eq!((weather.sums().hours, months[1].1.hours), (5.0, 2.0));
    }
}
