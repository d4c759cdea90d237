//! Sun-path diagram of a place. In: a site. Out: directions of the sun along the days of the
//! solstices and of an equinox, and along the year at each full hour.

use glam::DVec3;

use crate::weather::time::calendar::Date;
use crate::weather::time::sun::Location;

/// Days of the solstices, between which the sun's paths lie, and of the spring equinox; in autumn
/// the sun takes the path of spring.
pub const DAYS: [(u32, u32, &str); 3] = [(6, 21, "21 Jun"), (3, 20, "20 Mar"), (12, 21, "21 Dec")];

/// A day of each month, between the solstices; the sun takes all paths but the first and the last
/// twice.
pub const MONTHS: [(u32, u32, &str); 7] = [
    (6, 21, "Jun"),
    (5, 21, "May, Jul"),
    (4, 20, "Apr, Aug"),
    (3, 20, "Mar, Sep"),
    (2, 20, "Feb, Oct"),
    (1, 21, "Jan, Nov"),
    (12, 21, "Dec"),
];

/// Year of the positions; in other years they differ by less than half a degree.
const YEAR: i32 = 2021;

/// Minutes between the points of a day.
const STEP_MIN: u32 = 5;

/// Days of each month that an hour's loop passes through.
const LOOP_DAYS: [u32; 5] = [1, 7, 13, 19, 25];

/// Paths of the sun over a site.
pub struct SunPath {
    /// `[day]`: directions from midnight to midnight, below the horizon too.
    pub days: Vec<Vec<DVec3>>,
    /// `[hour]`, 0 to 23: closed loop of the sun at this hour of the clock through a year.
    pub hours: Vec<Vec<DVec3>>,
}

impl SunPath {
    /// Returns the paths over a place on [`DAYS`].
    pub fn new(site: &Location) -> Self {
        SunPath::on(&DAYS, site)
    }

    /// Returns the paths on some days, each with month, day and a name.
    pub fn on(days: &[(u32, u32, &str)], site: &Location) -> Self {
        let sun = |month, day, minutes: u32| {
            // All of these dates exist, so the default is never used.
            Date::new(YEAR, month, day).map_or(DVec3::NEG_Z, |date| site.sun(date, f64::from(minutes)))
        };
        let path = |&(month, day, _): &(u32, u32, &str)| {
            (0..=24 * 60 / STEP_MIN).map(|step| sun(month, day, step * STEP_MIN)).collect()
        };
        let year = || (1..=12).flat_map(|month| LOOP_DAYS.map(|day| (month, day))).chain([(1, 1)]);
        let hour = |hour: u32| year().map(|(month, day)| sun(month, day, 60 * hour)).collect();
        SunPath { days: days.iter().map(path).collect(), hours: (0..24).map(hour).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At 52 N on its meridian the sun is highest at 90 - 52 + 23.44, 0 and -23.44 deg, within 0.3.
    /// The noon loop stays within 9 deg of azimuth from the meridian, and its altitudes span 46.9
    /// deg within 0.6. At 52 S the midday sun is in the north.
    #[test]
    fn the_noon_sun_has_known_heights() {
        let path = SunPath::new(&Location::new(52.0, 0.0, 0.0, 0.0).expect("a site"));
        for (day, declination) in path.days.iter().zip([23.44, 0.0, -23.44]) {
            let highest = day.iter().map(|d| d.z.asin().to_degrees()).fold(-90.0, f64::max);
            assert!((highest - (38.0 + declination)).abs() < 0.3, "{highest}");
        }
        let noon = &path.hours[12];
        assert_eq!((path.hours.len(), noon.len(), noon[0]), (24, 61, noon[60]));
        assert!(noon.iter().all(|d| d.y < 0.0 && d.x.atan2(-d.y).to_degrees().abs() < 9.0));
        let spread = noon.iter().map(|d| d.z.asin().to_degrees());
        let (low, high) = spread.fold((90.0, -90.0), |(l, h): (f64, f64), a| (l.min(a), h.max(a)));
        assert!((high - low - 46.9).abs() < 0.6, "{low} {high}");
        let south = SunPath::new(&Location::new(-52.0, 0.0, 0.0, 0.0).expect("a site"));
        assert!(south.hours[12].iter().all(|d| d.y > 0.0));
    }

    /// The paths of months are in order: at 52 N the midday sun falls by 3 to 13 deg from each of
    /// the 7 paths to the next, and the other month in a path's name stands within 1.5 deg of it.
    #[test]
    fn the_paths_of_months_are_in_order() {
        let site = Location::new(52.0, 0.0, 0.0, 0.0).expect("a site");
        let highest = |day: &Vec<DVec3>| day.iter().map(|d| d.z.asin().to_degrees()).fold(-90.0, f64::max);
        let months: Vec<f64> = SunPath::on(&MONTHS, &site).days.iter().map(highest).collect();
        assert_eq!(months.len(), 7);
        assert!(months.windows(2).all(|two| (3.0..13.0).contains(&(two[0] - two[1]))), "{months:?}");
        let partners = [(7, 23, "Jul"), (8, 23, "Aug"), (9, 23, "Sep"), (10, 22, "Oct"), (11, 21, "Nov")];
        let partners: Vec<f64> = SunPath::on(&partners, &site).days.iter().map(highest).collect();
        assert!(months[1..6].iter().zip(&partners).all(|(a, b)| (a - b).abs() < 1.5), "{months:?} {partners:?}");
    }
}
