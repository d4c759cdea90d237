//! Reader of EnergyPlus weather files (EPW). In: a file's bytes. Out: [`Weather`], every row checked, gaps reported.
//!
//! Format: Crawley, Hand and Lawrie, "Improving the weather information available to simulation programs", Building
//! Simulation 1999, and EnergyPlus, "Auxiliary programs", chapter "EnergyPlus weather file (EPW) data dictionary". Rows carry
//! the END of their interval: hour 1 of an hourly file is 00:00 to 01:00 of standard time. Radiation from 9999 up, albedo
//! 999 and snow depth 999 mean missing.

mod header;
mod row;

use std::path::Path;

use rayon::prelude::*;

use header::Header;
use row::{DHI, Fill, RawRow};

use super::closure::Closure;
use super::weather::{Report, Row, Weather};
use crate::error::{Error, Result};
use crate::units::kwh_from_w;

/// Reads and checks a weather file. The text need not be UTF-8: only its numbers are used.
pub fn read_epw(path: &Path) -> Result<Weather> {
    let bytes = std::fs::read(path).map_err(Error::io(path, "read"))?;
    parse(path, &bytes)
}

fn parse(path: &Path, bytes: &[u8]) -> Result<Weather> {
    let mut lines =
        bytes.split(|b| *b == b'\n').zip(1_usize..).map(|(line, number)| (String::from_utf8_lossy(line), number));
    let header = Header::read(path, &mut lines)?;
    let mut raw: Vec<RawRow> = Vec::new();
    let mut columns = None;
    let mut gaps_left = header.periods.saturating_sub(1);
    let mut odd_minute = None;
    for (text, line) in lines {
        let text = text.trim();
        if text.is_empty() {
            continue;
        }
        let cells: Vec<&str> = text.split(',').map(str::trim).collect();
        if cells.len() <= DHI || *columns.get_or_insert(cells.len()) != cells.len() {
            let expected = columns.filter(|c| *c > DHI).unwrap_or(35);
            let what = format!("the row has {} columns instead of {expected}", cells.len());
            return Err(Error::input(path, line, what, "the file may be cut off; fetch it again"));
        }
        let row = RawRow::read(path, line, &cells, header.records_per_hour, &mut odd_minute)?;
        if let Some(before) = raw.last()
            && !before.is_followed_by(&row)
        {
            if gaps_left == 0 {
                let what = format!(
                    "the row starts at {}, the row before does not end there: steps of {} min are expected",
                    row.interval.date.label(row.interval.start_min as u32),
                    60 / header.records_per_hour
                );
                let hint = "put the rows in order, without gaps, or state the periods on the line DATA PERIODS";
                return Err(Error::input(path, line, what, hint));
            }
            gaps_left -= 1;
        }
        raw.push(row);
    }
    if raw.is_empty() {
        let hint = "an EPW file has its rows after the line DATA PERIODS";
        return Err(Error::input(path, None, "the file has no weather rows", hint));
    }
    let mut weather = filled(path, header, &raw);
    let hours = raw.len() as f64 * weather.interval_hours;
    if hours < HOURS_OF_YEAR {
        weather.report.warnings.push(format!(
            "{}: holds {hours:.0} of the {HOURS_OF_YEAR} hours of a year; yearly sums are sums of these",
            path.display()
        ));
    }
    if let Some((line, minute)) = odd_minute {
        weather.report.warnings.push(format!(
            "{}, line {line}: minute {minute} of an hourly row is ignored, the row holds the whole hour",
            path.display()
        ));
    }
    Ok(weather)
}

/// Hours of a year that is not a leap year.
const HOURS_OF_YEAR: f64 = 8760.0;

/// Fills what is missing, then judges the file as a whole.
fn filled(path: &Path, header: Header, raw: &[RawRow]) -> Weather {
    let site = header.site;
    let done: Vec<(Row, Fill, bool)> = raw
        .par_iter()
        .map(|raw| {
            let sun = site.sun(raw.interval.date, raw.interval.middle_min());
            let (dni_w_m2, dhi_w_m2, fill) = raw.fill(&site, sun);
            let lost = dni_w_m2 > 0.0 && site.sunlit(&raw.interval, sun, 1).is_empty();
            let row = Row {
                line: raw.line,
                interval: raw.interval,
                sun,
                ghi_w_m2: raw.ghi,
                dni_w_m2,
                dhi_w_m2,
                albedo: raw.albedo,
                snow_depth_cm: raw.snow_depth_cm,
            };
            (row, fill, lost)
        })
        .collect();
    let mut report = Report::default();
    let complete: Vec<Row> = done.iter().filter(|(_, fill, _)| *fill == Fill::Nothing).map(|(row, ..)| *row).collect();
    report.closure = Closure::of(&site, &complete);
    let (mut first_filled, mut first_zeroed, mut first_lost) = (0, 0, 0);
    for (row, fill, lost) in done.iter().rev() {
        match fill {
            Fill::Nothing => {}
            Fill::Reconstructed => {
                report.reconstructed_rows += 1;
                first_filled = row.line;
            }
            Fill::Zeroed => {
                report.zeroed_rows += 1;
                first_zeroed = row.line;
            }
        }
        if *lost {
            let hours = row.interval.hours();
            report.dni_below_horizon_hours += hours;
            report.dni_below_horizon_kwh_m2 += kwh_from_w(row.dni_w_m2, hours);
            first_lost = row.line;
        }
    }
    let mut warn = |first: usize, sentence: String| {
        if first > 0 {
            let path = path.display();
            report.warnings.push(format!("{path}, line {first} and on: {sentence}"));
        }
    };
    let (n, m) = (report.reconstructed_rows, report.zeroed_rows);
    warn(first_filled, format!("missing DNI or DHI of {n} rows computed from GHI = DHI + DNI cos(z)"));
    warn(first_zeroed, format!("missing DNI or DHI of {m} rows set to 0"));
    let (hours, energy) = (report.dni_below_horizon_hours, report.dni_below_horizon_kwh_m2);
    warn(first_lost, format!("DNI with the sun below the horizon in {hours} hours, {energy:.3} kWh/m2, is left out"));
    if let Some(sentence) = report.closure.and_then(|c| c.warning()) {
        report.warnings.push(format!("{}: {sentence}", path.display()));
    }
    Weather {
        place: header.place,
        site,
        rows: done.into_iter().map(|(row, ..)| row).collect(),
        interval_hours: 1.0 / f64::from(header.records_per_hour),
        report,
    }
}

#[cfg(test)]
mod tests;
