//! Closure of a weather file: does GHI = DHI + DNI cos z hold with the sun at mid-interval, or at another time?
//!
//! A wrong time zone, rows in UT, or labels at the wrong end of the interval show as a smaller residual at a shifted sun.
//! Nothing is shifted silently: the reader warns.

use super::sun::Site;
use super::weather::Row;

/// Shifts tried: -120 to +120 minutes from mid-interval.
const STEP_MIN: i32 = 15;
const STEPS_EACH_SIDE: i32 = 8;

/// Hours with a lower sun say little: cosines are small and the sunlit part may be cut.
const LOWEST_SINE: f64 = 0.087_155_742_747_658_17; // sin 5 deg

/// Fewer rows prove nothing.
const FEWEST_ROWS: usize = 24;

/// More rows are thinned to this: the check must not cost more than reading.
const MOST_ROWS: usize = 4_000;

/// Root mean square of GHI - (DHI + DNI cos z) over the rows with the sun above 5 deg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closure {
    /// With the sun at mid-interval.
    pub rmse_w_m2: f64,
    /// At the best of the shifts tried.
    pub best_rmse_w_m2: f64,
    /// Best shift, minutes after mid-interval (negative: before).
    pub best_shift_min: i32,
}

impl Closure {
    /// The check over rows for which GHI, DNI and DHI were all in the file.
    pub fn of(site: &Site, rows: &[Row]) -> Option<Self> {
        let mut usable: Vec<(&Row, f64)> = rows
            .iter()
            .filter(|row| row.sun.z > LOWEST_SINE)
            .filter_map(|row| row.ghi_w_m2.map(|ghi| (row, ghi)))
            .collect();
        if usable.len() < FEWEST_ROWS {
            return None;
        }
        let stride = usable.len().div_ceil(MOST_ROWS);
        usable = usable.into_iter().step_by(stride).collect();
        let rmse = |shift_min: i32| {
            let sum: f64 = usable
                .iter()
                .map(|(row, ghi)| {
                    let sun = site.turned(row.sun, f64::from(shift_min));
                    let residual = ghi - row.dhi_w_m2 - row.dni_w_m2 * sun.z.max(0.0);
                    residual * residual
                })
                .sum();
            (sum / usable.len() as f64).sqrt()
        };
        let at_middle = rmse(0);
        let mut best = (at_middle, 0);
        for i in -STEPS_EACH_SIDE..=STEPS_EACH_SIDE {
            let shift_min = i * STEP_MIN;
            let value = rmse(shift_min);
            if value < best.0 {
                best = (value, shift_min);
            }
        }
        Some(Closure { rmse_w_m2: at_middle, best_rmse_w_m2: best.0, best_shift_min: best.1 })
    }

    /// A sentence if another time fits better by a factor of two and by more than 5 W/m2.
    pub fn warning(&self) -> Option<String> {
        let Closure { rmse_w_m2, best_rmse_w_m2, best_shift_min } = *self;
        let wrong = rmse_w_m2 > 2.0 * best_rmse_w_m2 && rmse_w_m2 - best_rmse_w_m2 > 5.0;
        wrong.then(|| {
            format!(
                "GHI = DHI + DNI cos(z) fits best with the sun {} min {} mid-interval ({best_rmse_w_m2:.1} W/m2 RMSE against \
                 {rmse_w_m2:.1} at mid-interval): the time zone or the time stamps look wrong. Nothing was shifted; correct \
                 the file's time zone or labels if so",
                best_shift_min.abs(),
                if best_shift_min < 0 { "before" } else { "after" },
            )
        })
    }
}
