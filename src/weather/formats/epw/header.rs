//! Header of a weather file: the place of the station and the spacing of the rows. In: the first
//! lines. Out: a checked header.

use std::borrow::Cow;
use std::path::Path;

use crate::judging::station::Station;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::excerpt;
use heliotile_core::weather::time::sun::Location;

/// Data of the header lines.
pub struct EpwHeader {
    pub station: Station,
    pub periods: u32,
    pub records_per_hour: u32,
}

impl EpwHeader {
    /// Reads the lines up to and including DATA PERIODS.
    pub fn read<'a>(path: &Path, lines: &mut impl Iterator<Item = (Cow<'a, str>, usize)>) -> Result<Self> {
        let first = lines.next().map(|(text, _)| text).unwrap_or_default();
        let cells: Vec<&str> = first.trim_start_matches('\u{feff}').split(',').map(str::trim).collect();
        if !cells.first().is_some_and(|c| c.eq_ignore_ascii_case("LOCATION")) {
            let hint = "give an EnergyPlus weather file (.epw) or a TMY3 file (.csv)";
            return Err(Error::input(path, 1, "the file does not start with LOCATION", hint));
        }
        let hint = "write LOCATION,city,state,country,source,WMO,latitude,longitude,time zone,elevation";
        let mut numbers = [0.0; 4];
        let names = ["latitude", "longitude", "time zone", "elevation"];
        for (i, (number, name)) in numbers.iter_mut().zip(names).enumerate() {
            let text = cells.get(6 + i).copied().unwrap_or_default();
            // Programs that change the climate of a file write words behind the elevation, which
            // EnergyPlus ignores.
            let word = text.split_whitespace().next().unwrap_or_default();
            let bad = |_| Error::input(path, 1, format!("{name} of LOCATION holds `{}`", excerpt(text, 60)), hint);
            *number = word.parse().map_err(bad)?;
        }
        let [latitude, longitude, zone, elevation] = numbers;
        let site =
            Location::new(latitude, longitude, zone, elevation).map_err(|what| Error::input(path, 1, what, hint))?;
        let cell = |i: usize| cells.get(i).copied().unwrap_or_default();
        let station = Station::known(format!("{}, {}", cell(1), cell(3)), site);
        for (text, line) in lines {
            let cells: Vec<&str> = text.split(',').map(str::trim).collect();
            if !cells.first().is_some_and(|c| c.eq_ignore_ascii_case("DATA PERIODS")) {
                continue;
            }
            let number = |i: usize| cells.get(i).and_then(|c| c.parse::<u32>().ok());
            let (Some(periods), Some(records_per_hour)) = (number(1), number(2)) else {
                let hint = "write DATA PERIODS,number of periods,records per hour,...";
                return Err(Error::input(path, line, "DATA PERIODS lacks its two numbers", hint));
            };
            if records_per_hour == 0 || 60 % records_per_hour != 0 {
                return Err(Error::Unsupported {
                    what: format!("{}, line {line}: records per hour", path.display()).into(),
                    found: records_per_hour.to_string(),
                    supported: "the divisors of 60: 1, 2, 3, 4, 5, 6, 10, 12, 15, 20, 30, 60".into(),
                });
            }
            return Ok(EpwHeader { station, periods, records_per_hour });
        }
        let hint = "an EPW file has eight header lines, the last is DATA PERIODS";
        Err(Error::input(path, None, "the line DATA PERIODS is missing", hint))
    }
}
