//! Reader of EnergyPlus weather files (EPW). In: a file's bytes. Out: [`Weather`], every row checked, gaps reported.
//!
//! Format: Crawley, Hand and Lawrie, "Improving the weather information available to simulation programs", Building
//! Simulation 1999, and EnergyPlus, "Auxiliary programs", chapter "EnergyPlus weather file (EPW) data dictionary". Rows carry
//! the END of their interval: hour 1 of an hourly file is 00:00 to 01:00 of standard time. Radiation from 9999 up or
//! empty, albedo of 0 or above 1 and snow depth 999 mean missing; so do temperatures of 99.9, opaque sky cover 99 and infrared
//! radiation of 0, which no sky sends.

mod air;
mod gaps;
pub(super) mod header;
pub(super) mod judge;
pub(super) mod row;

use std::path::Path;

pub(super) use air::AIR_C;
use air::read_air;
use header::Header;
use judge::judged;
use row::{DHI, RawRow};

use crate::error::{Error, Result};
use crate::weather::air::Air;
use crate::weather::series::Weather;

/// Reads and checks the bytes of a weather file; `path` is its name in messages. The text need not be UTF-8: only its numbers are used.
pub fn parse_epw(path: &Path, bytes: &[u8]) -> Result<Weather> {
    parse(path, bytes, false)
}

/// The same with the air of every row, which longwave irradiance is made of.
pub fn parse_epw_with_air(path: &Path, bytes: &[u8]) -> Result<Weather> {
    parse(path, bytes, true)
}

pub(super) fn parse(path: &Path, bytes: &[u8], with_air: bool) -> Result<Weather> {
    let mut lines =
        bytes.split(|b| *b == b'\n').zip(1_usize..).map(|(line, number)| (String::from_utf8_lossy(line), number));
    let header = Header::read(path, &mut lines)?;
    let mut raw: Vec<RawRow> = Vec::new();
    let mut air: Vec<Air> = Vec::new();
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
                let hint = "put the rows in order, without gaps, labelled with the end of their interval, or state the periods \
                            on the line DATA PERIODS";
                return Err(Error::input(path, line, what, hint));
            }
            gaps_left -= 1;
        }
        raw.push(row);
        if with_air {
            air.push(read_air(path, line, &cells)?);
        }
    }
    if raw.is_empty() {
        let hint = "an EPW file has its rows after the line DATA PERIODS";
        return Err(Error::input(path, None, "the file has no weather rows", hint));
    }
    let mut weather = judged(path, header, &raw, air)?;
    warn_of_part(path, &mut weather);
    if let Some((line, minute)) = odd_minute {
        weather.report.warnings.push(format!(
            "{}, line {line}: minute {minute} of an hourly row is ignored, the row holds the whole hour",
            path.display()
        ));
    }
    Ok(weather)
}

/// Says if a file is shorter than a year.
pub(super) fn warn_of_part(path: &Path, weather: &mut Weather) {
    let hours = weather.rows.len() as f64 * weather.interval_hours;
    if hours < HOURS_OF_YEAR {
        weather.report.warnings.push(format!(
            "{}: holds {hours:.0} of the {HOURS_OF_YEAR} hours of a year; yearly sums are sums of these",
            path.display()
        ));
    }
}

/// Hours of a year that is not a leap year.
const HOURS_OF_YEAR: f64 = 8760.0;

#[cfg(test)]
mod hard_tests;
#[cfg(test)]
mod tests;
