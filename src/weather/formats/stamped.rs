//! Intervals of rows from their time stamps. In: rows in file order, each with its stamp. Out:
//! their intervals. Missing rows are counted, rows out of order refused.

use std::collections::BTreeMap;
use std::path::Path;

use crate::judging::raw_weather::RawRow;
use heliotile_core::error::{Error, Result};
use heliotile_core::weather::options::StampedAt;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::clock_zone::ClockZone;
use heliotile_core::weather::time::sun::Interval;

/// Steps that a series of weather may have, seconds.
const STEPS_S: std::ops::RangeInclusive<i64> = 60..=3600;

const DAY_S: i64 = 86_400;

/// Zones that are no whole hours ahead of UTC, seconds.
const HALF_HOUR_ZONES_S: [i64; 9] = [-34_200, -12_600, -9_000, 12_600, 16_200, 19_800, 23_400, 34_200, 37_800];

/// Rows with their time stamps.
pub struct StampedRows {
    /// Rows whose intervals are not yet known.
    pub rows: Vec<RawRow>,
    /// `[row]`: stamp in seconds after 1970-01-01 00:00 of the clock by which days and labels go.
    pub seconds: Vec<i64>,
    pub stamped_at: StampedAt,
    /// True if a row stamped with its end counts to the day that it starts in, as the 24:00 of an
    /// hour does. Otherwise it counts to the day of the stamp.
    pub day_of_start: bool,
    /// Delay of each row after its stamp, minutes.
    pub late_min: f64,
    /// Shift of the first stamp from the file's clock to another one, seconds.
    pub moved_s: i64,
    /// Clock that bounds days where it is not that of `seconds`.
    pub legal: Option<LegalDays>,
}

/// Days of a clock with summer time, for stamps in its standard time.
#[derive(Clone, Copy)]
pub struct LegalDays {
    pub zone: ClockZone,
    /// Hours that the standard time of the stamps is ahead of UTC.
    pub standard_hours: f64,
}

impl LegalDays {
    /// Returns the seconds that the legal clock is ahead of a moment of standard time.
    fn ahead_s(self, at: i64) -> i64 {
        let standard_s = (self.standard_hours * 3600.0).round() as i64;
        self.zone.offset_s(at - standard_s) - standard_s
    }
}

/// Rows with their intervals.
pub struct SteppedRows {
    pub rows: Vec<RawRow>,
    pub step_min: f64,
    /// Sentence on missing rows.
    pub warning: Option<String>,
}

/// Count of the rows that are missing.
#[derive(Default)]
struct Missing {
    rows: i64,
    gaps: usize,
    /// Line and stamps around the first gap.
    first: Option<(usize, i64, i64)>,
}

impl StampedRows {
    /// Finds the step, which is the most common time from row to row, and with it the intervals.
    pub fn stepped(mut self, path: &Path) -> Result<SteppedRows> {
        let step = self.step(path)?;
        self.join_months(step);
        let missing = self.check_order(path, step)?;
        let back = self.back(step);
        let StampedRows { mut rows, seconds, stamped_at, late_min, legal, .. } = self;
        let step_min = step as f64 / 60.0;
        let before_min = stamped_at.share_before() * step_min - back as f64 / 60.0;
        for (row, at) in rows.iter_mut().zip(seconds) {
            let at = at - back;
            let ahead_s = legal.map_or(0, |legal| legal.ahead_s(at));
            let Some(date) = date_of(at + ahead_s) else {
                let what = "the time stamp lies in no year from 1 to 2999";
                return Err(Error::input(path, row.line, what, "correct the time stamp"));
            };
            let into_day_s = (at + ahead_s).rem_euclid(DAY_S) - ahead_s;
            let start_min = into_day_s as f64 / 60.0 - before_min + late_min;
            row.interval = Interval { date, start_min, end_min: start_min + step_min };
        }
        Ok(SteppedRows { rows, step_min, warning: missing.sentence(path, step) })
    }

    /// Returns the place of stamps that cannot be starts, and the seconds from them to this place:
    /// all at half a step are middles, all a minute or a second before a step are ends. `is_utc`
    /// says that the stamps are in UTC, where the hours of zones of half hours start at half past.
    pub fn place_by_clock(&self, path: &Path, is_utc: bool) -> Result<Option<(StampedAt, i64)>> {
        let step = self.step(path)?;
        let mut rests = self.seconds.iter().map(|at| (at - self.moved_s).rem_euclid(step));
        let Some(rest) = rests.next().filter(|first| rests.all(|rest| rest == *first)) else { return Ok(None) };
        let first_s = self.seconds.first().map_or(0, |at| (at - self.moved_s).rem_euclid(DAY_S));
        if is_utc && first_s != rest && HALF_HOUR_ZONES_S.contains(&((DAY_S - first_s + DAY_S / 2) % DAY_S - DAY_S / 2))
        {
            return Ok(None);
        }
        Ok(match step - rest {
            1 => Some((StampedAt::End, 1)),
            60 if step > 120 => Some((StampedAt::End, 60)),
            half if 2 * half == step => Some((StampedAt::Middle, 0)),
            _ => None,
        })
    }

    /// Gives the last hours of a month the year of its other hours. A typical year that was put
    /// together in UTC has the year of the next month there, in the file's own clock.
    fn join_months(&mut self, step: i64) {
        let back = self.back(step) + self.moved_s;
        let mut joined: Option<(i64, Date)> = None;
        for row in 1..self.seconds.len() {
            let [Some(before), Some(date)] = [row - 1, row].map(|row| date_of(self.seconds[row] - back)) else {
                return;
            };
            let apart = self.seconds[row] - self.seconds[row - 1];
            if joined.is_none_or(|(_, last)| (last.year, last.month) != (date.year, date.month)) {
                let moved = Date::new(before.year, date.month, date.day).filter(|_| before.year != date.year);
                let moved_s = moved.map(|moved| i64::from(moved.day_number() - date.day_number()) * DAY_S);
                // Within one day the clock goes on, and only the year jumps.
                joined = moved_s
                    .filter(|moved_s| before.month == date.month && apart != step && apart + moved_s == step)
                    .map(|moved_s| (moved_s, date));
            }
            if let Some((moved_s, _)) = joined {
                self.seconds[row] += moved_s;
            }
        }
    }

    /// Returns the seconds before its stamp at which a row counts to a day.
    fn back(&self, step: i64) -> i64 {
        if self.stamped_at == StampedAt::End && self.day_of_start { step } else { 0 }
    }

    /// Returns the most common time from row to row, seconds.
    pub fn step(&self, path: &Path) -> Result<i64> {
        let mut counts = BTreeMap::<i64, usize>::new();
        for (before, after) in self.seconds.iter().zip(self.seconds.iter().skip(1)) {
            *counts.entry(after - before).or_default() += 1;
        }
        // The smallest of equally common steps is taken.
        let most = counts.iter().filter(|(step, _)| **step > 0).max_by_key(|(step, count)| (**count, -**step));
        let line = self.rows.first().map(|row| row.line);
        let Some((&step, _)) = most else {
            let what = "has no two rows in order of time, so the step of its rows is unknown";
            return Err(Error::input(path, line, what, "give at least two rows, in order of time"));
        };
        if !STEPS_S.contains(&step) {
            let what = format!("rows are {} min apart", step as f64 / 60.0);
            return Err(Error::input(path, line, what, "give a series in steps of 1 minute to 1 hour"));
        }
        Ok(step)
    }

    /// Checks that rows follow each other, with gaps of whole steps. Where months of a typical year
    /// meet, years may jump.
    fn check_order(&self, path: &Path, step: i64) -> Result<Missing> {
        let mut missing = Missing::default();
        let pairs = self.seconds.iter().zip(self.seconds.iter().skip(1)).zip(self.rows.iter().skip(1));
        for ((&before, &after), row) in pairs {
            let apart = after - before;
            if apart == step {
                continue;
            }
            // The 24:00 that ends a month is stamped with the next month, in the year of the old
            // one.
            let back = self.back(step) + self.moved_s;
            if months_meet(before - back, after - back, step) {
                if self.moved_s != 0 {
                    let what = format!(
                        "is a typical year: line {} starts a month of another year, and days of another time zone \
                         would mix the two years",
                        row.line
                    );
                    return Err(Error::input(
                        path,
                        None,
                        what,
                        "leave {time_zone} out: days then follow the file's own time zone, such as UTC",
                    ));
                }
                continue;
            }
            if apart <= 0 {
                let what = match apart {
                    0 => format!("the row has the time stamp of the row before, {}", label(after)),
                    _ => format!("the row is stamped {}, before the row before it, {}", label(after), label(before)),
                };
                let hint = "put the rows in order, each once; a clock with daylight saving repeats an hour in autumn: write standard \
                            time, or an offset in every stamp, 2021-10-31T02:30+01:00";
                return Err(Error::input(path, row.line, what, hint));
            }
            if apart % step != 0 {
                let what = format!(
                    "the row is stamped {}, {} min after the row before, where steps are {} min",
                    label(after),
                    apart as f64 / 60.0,
                    step as f64 / 60.0
                );
                return Err(Error::input(
                    path,
                    row.line,
                    what,
                    "give rows at one step; rows may be missing, but not shifted",
                ));
            }
            missing.rows += apart / step - 1;
            missing.gaps += 1;
            missing.first.get_or_insert((row.line, before, after));
        }
        Ok(missing)
    }
}

impl Missing {
    fn sentence(&self, path: &Path, step: i64) -> Option<String> {
        let (line, before, after) = self.first?;
        let Missing { rows, gaps, .. } = self;
        let hours = (*rows * step) as f64 / 3600.0;
        Some(format!(
            "{}, line {line} and on: {rows} rows ({hours:.1} hours) are missing in {gaps} gap{}, the first between {} and {}; nothing is \
             filled in, sums lack them",
            path.display(),
            if *gaps == 1 { "" } else { "s" },
            label(before),
            label(after)
        ))
    }
}

/// Returns true if months of a typical year meet: the day of the second stamp follows that of the
/// first in another year, and the clock goes on.
fn months_meet(before: i64, after: i64, step: i64) -> bool {
    let goes_on = after.rem_euclid(DAY_S) + DAY_S - before.rem_euclid(DAY_S) == step;
    goes_on
        && date_of(before)
            .zip(date_of(after))
            .is_some_and(|(before, after)| before.month != after.month && before.is_followed_by(after))
}

fn date_of(seconds: i64) -> Option<Date> {
    Date::of_day_number(i32::try_from(seconds.div_euclid(DAY_S)).ok()?)
}

fn label(seconds: i64) -> String {
    let (date, minutes) = Date::OF_DAY_0.after(seconds as f64 / 60.0);
    date.label(minutes as u32)
}
