//! Closure of a weather file: the check if GHI = DHI + DNI cos z holds with the sun at
//! mid-interval, or at another time. In: rows and a location. Out: residuals and a warning.
//!
//! A wrong time zone, a longitude of the wrong sign, rows in UT, or labels at the wrong end of the
//! interval show as a smaller residual at a shifted sun. Nothing is shifted silently: the reader
//! warns.

use std::ops::RangeInclusive;

use rayon::prelude::*;

use heliotile_core::text::{Message, message};
use heliotile_core::weather::row::WeatherRow;
use heliotile_core::weather::time::sun::Location;

/// Largest shift that is tried, half a day each way, minutes: first coarsely (the residual changes
/// over hours), then by the minute.
const HALF_DAY_MIN: i32 = 720;
/// Step of the coarse shifts, minutes.
const COARSE_MIN: i32 = 30;
/// Number of coarse shifts to either side.
const STEPS: i32 = HALF_DAY_MIN / COARSE_MIN;

/// Largest ratio of the RMSE at a tenth of a minute to that at the whole minute for which the tenth
/// is reported.
const CLEARLY_BETTER: f64 = 0.95;

/// Least GHI of a row that is used, W/m2. With less light the sun is low, or its interval is cut by
/// the horizon.
const SMALLEST_GHI_W_M2: f64 = 50.0;

/// Least number of rows; fewer prove nothing.
const FEWEST_ROWS: usize = 24;

/// Largest number of rows; more are thinned to this, so that the check does not cost more than
/// reading.
const MAX_ROWS: usize = 4_000;

/// Largest share of GHI - DHI that the best shift may leave unexplained. Beyond it, time is not the
/// cause.
const LARGEST_SHARE: f64 = 0.2;

/// Root mean square of GHI - (DHI + DNI cos z) over the rows with DNI and a GHI above 50 W/m2. The
/// choice of these rows, for which the sun's position matters, does not depend on that position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closure {
    /// RMSE with the sun at mid-interval, W/m2.
    pub rmse_w_m2: f64,
    /// RMSE at the best of the shifts tried, W/m2.
    pub best_rmse_w_m2: f64,
    /// Best shift, minutes after mid-interval (negative: before): whole minutes, or tenths where
    /// these fit clearly better.
    pub best_shift_min: f64,
    /// Root mean square of GHI - DHI, the residual without any sun, W/m2.
    pub sunless_rmse_w_m2: f64,
}

impl Closure {
    /// Checks the rows for which GHI, DNI and DHI were all in the file; `None` if there are too
    /// few.
    pub fn new<'r>(site: &Location, rows: impl Iterator<Item = &'r WeatherRow>) -> Option<Self> {
        let mut usable: Vec<(&WeatherRow, f64)> = rows
            .filter(|row| row.dni_w_m2 > 0.0)
            .filter_map(|row| row.ghi_w_m2.map(|ghi| (row, ghi)))
            .filter(|(_, ghi)| *ghi > SMALLEST_GHI_W_M2)
            .collect();
        if usable.len() < FEWEST_ROWS {
            return None;
        }
        let stride = usable.len().div_ceil(MAX_ROWS);
        usable = usable.into_iter().step_by(stride).collect();
        let rmse = |shift_min: f64| {
            let sum: f64 = usable
                .iter()
                .map(|(row, ghi)| {
                    let sun = site.turned(row.sun, shift_min);
                    let residual = ghi - row.dhi_w_m2 - row.dni_w_m2 * sun.z.max(0.0);
                    residual * residual
                })
                .sum();
            (sum / usable.len() as f64).sqrt()
        };
        let at_middle = rmse(0.0);
        let better = |best: (f64, f64), shifts: Vec<f64>| {
            let tried: Vec<_> = shifts.into_par_iter().map(|shift| (rmse(shift), shift)).collect();
            // In the order of shifts, so that ties do not depend on the number of threads.
            tried.into_iter().fold(best, |best, next| if next.0 < best.0 { next } else { best })
        };
        let minutes =
            |range: RangeInclusive<i32>, around: f64, each: f64| range.map(|i| around + f64::from(i) * each).collect();
        let coarse = better((at_middle, 0.0), minutes(-STEPS..=STEPS, 0.0, f64::from(COARSE_MIN)));
        let whole = better(coarse, minutes(1 - COARSE_MIN..=COARSE_MIN - 1, coarse.1, 1.0));
        // A division by 10 gives the number nearest to a decimal, which is printed without a tail.
        let tenths = better(whole, (-9..=9).map(|tenth| (whole.1 * 10.0 + f64::from(tenth)) / 10.0).collect());
        let best = if tenths.0 < CLEARLY_BETTER * whole.0 { tenths } else { whole };
        let sunless: f64 = usable.iter().map(|(row, ghi)| (ghi - row.dhi_w_m2).powi(2)).sum();
        Some(Closure {
            rmse_w_m2: at_middle,
            best_rmse_w_m2: best.0,
            best_shift_min: best.1,
            sunless_rmse_w_m2: (sunless / usable.len() as f64).sqrt(),
        })
    }

    /// Returns the shift if it fits better than none by a factor of two and by more than 5 W/m2.
    pub fn better_shift_min(&self) -> Option<f64> {
        let better = self.rmse_w_m2 > 2.0 * self.best_rmse_w_m2 && self.rmse_w_m2 - self.best_rmse_w_m2 > 5.0;
        (better && self.fits_somewhere()).then_some(self.best_shift_min)
    }

    /// Returns true if the sun fits at mid-interval.
    pub fn holds(&self) -> bool {
        self.fits_somewhere() && self.better_shift_min().is_none()
    }

    fn fits_somewhere(&self) -> bool {
        self.best_rmse_w_m2 <= LARGEST_SHARE * self.sunless_rmse_w_m2
    }

    /// Returns a sentence if another time fits better, or if none fits. `moved_min` is the shift
    /// that time stamps have already. `zone_is_certain` says that the time stamps state their zone,
    /// so that another zone would move days and no sun.
    pub fn warning(&self, site: &Location, moved_min: f64, zone_is_certain: bool) -> Option<Message> {
        let Closure { rmse_w_m2, best_rmse_w_m2, sunless_rmse_w_m2, .. } = *self;
        if !self.fits_somewhere() {
            return Some(
                format!(
                    "GHI = DHI + DNI cos(z) does not hold: {rmse_w_m2:.1} W/m2 RMSE, {best_rmse_w_m2:.1} with the best \
                 time shift, {sunless_rmse_w_m2:.1} without any sun. Latitude or the radiation columns look wrong; \
                 they are used unchanged"
                )
                .into(),
            );
        }
        self.better_shift_min().map(|shift_min| {
            let hours = shift_min / 60.0;
            // The suggested values stay in the ranges that the header allows.
            let zone = (site.zone_hours - hours + 12.0).rem_euclid(24.0) - 12.0;
            let longitude = (site.longitude_deg + 15.0 * hours + 180.0).rem_euclid(360.0) - 180.0;
            // Binary fractions of tenths are not worth printing.
            let whole_shift = ((moved_min + shift_min) * 1e3).round() / 1e3;
            let done = match moved_min == 0.0 {
                true => "Nothing was shifted".into(),
                false => format!("A shift of {moved_min}min does not correct it"),
            };
            let (suspects, so_does) = match zone_is_certain {
                true => ("longitude", String::new()),
                false => ("time zone, longitude", format!(" a time zone of {zone:.2} or")),
            };
            message!(
                "GHI = DHI + DNI cos(z) fits best with the sun {} min {} mid-interval ({best_rmse_w_m2:.1} W/m2 RMSE against \
                 {rmse_w_m2:.1} at mid-interval): {suspects} or time stamps look wrong. {done}; {{shift}} {whole_shift}min puts \
                 the sun there, and so does{so_does} a longitude of {longitude:.1}",
                shift_min.abs(),
                if shift_min < 0.0 { "before" } else { "after" },
            )
        })
    }
}
