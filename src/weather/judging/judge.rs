//! Checks of a weather file. In: rows from a reader. Out: [`Weather`] without gaps, with warnings.

use std::path::Path;

use rayon::prelude::*;

use crate::closure::Closure;
use crate::findings::{DARK_GHI_W_M2, Finding};
use crate::judging::gaps::{Filled, fill};
use crate::judging::raw_weather::{RawRow, RawWeather};
use crate::judging::station::ScenePlace;
use crate::judging::sums::{drop_empty_columns, drop_horizontal_dni, month_warning};
use crate::judging::zenith::place_by_zenith;
use crate::series::{Weather, WeatherReport};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::{Message, message};
use heliotile_core::weather::options::{TimeShift, WeatherOptions};
use heliotile_core::weather::row::WeatherRow;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::clock_zone::ClockZone;
use heliotile_core::weather::time::sun::{Interval, Location, extraterrestrial_w_m2};

/// Largest difference between a clock and the sun, hours. No place on Earth has more; the west of
/// China comes close, with 2.9 h.
const FARTHEST_CLOCK_HOURS: f64 = 3.0;

/// Largest DHI / GHI with the sun above 3 deg and GHI above 50 W/m2. Long and Dutton, "BSRN Global
/// Network recommended QC tests, V2.0", 2002: it stays below 1.10.
const LARGEST_DIFFUSE_RATIO: f64 = 1.10;
/// Least DHI to which the ratio applies, W/m2.
const SMALLEST_JUDGED_DHI_W_M2: f64 = 50.0;

/// Largest irradiance that looks like kW/m2, W/m2: a day of rain gives ten times as much.
const FAINT_W_M2: f64 = 2.0;
/// Least number of rows with a high sun whose largest irradiance says something.
const FAINT_ROWS: usize = 100;

/// Sine of the sun's altitude at the end of civil twilight, -6 degrees. Below it the sky sends less
/// than 0.05 W/m2.
const NIGHT_SINE: f64 = -0.104_528;

/// Hours of a year that is not a leap year.
const HOURS_OF_YEAR: f64 = 8760.0;

/// Rows without gaps, each with its findings.
type Judged = Vec<(WeatherRow, Vec<Finding>)>;

/// Moves time stamps by the user's shift and fills gaps, then checks the rows and the file as a
/// whole.
pub fn judged(path: &Path, raw: RawWeather, options: &WeatherOptions, scene: ScenePlace) -> Result<Weather> {
    let RawWeather { station, mut rows, air, step_min, stamped_at, zenith_deg, mut warnings } = raw;
    let year = rows.first().map_or(Date::NO_YEAR, |row| row.interval.date.year);
    let (site, note) = station.location(path, options, year, scene)?;
    let mut report = WeatherReport::default();
    report.warnings.extend(note.into_iter().map(Message::from));
    let by_zenith = place_by_zenith(&rows, &zenith_deg, &site, stamped_at);
    if let Some(at) = by_zenith {
        warnings.push(message!(
            "{}: the column of the sun's zenith shows that time stamps are the {} of their intervals: they are read so; \
             {{weather_stamp}} states another place",
            path.display(),
            at.name()
        ));
    }
    let asked = options.stamped_at.or(by_zenith).unwrap_or(stamped_at);
    let mut moved_min = match options.shift {
        TimeShift::Minutes(minutes) => minutes,
        TimeShift::Auto => 0.0,
    };
    shift(&mut rows, moved_min + (stamped_at.share_before() - asked.share_before()) * step_min);
    warnings.extend(drop_empty_columns(path, &mut rows, &site).into_iter().map(Message::from));
    warnings.extend(drop_horizontal_dni(path, &mut rows, &site).into_iter().map(Message::from));
    let mut done = all_judged(&rows, &site);
    report.closure = closure(&site, &rows, &done);
    if let (TimeShift::Auto, Some(before)) = (options.shift, report.closure)
        && let Some(found_min) = before.better_shift_min()
    {
        moved_min = found_min;
        shift(&mut rows, moved_min);
        done = all_judged(&rows, &site);
        report.closure = closure(&site, &rows, &done);
        let after = report.closure.map_or(before.best_rmse_w_m2, |closure| closure.rmse_w_m2);
        report.warnings.push(message!(
            "{}: {{shift}} auto moves time stamps by {moved_min} min: GHI = DHI + DNI cos(z) then holds to \
             {after:.1} W/m2 RMSE, before to {:.1}",
            path.display(),
            before.rmse_w_m2
        ));
    }
    for (row, findings) in &mut done {
        for kind in findings.iter() {
            let w_m2 = if *kind == Finding::NightOffset { row.dhi_w_m2 } else { row.dni_w_m2 };
            report.findings.add(*kind, row.line, row.interval.hours(), w_m2);
        }
        if findings.contains(&Finding::NightOffset) {
            row.dhi_w_m2 = 0.0;
        }
    }
    for (raw, air) in rows.iter().zip(&air) {
        if air.infrared_w_m2.is_none() && air.sky_w_m2().is_some() {
            report.findings.add(Finding::ComputedInfrared, raw.line, raw.interval.hours(), 0.0);
        }
    }
    let lost = report.findings.of(Finding::Zeroed);
    if lost.rows > 0 && done.iter().all(|(row, _)| row.dni_w_m2 == 0.0 && row.dhi_w_m2 == 0.0) {
        let what = format!("no row holds light; DNI or DHI of {} hours is missing, and so is GHI", lost.tidy_hours());
        return Err(Error::input(path, lost.first_line, what, "give a weather file with solar radiation")
            .because(Problem::Lacks("light")));
    }
    let ahead = site.hours_ahead_of_clock();
    // No warning is needed with a shift, because the user knows that the clock is wrong; if the
    // user states UTC; or if the light fits the sun.
    let says_utc = options.zone == Some(ClockZone::Hours(0.0));
    let is_known = moved_min != 0.0 || station.zone_is_certain || says_utc;
    let fits = report.closure.is_some_and(|closure| closure.holds());
    if ahead.abs() > FARTHEST_CLOCK_HOURS && !is_known && !fits {
        let Location { longitude_deg, zone_hours, .. } = site;
        report.warnings.push(format!(
            "{}, line 1: longitude {longitude_deg} and time zone {zone_hours} are {:.1} h apart; east is positive in both",
            path.display(),
            ahead.abs()
        ).into());
    }
    if let Some(largest_w_m2) = faint_day(&done) {
        report.warnings.push(format!(
            "{}: the largest irradiance of all rows is {largest_w_m2:.2} W/m2: if the file holds kW/m2, name the unit in \
             its columns, as in `ghi (kW/m2)`",
            path.display()
        ).into());
    }
    for (line, sentence) in report.findings.sentences() {
        report.warnings.push(message!("{}, line {line} and on: ", path.display()).and(sentence));
    }
    match report.closure.and_then(|c| c.warning(&site, moved_min, station.zone_is_certain)) {
        Some(sentence) => report.warnings.push(message!("{}: ", path.display()).and(sentence)),
        None => {
            let of_rows: Vec<&WeatherRow> = done.iter().map(|(row, _)| row).collect();
            report.warnings.extend(month_warning(path, &rows, &of_rows).into_iter().map(Message::from));
        }
    }
    let hours = rows.len() as f64 * step_min / 60.0;
    if hours < HOURS_OF_YEAR {
        report.warnings.push(
            format!(
                "{}: holds {hours:.0} of the {HOURS_OF_YEAR} hours of a year; yearly sums cover only these hours",
                path.display()
            )
            .into(),
        );
    }
    report.warnings.extend(warnings);
    Ok(Weather {
        place: station.name,
        site,
        rows: done.into_iter().map(|(row, _)| row).collect(),
        air,
        interval_hours: step_min / 60.0,
        moved_min,
        report,
    })
}

/// Moves intervals; each stays with the day that the file counts it to.
fn shift(rows: &mut [RawRow], minutes: f64) {
    for row in rows {
        row.interval.start_min += minutes;
        row.interval.end_min += minutes;
    }
}

/// Returns the largest irradiance of the rows if it is below [`FAINT_W_M2`] and there are
/// [`FAINT_ROWS`] rows or more with a high sun.
fn faint_day(done: &Judged) -> Option<f64> {
    let lit = done.iter().filter(|(row, _)| row.sun.z > 0.3).count();
    let of = |row: &WeatherRow| row.ghi_w_m2.unwrap_or_default().max(row.dni_w_m2).max(row.dhi_w_m2);
    let largest_w_m2 = done.iter().map(|(row, _)| of(row)).fold(0.0, f64::max);
    (lit >= FAINT_ROWS && largest_w_m2 > 0.0 && largest_w_m2 < FAINT_W_M2).then_some(largest_w_m2)
}

fn all_judged(raw: &[RawRow], site: &Location) -> Judged {
    raw.par_iter().map(|raw| judged_row(raw, site)).collect()
}

/// Checks the closure over rows for which nothing was filled in.
fn closure(site: &Location, raw: &[RawRow], done: &Judged) -> Option<Closure> {
    let given = done.iter().zip(raw).filter(|(_, raw)| raw.dni.is_some() && raw.dhi.is_some());
    Closure::new(site, given.map(|((row, _), _)| row))
}

/// Returns a row without gaps, and its findings. A gap at night is no finding, because nothing is
/// lost there.
fn judged_row(raw: &RawRow, site: &Location) -> (WeatherRow, Vec<Finding>) {
    let sun = site.sun(raw.interval.date, raw.interval.middle_min());
    let Filled { dni_w_m2, dhi_w_m2, gap } = fill(raw, site, sun);
    let row = WeatherRow {
        line: raw.line,
        interval: raw.interval,
        sun,
        ghi_w_m2: raw.ghi,
        dni_w_m2,
        dhi_w_m2,
        albedo: raw.albedo,
        snow_depth_cm: raw.snow_depth_cm,
    };
    let mut findings = Vec::new();
    if raw.negative {
        findings.push(Finding::Negative);
    }
    if gap.is_some() || dni_w_m2 > 0.0 {
        let lit_hours = site.sunlit_hours(&raw.interval, sun.into());
        if lit_hours > 0.0 {
            findings.extend(gap);
        }
        if dni_w_m2 > 0.0 && lit_hours == 0.0 {
            findings.push(Finding::BelowHorizon);
        } else if dni_w_m2 * raw.interval.hours() > lit_hours * extraterrestrial_w_m2(raw.interval.date) {
            findings.push(Finding::AboveExtraterrestrial);
        }
    }
    if dhi_w_m2 > 0.0 && dhi_w_m2 <= DARK_GHI_W_M2 && is_night(&raw.interval, site, sun.z) {
        findings.push(Finding::NightOffset);
    }
    // Where the file states DNI too, the closure finds a wrong clock.
    if raw.dni.is_none()
        && raw.ghi.is_some_and(|ghi| ghi > DARK_GHI_W_M2)
        && site.sunlit_hours(&raw.interval, sun.into()) == 0.0
    {
        findings.push(Finding::GhiBelowHorizon);
    }
    // Only values of the file are compared: computed ones fit by construction.
    if let (Some(ghi), Some(dhi)) = (raw.ghi, raw.dhi)
        && dhi > SMALLEST_JUDGED_DHI_W_M2
        && dhi > LARGEST_DIFFUSE_RATIO * ghi
    {
        findings.push(Finding::DhiAboveGhi);
    }
    (row, findings)
}

/// Returns true if the sun stays below [`NIGHT_SINE`] in an interval, at whose middle its sine is
/// `middle_z`.
fn is_night(interval: &Interval, site: &Location, middle_z: f64) -> bool {
    let below = |minutes: f64| site.sun(interval.date, minutes).z < NIGHT_SINE;
    middle_z < NIGHT_SINE && below(interval.start_min) && below(interval.end_min)
}
