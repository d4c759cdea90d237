//! Reader of EnergyPlus weather files (EPW). In: a file's bytes. Out: [`Weather`], every row
//! checked, gaps reported.
//!
//! Format: Crawley, Hand and Lawrie, "Improving the weather information available to simulation
//! programs", Building Simulation 1999, and EnergyPlus, "Auxiliary programs", chapter "EnergyPlus
//! weather file (EPW) data dictionary". Rows carry the END of their interval: hour 1 of an hourly
//! file is 00:00 to 01:00 of standard time. Radiation from 9999 up or empty, GHI of -99, -999 or
//! -9999, albedo of 0 or above 1 and snow depth 999 mean missing; so do temperatures of 99.9,
//! opaque sky cover 99 and infrared radiation of 0, which no sky sends.

mod air;
mod header;
mod row;

use std::path::Path;

use air::read_air;
use header::EpwHeader;
use row::{DHI, YEAR, read_row};

use crate::judging::judged;
use crate::judging::raw_weather::{RawRow, RawWeather};
use crate::series::Weather;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::Message;
use heliotile_core::weather::air::Air;
use heliotile_core::weather::options::{StampedAt, WeatherOptions};
use heliotile_core::weather::time::calendar::Date;

/// Reads and checks the bytes of a weather file; messages call it `path`. The text need not be
/// UTF-8: only its numbers are used.
pub fn parse_epw(path: &Path, bytes: &[u8]) -> Result<Weather> {
    let options = WeatherOptions::default();
    judged(path, read(path, bytes, &options)?, &options, &mut || Ok(None))
}

/// Reads and checks the bytes of a weather file with the air of every row, from which longwave
/// irradiance is computed.
pub fn parse_epw_with_air(path: &Path, bytes: &[u8]) -> Result<Weather> {
    let options = WeatherOptions { with_air: true, ..WeatherOptions::default() };
    judged(path, read(path, bytes, &options)?, &options, &mut || Ok(None))
}

/// Returns true if a file is an EPW file by its first line or by its name.
pub(super) fn is_epw(path: &Path, bytes: &[u8]) -> bool {
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let named = path.to_string_lossy().to_lowercase();
    start.get(..8).is_some_and(|word| word.eq_ignore_ascii_case(b"LOCATION"))
        || named.strip_suffix(".gz").unwrap_or(&named).ends_with(".epw")
}

pub(super) fn read(path: &Path, bytes: &[u8], options: &WeatherOptions) -> Result<RawWeather> {
    let mut lines =
        bytes.split(|b| *b == b'\n').zip(1_usize..).map(|(line, number)| (String::from_utf8_lossy(line), number));
    let header = EpwHeader::read(path, &mut lines)?;
    let mut raw: Vec<RawRow> = Vec::new();
    let mut air: Vec<Air> = Vec::new();
    let mut columns = None;
    let mut gaps_left = header.periods.saturating_sub(1);
    let mut odd_minute = None;
    let mut no_year = 0_usize;
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
        no_year += usize::from(cells.get(YEAR).is_some_and(|year| year.parse() == Ok(0_u32)));
        let row = read_row(path, line, &cells, header.records_per_hour, &mut odd_minute)?;
        if let Some(before) = raw.last()
            && !before.is_followed_by(&row)
        {
            // Each further period that the header states may start after a gap.
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
        if options.with_air {
            air.push(read_air(path, line, &cells)?);
        }
    }
    if raw.is_empty() {
        let hint = "an EPW file has its rows after the line DATA PERIODS";
        return Err(Error::input(path, None, "the file has no weather rows", hint));
    }
    let ignored = odd_minute.map(|(line, minute)| {
        format!(
            "{}, line {line}: minute {minute} of an hourly row is ignored, the row holds the whole hour",
            path.display()
        )
    });
    let of_no_year = (no_year > 0).then(|| {
        format!("{}: {no_year} rows state the year 0 and are read as rows of {}", path.display(), Date::NO_YEAR)
    });
    Ok(RawWeather {
        station: header.station,
        rows: raw,
        air,
        step_min: 60.0 / f64::from(header.records_per_hour),
        stamped_at: StampedAt::End,
        zenith_deg: Vec::new(),
        warnings: ignored.into_iter().chain(of_no_year).map(Message::from).collect(),
    })
}

#[cfg(test)]
mod hard_tests;
#[cfg(test)]
mod tests;
