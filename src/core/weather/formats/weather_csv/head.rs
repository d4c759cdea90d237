//! What stands above the rows of a CSV file. In: its first lines. Out: names of columns, and what NSRDB and PVGIS say of the place.
//!
//! NSRDB (PSM3, PSM4; Sengupta and others, "The National Solar Radiation Data Base", 2018): a line of names and one of values, among them
//! Latitude, Longitude, Time Zone and Elevation, then the names of the columns. PVGIS (European Commission, JRC, versions 5.x): lines
//! `Latitude (decimal degrees): 45.000` and so on, the years of a typical year's months, names, rows in UTC, and a legend below them.

use std::path::Path;

use csv::{ReaderBuilder, Trim};

use crate::error::{Error, Result};
use crate::weather::judging::station::Station;

/// Whose layout a file has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Plain,
    Nsrdb,
    Pvgis,
}

/// What is known before the first row.
pub struct Head {
    pub kind: Kind,
    pub station: Station,
    pub delimiter: u8,
    /// Names of the columns as they stand there.
    pub names: Vec<String>,
    /// First cell of the first row.
    pub first_cell: String,
    /// Lines above the rows; the last is that of the names.
    pub lines: usize,
    /// Of the plane that PVGIS' irradiances are on.
    pub slope_deg: Option<f64>,
    /// How long after its stamp each row was.
    pub late_min: f64,
    /// Where the rows start, bytes.
    rows_at: usize,
}

/// Satellites pass within the hour of a time stamp.
const FARTHEST_OFFSET_HOURS: f64 = 1.0;

/// PVGIS has a dozen lines above the names, and 13 more in a typical year.
const MOST_HEAD_LINES: usize = 64;

/// Columns that only NSRDB has: files that lost the two lines above the names are told by them.
const ONLY_NSRDB: [&str; 2] = ["cloud type", "fill flag"];

impl Head {
    pub fn read(path: &Path, bytes: &[u8]) -> Result<Self> {
        let mut lines = Lines { bytes, at: if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 }, count: 0 };
        let mut head = Head {
            kind: Kind::Plain,
            station: Station {
                name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                latitude_deg: None,
                longitude_deg: None,
                zone_hours: None,
                zone_is_certain: false,
                elevation_m: 0.0,
            },
            delimiter: b',',
            names: Vec::new(),
            first_cell: String::new(),
            lines: 0,
            slope_deg: None,
            late_min: 0.0,
            rows_at: 0,
        };
        let Some(mut names) = lines.next() else {
            return Err(Error::input(
                path,
                None,
                "the file is empty",
                "give a weather file, EPW, TMY3, SURFRAD or CSV",
            ));
        };
        let lower = names.to_lowercase();
        if lower.starts_with("latitude (") {
            head.kind = Kind::Pvgis;
            names = head.pvgis(path, names, &mut lines)?;
        } else if ["latitude", "longitude", "time zone"].iter().all(|name| lower.contains(name)) {
            head.kind = Kind::Nsrdb;
            let values = lines.next().unwrap_or_default();
            head.nsrdb(path, &names, &values)?;
            names = lines.next().unwrap_or_default();
        }
        let of = |delimiter: &u8| names.bytes().filter(|byte| byte == delimiter).count();
        // The first of those that are equally frequent.
        head.delimiter = [b'\t', b';', b','].into_iter().max_by_key(of).unwrap_or(b',');
        head.names = split(&names, head.delimiter);
        if head.kind == Kind::Plain && head.names.iter().any(|name| ONLY_NSRDB.contains(&name.to_lowercase().as_str()))
        {
            head.kind = Kind::Nsrdb;
        }
        (head.lines, head.rows_at) = (lines.count, lines.at);
        let first = lines.next().unwrap_or_default();
        head.first_cell = split(&first, head.delimiter).into_iter().next().unwrap_or_default();
        Ok(head)
    }

    /// The bytes below the names.
    pub fn rows_of<'b>(&self, bytes: &'b [u8]) -> &'b [u8] {
        bytes.get(self.rows_at..).unwrap_or_default()
    }

    fn nsrdb(&mut self, path: &Path, names: &str, values: &str) -> Result<()> {
        let (names, values) = (split(names, b','), split(values, b','));
        let text = |wanted: &str| {
            let place = names.iter().position(|name| name.eq_ignore_ascii_case(wanted));
            place.and_then(|place| values.get(place)).map(String::as_str)
        };
        let number = |wanted: &str| {
            let text = text(wanted).unwrap_or_default();
            checked(path, 2, wanted, text).map(Some)
        };
        let station = &mut self.station;
        (station.latitude_deg, station.longitude_deg) = (number("Latitude")?, number("Longitude")?);
        station.zone_hours = number("Time Zone")?;
        if text("Elevation").is_some_and(|text| !text.is_empty()) {
            station.elevation_m = number("Elevation")?.unwrap_or_default();
        }
        let named: Vec<&str> = ["City", "State", "Country"].iter().filter_map(|name| text(name)).collect();
        let named: Vec<&str> = named.into_iter().filter(|name| !["", "-"].contains(name)).collect();
        if !named.is_empty() {
            station.name = named.join(", ");
        }
        Ok(())
    }

    /// Reads up to the line of names, and returns that.
    fn pvgis(&mut self, path: &Path, first: String, lines: &mut Lines) -> Result<String> {
        let mut line = first;
        loop {
            let lower = line.to_lowercase();
            if lower.starts_with("time") {
                return Ok(line);
            }
            let value = line.split_once(':').map(|(_, value)| value.trim()).unwrap_or_default();
            // `30 deg. (optimum)`
            let value = value.split_whitespace().next().unwrap_or_default();
            let number = |name: &str| checked(path, lines.count, name, value);
            if lower.starts_with("latitude") {
                self.station.latitude_deg = Some(number("Latitude")?);
            } else if lower.starts_with("longitude") {
                self.station.longitude_deg = Some(number("Longitude")?);
            } else if lower.starts_with("elevation") {
                self.station.elevation_m = number("Elevation")?;
            } else if lower.starts_with("irradiance time offset") {
                let hours = number("Irradiance Time Offset")?;
                if hours.abs() > FARTHEST_OFFSET_HOURS {
                    let what = format!("`Irradiance Time Offset` holds `{value}`, more than an hour");
                    let hint = "write the hours after the time stamp, -1 to 1, as in the file that was downloaded";
                    return Err(Error::input(path, lines.count, what, hint));
                }
                self.late_min = 60.0 * hours;
            } else if lower.starts_with("slope") {
                self.slope_deg = Some(number("Slope")?);
            }
            match lines.next() {
                Some(next) if lines.count <= MOST_HEAD_LINES => line = next,
                _ => {
                    let what = "no line of names that starts with `time`, as PVGIS writes it";
                    return Err(Error::input(
                        path,
                        lines.count,
                        what,
                        "fetch the file again as CSV, hourly data or typical year",
                    ));
                }
            }
        }
    }
}

fn checked(path: &Path, line: usize, name: &str, text: &str) -> Result<f64> {
    text.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| {
        Error::input(
            path,
            line,
            format!("`{name}` holds `{text}`"),
            "write a number, as in the file that was downloaded",
        )
    })
}

/// The cells of one line.
fn split(line: &str, delimiter: u8) -> Vec<String> {
    let mut reader =
        ReaderBuilder::new().has_headers(false).trim(Trim::All).delimiter(delimiter).from_reader(line.as_bytes());
    let record = reader.records().next().and_then(std::result::Result::ok).unwrap_or_default();
    record.iter().map(str::to_owned).collect()
}

/// Lines of a file that are not empty, one after the other.
struct Lines<'b> {
    bytes: &'b [u8],
    /// Where the next one starts.
    at: usize,
    /// Lines read, empty ones and comments too.
    count: usize,
}

impl Lines<'_> {
    /// The next line that says something.
    fn next(&mut self) -> Option<String> {
        loop {
            let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
            let end = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
            self.at += (end + 1).min(rest.len());
            self.count += 1;
            let line = String::from_utf8_lossy(rest.get(..end).unwrap_or_default());
            let line = line.trim_end_matches('\r');
            if !line.trim().is_empty() && !line.starts_with('#') {
                return Some(line.to_owned());
            }
        }
    }
}
