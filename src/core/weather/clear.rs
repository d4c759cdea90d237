//! Clear skies of a place, for use without weather. In: an altitude of the sun, or a place. Out:
//! DNI and DHI, or conditions of a year.

use glam::DVec3;

use crate::site::place::Place;
use crate::weather::conditions::Condition;
use crate::weather::time::bins::Bins;
use crate::weather::time::calendar::Date;
use crate::weather::time::sun::Location;

/// Returns DNI and DHI in W/m2 under a clear sky for the sine of the sun's altitude, above 0. DNI
/// is 1361 x 0.72^(m^0.678), m the air mass (Meinel and Meinel 1976, with 0.7 for 0.72; Kasten and
/// Young 1989). DHI is a round number of the size that weather files have.
pub fn clear_sky(sine: f64) -> (f64, f64) {
    let sine = sine.clamp(0.0, 1.0);
    let altitude_deg = sine.asin().to_degrees();
    let air_mass = 1.0 / (sine + 0.50572 * (altitude_deg + 6.07995).powf(-1.6364));
    (1361.0 * 0.72_f64.powf(air_mass.powf(0.678)), 60.0 + 60.0 * sine)
}

/// Returns the condition of a clear moment; no light with the sun below the horizon.
pub fn clear_moment(label: String, sun: DVec3) -> Condition {
    if sun.z <= 0.0 {
        return Condition::new(label, &[], sun, 0.0, 0.0);
    }
    let (dni, dhi) = clear_sky(sun.z);
    Condition::new(label, &[sun], sun, dni, dhi)
}

/// Day of each month whose declination is the mean of the month, and the number of days of the
/// month (Klein 1977, table 1).
const MEAN_DAYS: [(u32, u32); 12] = [
    (17, 31),
    (16, 28),
    (16, 31),
    (15, 30),
    (15, 31),
    (11, 30),
    (17, 31),
    (16, 31),
    (15, 30),
    (15, 31),
    (14, 30),
    (10, 31),
];

/// Year of the clear year; it has no leap day.
const YEAR: i32 = 2001;

/// Returns the clear year of a place: the hours of twelve days with the sun in their middle, by
/// true north, and the weights that add them up to kWh/m2.
pub fn clear_year(place: &Place) -> (Vec<Condition>, Bins) {
    let none = || (Vec::new(), Bins { count: 1, of_condition: Vec::new() });
    // Hours are counted from midnight of the meridian, so that the day is whole in any zone.
    let zone_hours = (place.longitude_deg / 15.0).round().clamp(-12.0, 14.0);
    let Ok(location) = Location::new(place.latitude_deg, place.longitude_deg, zone_hours, 0.0) else { return none() };
    let mut conditions = Vec::new();
    let mut of_condition = Vec::new();
    for (month, (day, days)) in (1..).zip(MEAN_DAYS) {
        let Some(date) = Date::new(YEAR, month, day) else { continue };
        for hour in 0..24 {
            let sun = location.sun(date, 60.0 * (f64::from(hour) + 0.5));
            if sun.z > 0.0 {
                conditions.push(clear_moment(format!("{month}/{hour}"), sun));
                of_condition.push((0, f64::from(days) / 1000.0));
            }
        }
    }
    (conditions, Bins { count: 1, of_condition })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// GHI of the clear year lies within 6 % of the sums of Haurwitz' clear sky (1945) that pvlib
    /// gives for all half hours of 2001: 1,722 kWh/m2 at 52 degrees north, 2,680 at the equator,
    /// 2,188 at 35 degrees south. The pole has 4,300 to 4,460 lit hours, and every DNI is below
    /// 1,000 W/m2.
    #[test]
    fn clear_years_agree_with_haurwitz() {
        for (latitude_deg, expected) in [(52.0, 1722.0), (0.0, 2680.0), (-35.0, 2188.0)] {
            let (conditions, bins) =
                clear_year(&Place { latitude_deg, longitude_deg: 4.3, convergence_deg: 0.0, epsg: None });
            let ghi = |c: &Condition| c.dni_w_m2 * c.sky_sun.z + c.dhi_w_m2;
            let sum: f64 = conditions.iter().zip(&bins.of_condition).map(|(c, bin)| ghi(c) * bin.1).sum();
            assert!((sum / expected - 1.0).abs() < 0.06, "{latitude_deg}: {sum}");
            assert!(conditions.iter().all(|c| (0.0..1000.0).contains(&c.dni_w_m2)));
        }
        let (_, bins) = clear_year(&Place { latitude_deg: 90.0, longitude_deg: 0.0, convergence_deg: 0.0, epsg: None });
        let hours = bins.of_condition.iter().map(|bin| bin.1 * 1000.0).sum::<f64>();
        assert!((4_300.0..=4_460.0).contains(&hours), "{hours}");
    }
}
