//! The checked rows of a weather file, and the conditions of its intervals. In: rows, a number of
//! sub-steps. Out: conditions. [`crate::formats`] reads the files.
//!
//! DNI acts only while the sun is up. So an interval with a sunrise or sunset is cut to its sunlit
//! part before the sub-step mid-points are taken, and the DNI, an interval mean of energy, is
//! spread over that part (weights sum to 1). The mean of the sun on a surface is thus DNI x the
//! mean over the sunlit part of the cosine. Where DNI is given for an interval with the sun below
//! the horizon throughout (refraction, clock errors) there are no suns and that energy is lost; the
//! report counts it.

use heliotile_core::replay::sun_hours::RowSuns;
use heliotile_core::text::Message;
use rayon::prelude::*;

use crate::closure::Closure;
use crate::findings::Findings;
use heliotile_core::weather::air::Air;
use heliotile_core::weather::conditions::{Condition, Stamp};
use heliotile_core::weather::row::WeatherRow;
use heliotile_core::weather::time::sun::{Interval, KnownSuns, Location, extraterrestrial_w_m2};

/// Findings of the reader, for the user.
#[derive(Clone, Debug, Default)]
pub struct WeatherReport {
    /// Counts of doubtful rows, by kind.
    pub findings: Findings,
    /// Check of the time stamps; `None` if too few rows have GHI, DNI and DHI.
    pub closure: Option<Closure>,
    /// Sentences for the user, each naming a line or a number.
    pub warnings: Vec<Message>,
}

#[cfg(test)]
impl WeatherReport {
    /// Returns the warnings as lines.
    pub fn told(&self) -> String {
        self.warnings.iter().map(Message::plain).collect::<Vec<_>>().join("\n")
    }
}

/// A weather file.
#[derive(Clone, Debug)]
pub struct Weather {
    /// City and country of the header.
    pub place: String,
    /// Place of the station, and its standard time.
    pub site: Location,
    /// Rows in file order.
    pub rows: Vec<WeatherRow>,
    /// `[row]`: its air; empty if only light was read.
    pub air: Vec<Air>,
    /// Length of every row's interval, hours.
    pub interval_hours: f64,
    /// Shift of the time stamps that the user gave or had the reader find, minutes, later if
    /// positive.
    pub moved_min: f64,
    /// Findings and warnings.
    pub report: WeatherReport,
}

impl Weather {
    /// Returns the number of sun positions of an interval, if an hour has `steps_an_hour`. The sun
    /// moves equally far from one position to the next.
    pub fn steps_of(&self, steps_an_hour: u16) -> usize {
        // A count that exceeds a whole number by a rounding error is that number.
        ((f64::from(steps_an_hour) * self.interval_hours - 1e-9).ceil() as usize).max(1)
    }

    /// Returns the sun in the middle of a row, with the suns of the rows before and after it if
    /// these are of the same day and of equal length, without a gap between.
    pub fn known_suns(&self, place: usize, row: &WeatherRow) -> KnownSuns {
        let long_min = row.interval.end_min - row.interval.start_min;
        let beside = |other: Option<&WeatherRow>, after_min: f64| {
            let is_beside = |Interval { date, start_min, end_min }: Interval| {
                let starts = row.interval.start_min + after_min;
                date == row.interval.date && (start_min, end_min) == (starts, starts + long_min)
            };
            other.filter(|other| is_beside(other.interval)).map(|other| other.sun)
        };
        let before = place.checked_sub(1).and_then(|before| self.rows.get(before));
        let both = (beside(before, -long_min), beside(self.rows.get(place + 1), long_min));
        let beside = if let (Some(before), Some(after)) = both { Some([before, after]) } else { None };
        KnownSuns { middle: row.sun, beside }
    }

    /// Returns the suns of each row, `steps` of them, and the hours in which the sun is up.
    pub fn row_suns(&self, steps: usize) -> Vec<RowSuns> {
        let of = |(place, row): (usize, &WeatherRow)| RowSuns {
            suns: self.site.sunlit(&row.interval, self.known_suns(place, row), steps),
            up_h: self.site.sunlit_hours(&row.interval, self.known_suns(place, row)),
            dni_w_m2: row.dni_w_m2,
        };
        self.rows.iter().enumerate().map(of).collect()
    }

    /// Returns one condition per row, in file order, with the sun at `steps` mid-points of the
    /// sunlit part of its interval (at least one). The label is the START of the interval in local
    /// standard time, `YYYY-MM-DDTHH:MM`: hour 1 of EPW is 00:00. Rows without light get no suns.
    pub fn conditions(&self, steps: usize) -> Vec<Condition> {
        self.rows
            .par_iter()
            .enumerate()
            .map(|(place, row)| {
                let dark = row.dni_w_m2 == 0.0 && row.dhi_w_m2 == 0.0;
                let suns = || self.site.sunlit(&row.interval, self.known_suns(place, row), steps);
                let suns = if dark { Vec::new() } else { suns() };
                let date = row.interval.date;
                let label = row.interval.label();
                let condition = Condition::new(label, &suns, row.sun, row.dni_w_m2, row.dhi_w_m2);
                Condition {
                    extraterrestrial_w_m2: extraterrestrial_w_m2(date),
                    stamp: Some(Stamp { date, start_min: row.interval.start_min, hours: self.interval_hours }),
                    ..condition
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::weather::time::calendar::Date;

    fn weather(site: Location, rows: &[(f64, f64, f64)]) -> Weather {
        let date = Date::new(2021, 3, 21).expect("a date");
        let rows = rows
            .iter()
            .map(|&(hour, dni_w_m2, dhi_w_m2)| {
                let interval = Interval { date, start_min: 60.0 * hour, end_min: 60.0 * hour + 60.0 };
                WeatherRow {
                    line: 9,
                    interval,
                    sun: site.sun(date, interval.middle_min()),
                    ghi_w_m2: None,
                    dni_w_m2,
                    dhi_w_m2,
                    albedo: None,
                    snow_depth_cm: None,
                }
            })
            .collect();
        Weather {
            place: String::new(),
            site,
            rows,
            air: Vec::new(),
            interval_hours: 1.0,
            moved_min: 0.0,
            report: WeatherReport::default(),
        }
    }

    /// All of the DNI of a sunrise hour goes to the sunlit part: six suns, all up, weights sum
    /// to 1. Labels are the start of the interval. E0 is the day's value (1378 W/m2 on 21 March,
    /// within 2).
    #[test]
    fn light_of_a_sunrise_hour_goes_to_its_sunlit_part() {
        let site = Location::new(51.5, 0.0, 0.0, 10.0).expect("a site");
        let all = weather(site, &[(6.0, 50.0, 10.0), (12.0, 500.0, 100.0)]).conditions(6);
        for c in &all {
            assert_eq!(c.suns.len(), 6);
            assert!((c.suns.iter().map(|i| i.weight).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(c.suns.iter().all(|i| i.sun.z > 0.0) && c.sky_sun.z > 0.0);
            assert!((c.extraterrestrial_w_m2 - 1378.0).abs() < 2.0);
            assert_eq!(c.stamp.map(|s| (s.date.month, s.date.day, s.hours)), Some((3, 21, 1.0)));
        }
        assert_eq!(all[0].label, "2021-03-21T06:00");
        assert_eq!(all[0].stamp.map(|s| s.start_min), Some(360.0));
        // The sun is above 0 deg from 06:05 on: the mean sine altitude of the lit part is that of
        // its middle, 4.2 deg.
        let mean: f64 = all[0].suns.iter().map(|i| i.weight * i.sun.z).sum();
        assert!((mean - 0.074).abs() < 0.006, "{mean}");
    }

    /// Suns of an hour between two others of its day follow from those, and are within 1e-5 degrees
    /// of those of the hour alone. Without the row after it, or with a gap before it, they are
    /// those of the hour alone.
    #[test]
    fn suns_between_others_follow_from_them() {
        let site = Location::new(51.5, 0.0, 0.0, 10.0).expect("a site");
        let off = |hours: &[f64]| {
            let rows: Vec<(f64, f64, f64)> = hours.iter().map(|hour| (*hour, 500.0, 100.0)).collect();
            let (all, alone) = (weather(site, &rows).conditions(6), weather(site, &rows[1..2]).conditions(6));
            let pairs = all[1].suns.iter().zip(&alone[0].suns);
            pairs.map(|(a, b)| (a.sun - b.sun).length().to_degrees()).fold(0.0, f64::max)
        };
        let beside = off(&[9.0, 10.0, 11.0]);
        assert!(beside > 0.0 && beside < 1e-5, "{beside}");
        assert_eq!((off(&[9.0, 10.0]), off(&[8.0, 10.0, 11.0])), (0.0, 0.0));
    }

    /// DNI and DHI at night give no suns and a finite sky sun on the horizon (z = 0, length 1).
    #[test]
    fn light_at_night_gives_no_suns() {
        let site = Location::new(51.5, 0.0, 0.0, 10.0).expect("a site");
        let night = &weather(site, &[(1.0, 5.0, 3.0)]).conditions(4)[0];
        assert!(night.suns.is_empty());
        assert_eq!(night.sky_sun.z, 0.0);
        assert!((night.sky_sun.length() - 1.0).abs() < 1e-12);
        assert_eq!(night.dhi_w_m2, 3.0);
    }
}
