//! Layouts of tables. In: the lines above the names of a table. Out: its kind, place, clock, units
//! and the place of a stamp in its interval.
//!
//! - NSRDB (PSM3, PSM4; Sengupta and others, "The National Solar Radiation Data Base", 2018) and
//!   SAM CSV (NREL, "SAM CSV format for solar"): a line of names and one of values, among them
//!   Latitude, Longitude, Time Zone and Elevation. Without a column of minutes SAM takes the middle
//!   of each hour.
//! - Open-Meteo: a line of names and one of values with `utc_offset_seconds`; radiation is the mean
//!   of the preceding interval, `_instant` the value at its stamp.
//! - NASA POWER (hourly API): `-BEGIN HEADER-`, UTC or local solar time in zones of 15 degrees;
//!   stamps of the start.
//! - Solargis ("Data format"): lines with `#`; stamps of the middle, -9 is missing.
//! - PVsyst standard format: `#Tag;value`; stamps of the start.
//! - CAMS radiation service: `# Tag: value`; Wh/m2 between two moments that each row states.
//! - SolarAnywhere ("File formats"): the first line of TMY3, with `Averaging Method` at its end.
//! - Any other: lines such as `Latitude: 45` or `# Time zone; 1`.

use std::path::Path;

use crate::formats::weather_csv::head::{Head, HeadLine, Kind, checked, split};
use crate::formats::weather_csv::names::squash;
use crate::formats::weather_csv::units::{Measure, parse_unit};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::{excerpt, message};
use heliotile_core::weather::options::StampedAt;
use heliotile_core::weather::time::utc_offset::parse_zone;

/// Largest time offset, hours: satellites pass within the hour of a time stamp.
const FARTHEST_OFFSET_HOURS: f64 = 1.0;

/// Columns that only NSRDB has. They identify files that lost the two lines above the names.
const ONLY_NSRDB: [&str; 2] = ["cloud type", "fill flag"];

/// Columns that only Open-Meteo has. They identify files that lost the lines above the names.
const ONLY_OPEN_METEO: [&str; 2] = ["shortwave_radiation", "diffuse_radiation"];

impl Head {
    /// Reads the layout, place and clock from the lines above the names.
    pub(super) fn take_layout(&mut self, path: &Path, above: &[HeadLine]) -> Result<()> {
        let all = above.iter().map(|line| line.text.to_lowercase()).collect::<Vec<String>>().join("\n");
        let first = above.first().map(|line| line.text.to_lowercase()).unwrap_or_default();
        let named = |wanted: &str| self.names.iter().any(|name| squash(name).starts_with(wanted));
        self.kind = match () {
            () if first.starts_with("latitude (") => Kind::Pvgis,
            () if first.contains("utc_offset_seconds") => Kind::OpenMeteo,
            () if is_two_line_head(&first) => Kind::Nsrdb,
            () if all.contains("-begin header-") || all.contains("nasa/power") => Kind::NasaPower,
            () if all.contains("solargis") => Kind::Solargis,
            () if all.contains("pvsyst")
                || ["#meteo hourly", "#tmy hourly", "#weather data hourly"]
                    .iter()
                    .any(|tag| first.starts_with(tag)) =>
            {
                Kind::Pvsyst
            }
            () if named("observationperiod") => Kind::Cams,
            () if named("observationtime") && !first.is_empty() || first.contains("averaging method") => {
                Kind::SolarAnywhere
            }
            () if first.trim_start_matches('"').starts_with("toa5") => Kind::Datalogger,
            () if all.contains("meteonorm") => Kind::Meteonorm,
            () => Kind::Plain,
        };
        match self.kind {
            Kind::Pvgis => self.pvgis(path, above)?,
            Kind::Nsrdb | Kind::OpenMeteo => self.two_lines(path, above)?,
            Kind::SolarAnywhere => self.solar_anywhere(path, above)?,
            _ => {
                for line in above {
                    self.tagged(path, line)?;
                }
            }
        }
        if self.kind == Kind::Plain {
            self.known_by_names(path);
        }
        match self.kind {
            Kind::NasaPower => self.nasa_zone(&all),
            Kind::Solargis => self.solargis(&all),
            // Radiation in universal time, or in true solar time, which no clock shows.
            Kind::Cams if all.contains("true solar time") || all.contains("(tst)") => {
                let what = "its times are in true solar time, which has no time zone";
                return Err(Error::input(path, None, what, "fetch it again in universal time (UT)"));
            }
            Kind::Cams => self.say_zone(0.0),
            _ => {}
        }
        self.units_above(above);
        Ok(())
    }

    fn known_by_names(&mut self, path: &Path) {
        let has = |known: &[&str]| self.names.iter().any(|name| known.contains(&name.to_lowercase().as_str()));
        if has(&ONLY_NSRDB) {
            self.kind = Kind::Nsrdb;
        } else if self.names.iter().any(|name| {
            let name = name.to_lowercase();
            ONLY_OPEN_METEO.iter().any(|known| name.starts_with(known))
        }) {
            self.kind = Kind::OpenMeteo;
            self.warnings.push(message!(
                "{}: has the column names of Open-Meteo, whose radiation is a mean over the time before each stamp: \
                 stamps are read as the end of intervals; {{weather_stamp}} states another place",
                path.display()
            ));
        }
    }

    /// Reads a line of names and one of values.
    fn two_lines(&mut self, path: &Path, above: &[HeadLine]) -> Result<()> {
        let [names, values, more @ ..] = above else { return Ok(()) };
        if self.kind == Kind::OpenMeteo && !more.is_empty() {
            let what = "the file holds several places, one a line";
            return Err(Error::input(path, more[0].line, what, "ask Open-Meteo for one place a file"));
        }
        let delimiter = if names.text.contains(';') && !names.text.contains(',') { b';' } else { b',' };
        let (names, cells) = (split(&names.text, delimiter), split(&values.text, delimiter));
        let text = |wanted: &[&str]| {
            let place = names.iter().position(|name| wanted.contains(&squash(name).as_str()));
            place.and_then(|place| cells.get(place)).map(String::as_str)
        };
        let number =
            |name: &str, wanted: &[&str]| checked(path, values.line, name, text(wanted).unwrap_or_default()).map(Some);
        let station = &mut self.station;
        station.latitude_deg = number("Latitude", &["latitude", "lat"])?;
        station.longitude_deg = number("Longitude", &["longitude", "lon", "lng", "long"])?;
        let elevation = ["elevation", "elev", "siteelevation"];
        if text(&elevation).is_some_and(|text| !text.is_empty() && !text.eq_ignore_ascii_case("nan")) {
            station.elevation_m = number("Elevation", &elevation)?.unwrap_or_default();
        }
        if self.kind == Kind::OpenMeteo {
            let seconds = number("utc_offset_seconds", &["utcoffsetseconds"])?;
            (station.zone_hours, station.zone_is_certain) = (seconds.map(|seconds| seconds / 3600.0), true);
            return Ok(());
        }
        let zone = ["timezone", "tz"];
        // A blank zone must be given by the user.
        if text(&zone).is_some_and(|text| !["", "-"].contains(&text)) {
            station.zone_hours = number("Time Zone", &zone)?;
        }
        // NSRDB states two zones where its times are in UTC.
        station.zone_is_certain = station.zone_hours == Some(0.0)
            && text(&["localtimezone"]).and_then(|text| text.parse::<f64>().ok()).is_some_and(|local| local != 0.0);
        let named: Vec<&str> = ["city", "state", "country"].iter().filter_map(|name| text(&[name])).collect();
        let named: Vec<&str> = named.into_iter().filter(|name| !["", "-"].contains(name)).collect();
        if !named.is_empty() {
            station.name = named.join(", ");
        }
        Ok(())
    }

    /// Reads the lines above the names of PVGIS.
    fn pvgis(&mut self, path: &Path, above: &[HeadLine]) -> Result<()> {
        for HeadLine { line, text } in above {
            let lower = text.to_lowercase();
            let value = text.split_once(':').map(|(_, value)| value.trim()).unwrap_or_default();
            // `30 deg. (optimum)`
            let value = value.split_whitespace().next().unwrap_or_default();
            let number = |name: &str| checked(path, *line, name, value);
            if lower.starts_with("latitude") {
                self.station.latitude_deg = Some(number("Latitude")?);
            } else if lower.starts_with("longitude") {
                self.station.longitude_deg = Some(number("Longitude")?);
            } else if lower.starts_with("elevation") {
                self.station.elevation_m = number("Elevation")?;
            } else if lower.starts_with("irradiance time offset") {
                let hours = number("Irradiance Time Offset")?;
                self.late_min = late_min(path, Some(*line), hours, value)?;
            } else if lower.starts_with("slope") {
                self.slope_deg = Some(number("Slope")?);
            }
        }
        Ok(())
    }

    /// Refuses the head of a PVGIS file without names below it.
    pub(super) fn refuse_unfinished(&mut self, path: &Path, above: &[HeadLine]) -> Result<()> {
        let first = above.first().map(|line| line.text.to_lowercase()).unwrap_or_default();
        if !first.starts_with("latitude (") {
            return Ok(());
        }
        self.pvgis(path, above)?;
        let what = "no line of names that starts with `time`, as PVGIS writes it";
        let line = above.last().map(|line| line.line);
        Err(Error::input(path, line, what, "fetch the file again as CSV, hourly data or typical year"))
    }

    /// Reads the first line of TMY3, with words behind its numbers.
    fn solar_anywhere(&mut self, path: &Path, above: &[HeadLine]) -> Result<()> {
        let Some(HeadLine { line, text }) = above.first() else { return Ok(()) };
        let cells = split(text, b',');
        let number = |place: usize, name: &str| checked(path, *line, name, cells.get(place).map_or("", String::as_str));
        self.station.zone_hours = Some(number(3, "time zone")?);
        self.station.latitude_deg = Some(number(4, "latitude")?);
        self.station.longitude_deg = Some(number(5, "longitude")?);
        self.station.elevation_m = number(6, "elevation")?;
        let lower = text.to_lowercase();
        let method =
            lower.split_once("averaging method:").map(|(_, method)| method.split('/').next().unwrap_or_default());
        self.stamped_at = match method {
            Some(method) if method.contains("end") => Some(StampedAt::End),
            Some(method) if ["cent", "mid"].iter().any(|word| method.contains(word)) => Some(StampedAt::Middle),
            Some(method) if method.contains("start") || method.contains("begin") => Some(StampedAt::Start),
            _ => None,
        };
        Ok(())
    }

    /// Reads a line such as `#Latitude;45`, `Longitude: 8.0` or `Location: Latitude 45 Longitude
    /// 8`.
    fn tagged(&mut self, path: &Path, line: &HeadLine) -> Result<()> {
        let lower = line.text.trim_matches(['"', '#', ' ', ',']).to_lowercase();
        if self.kind == Kind::NasaPower {
            return self.nasa_place(path, line.line, &lower);
        }
        // `Latitude (positive North, ISO 19115): 40.0`
        let bracket =
            lower.find('(').filter(|open| lower.get(..*open).is_some_and(|tag| !tag.contains([':', ';', ','])));
        let close = bracket.and_then(|open| Some(open + lower.get(open..)?.find(')')? + 1));
        let behind = lower.get(close.unwrap_or(0)..).unwrap_or_default();
        let Some((tag, value)) = behind.split_once([':', ';', '=', ',', '\t']) else { return Ok(()) };
        let tag = squash(bracket.and_then(|open| lower.get(..open)).unwrap_or(tag));
        let value = value.trim_matches([' ', '"', ';', ',', '\t', ':']);
        let word = value.split([';', ' ', ',', '\t', '\u{b0}']).next().unwrap_or_default();
        let number = |name: &str| checked(path, line.line, name, word);
        // A value that is no number is a comment.
        let is_number = word.parse::<f64>().is_ok();
        match tag.as_str() {
            "latitude" | "lat" | "sitelatitude" if is_number => self.station.latitude_deg = Some(number("latitude")?),
            "longitude" | "lon" | "sitelongitude" | "long" | "lng" if is_number => {
                self.station.longitude_deg = Some(number("longitude")?);
            }
            "elevation" | "altitude" | "siteelevation" if is_number => {
                self.station.elevation_m = number("elevation")?;
            }
            "timezone" | "tz" | "utcoffset" | "gmtoffset" | "timereference" => {
                let zone: String = value.split(['(', ';', ',']).next().unwrap_or_default().split_whitespace().collect();
                self.station.zone_hours = parse_zone(&zone).or(self.station.zone_hours);
            }
            "sitename" | "site" | "station" if !value.is_empty() => self.station.name = excerpt(value, 40),
            _ => {}
        }
        Ok(())
    }

    /// Reads `Location: Latitude  40.0   Longitude -105.0` and the elevation.
    fn nasa_place(&mut self, path: &Path, line: usize, lower: &str) -> Result<()> {
        let behind = |word: &str| {
            let (_, rest) = lower.split_once(word)?;
            rest.trim_start_matches([' ', ':', '=']).split_whitespace().next()
        };
        if lower.contains("latitude") && lower.contains("longitude") {
            self.station.latitude_deg = Some(checked(path, line, "latitude", behind("latitude").unwrap_or_default())?);
            self.station.longitude_deg =
                Some(checked(path, line, "longitude", behind("longitude").unwrap_or_default())?);
        }
        if lower.starts_with("elevation")
            && let Some(value) =
                lower.rsplit_once('=').and_then(|(_, value)| value.split_whitespace().next()?.parse().ok())
        {
            self.station.elevation_m = value;
        }
        Ok(())
    }

    /// Sets the zone that NASA POWER's dates are in: UTC, or the zone whose noon is that of the
    /// middle of its 15 degrees.
    pub fn nasa_zone(&mut self, all: &str) {
        let words = |pair: &str| {
            all.contains(&format!(" in {pair}")) || all.contains(&format!("({pair})")) || all.trim() == pair
        };
        if words("utc") {
            self.say_zone(0.0);
        } else if words("lst")
            && let Some(longitude) = self.station.longitude_deg
        {
            self.say_zone((longitude / 15.0).round());
        }
    }

    fn say_zone(&mut self, zone: f64) {
        (self.station.zone_hours, self.station.zone_is_certain) = (Some(zone), true);
    }

    /// Reads the properties of Solargis' columns: the zone of the time, the code for a missing
    /// value, and stamps of the end where the user ordered these.
    fn solargis(&mut self, all: &str) {
        let reference = all.split_once("time reference").map(|(_, rest)| rest.trim_start_matches([' ', ':']));
        let zone = reference.and_then(|rest| parse_zone(rest.split([',', '\n', ' ', ';']).next()?));
        // The default is UTC.
        self.say_zone(zone.unwrap_or(0.0));
        let no_data = all.split_once("no data value").map(|(_, rest)| rest.trim_start_matches([' ', ':', '=']));
        let number = no_data.and_then(|rest| rest.split([',', '\n', ' ', ';', ')']).next()?.parse().ok());
        self.style.no_data = Some(number.unwrap_or(-9.0));
        self.stamped_at = match all {
            _ if ["end of interval", "end of the interval", "timestamp: end", "interval end"]
                .iter()
                .any(|words| all.contains(words)) =>
            {
                Some(StampedAt::End)
            }
            _ => Some(StampedAt::Middle),
        };
    }

    /// Reads units that lines above the names state behind the name of a column: `#GHI - Global
    /// horizontal irradiation [Wh/m2]`.
    fn units_above(&mut self, above: &[HeadLine]) {
        if ![Kind::Solargis, Kind::NasaPower, Kind::Cams, Kind::Plain].contains(&self.kind) || above.is_empty() {
            return;
        }
        let unit_of = |name: &String| {
            let name = name.to_lowercase();
            let found = above.iter().find_map(|line| {
                let lower = line.text.trim_start_matches(['#', '"', ' ', '.']).to_lowercase();
                let plain = lower.trim_start_matches(|c: char| c.is_ascii_digit() || matches!(c, '.' | ' '));
                let rest =
                    plain.strip_prefix(name.as_str()).filter(|rest| rest.starts_with([' ', ':', '.', '-', '\t']))?;
                bracketed(rest)
                    .into_iter()
                    .rev()
                    .find(|text| parse_unit(text, Measure::Irradiance).is_some() || looks_like_any(text))
            });
            found.unwrap_or_default()
        };
        let units: Vec<String> = self.names.iter().map(unit_of).collect();
        if units.iter().any(|unit| !unit.is_empty()) {
            (self.units, self.units_are_loose) = (units, true);
        }
    }

    /// Returns the usual place of a stamp in its interval for the kind of a file. `has_minutes`
    /// says that it has a column of minutes.
    pub fn usual_stamp(&self, path: &Path, has_minutes: bool, instants: bool) -> Result<StampedAt> {
        let unclear = |what: &'static str| {
            let hint = "state the place of time stamps in their intervals with {weather_stamp} start, middle or end";
            Err(Error::input(path, None, what, hint))
        };
        Ok(match (self.stamped_at, self.kind) {
            (Some(at), _) => at,
            (None, Kind::Nsrdb) if !has_minutes => StampedAt::Start,
            (None, Kind::Nsrdb | Kind::Pvgis | Kind::Solargis) => StampedAt::Middle,
            (None, Kind::OpenMeteo) if instants => StampedAt::Middle,
            (None, Kind::OpenMeteo | Kind::Datalogger) => StampedAt::End,
            (None, Kind::SolarAnywhere) => {
                return unclear(
                    "is a SolarAnywhere file whose first line states no averaging method: stamps may be the middle \
                     or the end of intervals",
                );
            }
            (None, Kind::Meteonorm) => {
                return unclear(
                    "is a Meteonorm file, whose stamps are the end of hours by default and may be set otherwise",
                );
            }
            (None, Kind::Plain | Kind::NasaPower | Kind::Pvsyst | Kind::Cams) => StampedAt::Start,
        })
    }
}

/// Returns true if a line names latitude, longitude and time zone in cells.
fn is_two_line_head(lower: &str) -> bool {
    let cells: Vec<String> = lower.split([',', ';']).map(squash).collect();
    let has = |wanted: &[&str]| cells.iter().any(|cell| wanted.contains(&cell.as_str()));
    has(&["latitude", "lat"]) && has(&["longitude", "lon", "lng", "long"]) && has(&["timezone", "tz"])
}

/// Returns the delay of a row after its stamp, minutes.
pub fn late_min(path: &Path, line: Option<usize>, hours: f64, text: &str) -> Result<f64> {
    if hours.is_finite() && hours.abs() <= FARTHEST_OFFSET_HOURS {
        return Ok(60.0 * hours);
    }
    let what = format!("`Irradiance Time Offset` holds `{}`, more than an hour", excerpt(text, 60));
    let hint = "write the hours after the time stamp, -1 to 1, as in the file that was downloaded";
    Err(Error::input(path, line, what, hint))
}

/// Returns texts in round and square brackets.
fn bracketed(text: &str) -> Vec<String> {
    let parts = text.split(['(', '[']).skip(1);
    parts.filter_map(|part| Some(part.split_once([')', ']'])?.0.to_owned())).collect()
}

fn looks_like_any(text: &str) -> bool {
    [Measure::Temperature, Measure::Depth, Measure::Percent].iter().any(|measure| parse_unit(text, *measure).is_some())
}
