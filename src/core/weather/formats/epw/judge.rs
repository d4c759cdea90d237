//! What to think of a weather file. In: rows as they stand there. Out: [`Weather`] without gaps, with warnings.

use std::path::Path;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::weather::air::Air;
use crate::weather::closure::Closure;
use crate::weather::findings::Finding;
use crate::weather::formats::epw::gaps::{Filled, fill};
use crate::weather::formats::epw::header::EpwHeader;
use crate::weather::formats::epw::row::RawRow;
use crate::weather::row::WeatherRow;
use crate::weather::series::{Weather, WeatherReport};
use crate::weather::time::sun::{Location, extraterrestrial_w_m2};

/// Clocks are further than this from the sun nowhere on Earth; the west of China comes close, with 2.9 h.
const FARTHEST_CLOCK_HOURS: f64 = 3.0;

/// Long and Dutton, "BSRN Global Network recommended QC tests, V2.0", 2002: with the sun above 3 deg and GHI above 50 W/m2,
/// DHI / GHI stays below 1.10.
const LARGEST_DIFFUSE_RATIO: f64 = 1.10;
const SMALLEST_JUDGED_DHI_W_M2: f64 = 50.0;

/// Fills what is missing, then judges the rows and the file as a whole. `air` of the rows, if it is asked for.
pub fn judged(path: &Path, header: EpwHeader, raw: &[RawRow], air: Vec<Air>) -> Result<Weather> {
    let site = header.site;
    let done: Vec<(WeatherRow, Vec<Finding>)> = raw.par_iter().map(|raw| judged_row(raw, &site)).collect();
    let mut report = WeatherReport::default();
    for (row, findings) in &done {
        for kind in findings {
            report.findings.add(*kind, row.line, row.interval.hours(), row.dni_w_m2);
        }
    }
    for (raw, air) in raw.iter().zip(&air) {
        if air.infrared_w_m2.is_none() && air.sky_w_m2().is_some() {
            report.findings.add(Finding::ComputedInfrared, raw.line, raw.interval.hours(), 0.0);
        }
    }
    let lost = report.findings.of(Finding::Zeroed);
    if lost.rows > 0 && done.iter().all(|(row, _)| row.dni_w_m2 == 0.0 && row.dhi_w_m2 == 0.0) {
        let what = format!("no row holds light; DNI or DHI of {} hours is missing, and so is GHI", lost.hours);
        return Err(Error::input(path, lost.first_line, what, "give a weather file with solar radiation"));
    }
    let complete: Vec<WeatherRow> = done
        .iter()
        .zip(raw)
        .filter(|(_, raw)| raw.dni.is_some() && raw.dhi.is_some())
        .map(|((row, _), _)| *row)
        .collect();
    report.closure = Closure::of(&site, &complete);
    let ahead = site.hours_ahead_of_clock();
    if ahead.abs() > FARTHEST_CLOCK_HOURS {
        let Location { longitude_deg, zone_hours, .. } = site;
        report.warnings.push(format!(
            "{}, line 1: longitude {longitude_deg} and time zone {zone_hours} are {:.1} h apart; east is positive in both",
            path.display(),
            ahead.abs()
        ));
    }
    for (line, sentence) in report.findings.sentences() {
        report.warnings.push(format!("{}, line {line} and on: {sentence}", path.display()));
    }
    if let Some(sentence) = report.closure.and_then(|c| c.warning(&site)) {
        report.warnings.push(format!("{}: {sentence}", path.display()));
    }
    Ok(Weather {
        place: header.place,
        site,
        rows: done.into_iter().map(|(row, _)| row).collect(),
        air,
        interval_hours: 1.0 / f64::from(header.records_per_hour),
        report,
    })
}

/// A row without gaps, and what is odd about it. Gaps of the night are not: nothing is lost there.
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
        let lit_hours = site.sunlit_hours(&raw.interval, sun);
        if lit_hours > 0.0 {
            findings.extend(gap);
        }
        if dni_w_m2 > 0.0 && lit_hours == 0.0 {
            findings.push(Finding::BelowHorizon);
        } else if dni_w_m2 * raw.interval.hours() > lit_hours * extraterrestrial_w_m2(raw.interval.date) {
            findings.push(Finding::AboveExtraterrestrial);
        }
    }
    if let (Some(ghi), Some(dhi)) = (raw.ghi, raw.dhi)
        && dhi > SMALLEST_JUDGED_DHI_W_M2
        && dhi > LARGEST_DIFFUSE_RATIO * ghi
    {
        findings.push(Finding::DhiAboveGhi);
    }
    (row, findings)
}
