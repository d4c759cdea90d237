//! Reader of TMY3 files as CSV. In: a file's bytes. Out: its rows, not yet filled or checked
//! against each other, as those of an EPW file.
//!
//! Format: Wilcox and Marion, "Users manual for TMY3 data sets", NREL/TP-581-43156, 2008, section
//! 3: a line of the site (number, name, state, time zone, latitude, longitude, elevation), a line
//! of names, then hours labelled with their END in standard time, 01:00 to 24:00. -9900 means
//! missing. Columns are found by name, so files with only a few of them are read, too. There is no
//! snow depth, and no infrared radiation.

use std::path::Path;

use crate::formats::weather_csv::is_watts;
use crate::judging::raw_weather::{AIR_C, RawRow, RawWeather, WIND_M_S, irradiance};
use crate::judging::station::Station;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::excerpt;
use heliotile_core::weather::air::Air;
use heliotile_core::weather::options::{StampedAt, WeatherOptions};
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::sun::{Interval, Location};

/// Largest number that stands for a missing value.
const MISSING: f64 = -9900.0;

/// Least radiation that is no measurement; some programs write 9999 for missing here, too.
const MISSING_RADIATION: f64 = 9999.0;

/// Returns true if the second line names the columns as TMY3 does. A first line with an averaging
/// method is that of SolarAnywhere, whose stamps it places.
pub(super) fn is_tmy3(bytes: &[u8]) -> bool {
    let first = bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
    if String::from_utf8_lossy(first).to_lowercase().contains("averaging method") {
        return false;
    }
    let second = bytes.split(|byte| *byte == b'\n').nth(1).unwrap_or_default();
    let second = second.trim_ascii_start();
    let start = second.strip_prefix(b"\"").unwrap_or(second).get(..8);
    start.is_some_and(|name| name.eq_ignore_ascii_case(b"Date (MM"))
}

/// Indices of the columns that are read; `None` where the file lacks one.
struct Columns {
    date: usize,
    time: usize,
    ghi: Option<usize>,
    dni: Option<usize>,
    dhi: Option<usize>,
    albedo: Option<usize>,
    dry_bulb: Option<usize>,
    dew_point: Option<usize>,
    opaque_sky: Option<usize>,
    wind: Option<usize>,
    count: usize,
}

impl Columns {
    fn read(path: &Path, line: &str) -> Result<Self> {
        // Units stand behind the name: "GHI (W/m^2)".
        let name = |cell: &str| cell.trim_matches(['"', ' ']).split(" (").next().unwrap_or_default().to_lowercase();
        let names: Vec<String> = line.split(',').map(|cell| name(cell.trim())).collect();
        let place = |wanted: &str| names.iter().position(|name| name == wanted);
        let needed = |wanted: &str| {
            place(wanted).ok_or_else(|| {
                let hint = "TMY3 names its columns `Date (MM/DD/YYYY),Time (HH:MM),...` in line 2";
                Error::input(path, 2, format!("there is no column `{wanted}`"), hint)
                    .because(Problem::no_column(wanted))
            })
        };
        // TMY3 holds W/m2; programs that write other units have other layouts.
        for (cell, name) in line.split(',').zip(&names) {
            let unit = cell.split_once('(').and_then(|(_, unit)| unit.rsplit_once(')')).map(|(unit, _)| unit);
            if ["ghi", "dni", "dhi"].contains(&name.as_str()) && unit.is_some_and(|unit| !is_watts(unit)) {
                let what = format!("the unit of column `{}` is not W/m2, the unit of TMY3", excerpt(cell.trim(), 60));
                return Err(Error::input(path, 2, what, "write light in W/m2"));
            }
        }
        Ok(Columns {
            date: needed("date")?,
            time: needed("time")?,
            ghi: place("ghi"),
            dni: place("dni"),
            dhi: place("dhi"),
            albedo: place("alb"),
            dry_bulb: place("dry-bulb"),
            dew_point: place("dew-point"),
            opaque_sky: place("opqcld"),
            wind: place("wspd"),
            count: names.len(),
        })
    }
}

pub(super) fn read(path: &Path, bytes: &[u8], options: &WeatherOptions) -> Result<RawWeather> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines().zip(1_usize..);
    let station = site(path, lines.next().map_or("", |(line, _)| line))?;
    let columns = Columns::read(path, lines.next().map_or("", |(line, _)| line))?;
    let mut raw: Vec<RawRow> = Vec::new();
    let mut air = Vec::new();
    for (text, line) in lines {
        if text.trim().is_empty() {
            continue;
        }
        let cells: Vec<&str> = text.split(',').map(str::trim).collect();
        if cells.len() != columns.count {
            let what = format!("the row has {} columns instead of {}", cells.len(), columns.count);
            return Err(Error::input(path, line, what, "the file may be cut off; fetch it again"));
        }
        let row = row(path, line, &cells, &columns, raw.is_empty())?;
        if let Some(before) = raw.last()
            && !before.is_followed_by(&row)
        {
            let label = row.interval.date.label(row.interval.start_min as u32);
            let what = format!("the row starts at {label}, the row before does not end there");
            let hint = "put the hours in order, without gaps, labelled with their end";
            return Err(Error::input(path, line, what, hint));
        }
        raw.push(row);
        if options.with_air {
            air.push(air_of(&cells, &columns));
        }
    }
    if raw.is_empty() {
        return Err(Error::input(path, None, "the file has no weather rows", "TMY3 has them from line 3 on"));
    }
    Ok(RawWeather {
        station,
        rows: raw,
        air,
        step_min: 60.0,
        stamped_at: StampedAt::End,
        zenith_deg: Vec::new(),
        warnings: Vec::new(),
    })
}

/// Reads the first line. The name may hold commas, and cells of other programs may stand behind the
/// elevation. So time zone, latitude and longitude are the first three numbers in their ranges with
/// an elevation behind them.
fn site(path: &Path, line: &str) -> Result<Station> {
    let hint = "write number,name,state,time zone,latitude,longitude,elevation";
    let line = line.trim_start_matches('\u{feff}').trim_end_matches([',', ' ', '\r']);
    let cells: Vec<&str> = line.split(',').map(|cell| cell.trim_matches(['"', ' '])).collect();
    let is = |cell: Option<&&str>, most: f64| {
        cell.and_then(|text| text.parse::<f64>().ok()).is_some_and(|value| value.abs() <= most)
    };
    let fits = |start: &usize| {
        let at = |place: usize| cells.get(start + place);
        is(at(0), 14.0) && is(at(1), 90.0) && is(at(2), 180.0) && is(at(3), 9999.0)
    };
    let start = (2..cells.len()).find(fits).unwrap_or_else(|| cells.len().saturating_sub(4).min(3));
    let (Some([_, name @ ..]), Some([zone, latitude, longitude, elevation])) =
        (cells.get(..start), cells.get(start..start + 4))
    else {
        return Err(Error::input(path, 1, "the site has fewer than five columns", hint));
    };
    let number = |text: &str, what: &str| {
        let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
        value.ok_or_else(|| Error::input(path, 1, format!("{what} of the site holds `{}`", excerpt(text, 60)), hint))
    };
    let (latitude, longitude) = (number(latitude, "latitude")?, number(longitude, "longitude")?);
    let site = Location::new(latitude, longitude, number(zone, "time zone")?, number(elevation, "elevation")?);
    let site = site.map_err(|what| Error::input(path, 1, what, hint))?;
    Ok(Station::known(name.join(", "), site))
}

fn row(path: &Path, line: usize, cells: &[&str], columns: &Columns, is_first: bool) -> Result<RawRow> {
    let cell = |place: usize| cells.get(place).copied().unwrap_or_default();
    let bad = |name: &str, text: &str, hint: &'static str| {
        Error::input(path, line, format!("column `{name}` holds `{}`", excerpt(text, 60)), hint)
    };
    let whole = |text: &str| text.parse::<u32>().ok();
    let mut parts = cell(columns.date).split('/').map(whole);
    let mut next = || parts.next().flatten();
    let date = (|| {
        let (month, day, year) = (next()?, next()?, next()?);
        Date::new(i32::try_from(year).ok()?, month, day)
    })();
    let date = date.ok_or_else(|| bad("Date", cell(columns.date), "write a date that exists as MM/DD/YYYY"))?;
    let time = cell(columns.time);
    let clock = time.strip_suffix(":00:00").or(time.strip_suffix(":00"));
    // Programs write the 24:00 of a day as the 00:00 of the next one, but not in a first row.
    let least = u32::from(is_first);
    let hour = clock.and_then(whole).filter(|hour| (least..=24).contains(hour));
    let before = || Date::of_day_number(date.day_number() - 1);
    let dated = hour.and_then(|hour| if hour == 0 { Some((before()?, 24)) } else { Some((date, hour)) });
    let (date, hour) = dated.ok_or_else(|| bad("Time", time, "TMY3 holds whole hours by their end, 01:00 to 24:00"))?;
    let mut negative = false;
    let mut radiation = |place: Option<usize>, name: &str| {
        let text = place.map(cell).unwrap_or_default();
        if text.is_empty() {
            return Ok(None);
        }
        let missing = |value| value <= MISSING || value >= MISSING_RADIATION;
        irradiance(text, missing, &mut negative, || bad(name, text, "write W/m2 from 0 up, -9900 where missing"))
    };
    let (ghi, dni) = (radiation(columns.ghi, "GHI")?, radiation(columns.dni, "DNI")?);
    let dhi = radiation(columns.dhi, "DHI")?;
    let albedo = number(cells, columns.albedo, [0.0, 1.0]).filter(|albedo| *albedo > 0.0);
    let end_min = f64::from(60 * hour);
    let interval = Interval { date, start_min: end_min - 60.0, end_min };
    Ok(RawRow { line, interval, ghi, dni, dhi, negative, albedo, snow_depth_cm: None })
}

fn number(cells: &[&str], place: Option<usize>, [low, high]: [f64; 2]) -> Option<f64> {
    cells.get(place?)?.parse().ok().filter(|value| (low..=high).contains(value))
}

fn air_of(cells: &[&str], columns: &Columns) -> Air {
    Air {
        dry_bulb_c: number(cells, columns.dry_bulb, AIR_C),
        dew_point_c: number(cells, columns.dew_point, AIR_C),
        infrared_w_m2: None,
        opaque_sky_tenths: number(cells, columns.opaque_sky, [0.0, 10.0]),
        wind_m_s: number(cells, columns.wind, WIND_M_S),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::weather_file::{parse_weather, parse_weather_as};

    fn parse(text: &str) -> Result<crate::series::Weather> {
        parse_weather(Path::new("w.csv"), text.as_bytes())
    }

    /// The hours of Golden's EPW written as TMY3 give equal light, suns and air, 8760 of 8760. The
    /// missing infrared radiation is computed.
    #[test]
    fn tmy3_gives_the_light_of_the_epw() {
        let epw = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/weather/golden_tmy3.epw");
        let bytes = std::fs::read(&epw).expect("data");
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let mut csv = "724666,\"GOLDEN, NREL\",CO,-7.0,39.74,-105.18,1829\n\
                       Date (MM/DD/YYYY),Time (HH:MM),ETR (W/m^2),GHI (W/m^2),GHI source,GHI uncert (%),DNI (W/m^2),DHI (W/m^2),\
                       OpqCld (tenths),Dry-bulb (C),Dew-point (C),Alb (unitless)\n"
            .to_owned();
        for line in text.lines().skip(8) {
            let c: Vec<&str> = line.split(',').collect();
            let clock = format!("{:0>2}/{:0>2}/{},{:0>2}:00", c[1], c[2], c[0], c[3]);
            let (light, air) = (format!("0,{},2,8,{},{}", c[13], c[14], c[15]), format!("{},{},{}", c[23], c[6], c[7]));
            csv += &format!("{clock},{light},{air},{}\n", c[32]);
        }
        let one = parse_weather(&epw, &bytes).expect("EPW");
        let with_air = WeatherOptions { with_air: true, ..WeatherOptions::default() };
        let two = parse_weather_as(Path::new("golden.csv"), csv.as_bytes(), &with_air, &mut || Ok(None)).expect("TMY3");
        assert_eq!((two.rows.len(), one.rows.len(), two.place.as_str()), (8760, 8760, "GOLDEN, NREL, CO"));
        assert_eq!(one.site.zone_hours, two.site.zone_hours);
        for (a, b) in one.rows.iter().zip(&two.rows) {
            let light = |row: &heliotile_core::weather::row::WeatherRow| {
                (row.interval, row.ghi_w_m2, row.dni_w_m2, row.dhi_w_m2, row.albedo)
            };
            assert_eq!(light(a), light(b), "line {}", a.line);
            assert!((a.sun - b.sun).length() < 1e-9);
        }
        assert!(two.air.iter().all(|air| air.sky_w_m2().is_some()));
        assert_eq!(two.report.warnings.len(), 1, "{:?}", two.report.warnings);
        assert!(two.report.warnings[0].contains("infrared radiation of 8760 hours"), "{:?}", two.report.warnings);
    }

    const HEAD: &str = "1,Town,X,1,45,8,250\nDate (MM/DD/YYYY),Time (HH:MM),DHI (W/m^2),DNI (W/m^2),GHI (W/m^2)\n";

    /// -9900 and an empty cell are missing: DHI is computed for two hours. 24:00 ends its own day,
    /// so that 3 hours follow each other.
    #[test]
    fn missing_tmy3_values_are_computed() {
        let rows = "06/16/2021,14:00,-9900,500,700\n06/16/2021,15:00,,500,600\n";
        let weather = parse(&format!("{HEAD}{rows}")).expect("valid");
        assert!(
            weather.rows.iter().all(|row| row.dhi_w_m2 > 10.0 && row.snow_depth_cm.is_none() && row.albedo.is_none())
        );
        assert_eq!(weather.report.warnings.len(), 2, "{:?}", weather.report.warnings);
        let rows = "06/16/2021,23:00,0,0,0\n06/16/2021,24:00,0,0,0\n06/17/2021,01:00,0,0,0\n";
        assert_eq!(parse(&format!("{HEAD}{rows}")).expect("valid").rows.len(), 3);
    }

    /// Cells behind the elevation, and commas in the name, leave the site at 45 N, 8 E and 250 m: 3
    /// of 3. Light in kW/m2 is refused.
    #[test]
    fn the_site_is_found_among_other_cells() {
        let rows = "06/16/2021,14:00,1,1,1\n06/16/2021,15:00,1,1,1\n";
        for site in [
            "1,Town,X,1,45,8,250,\"made by hand, 60 minutes\",,",
            "1,\"Town, East\",X,1,45,8,250",
            "1,A,B,C,X,1,45,8,250,7",
        ] {
            let weather = parse(&format!("{}{rows}", HEAD.replace("1,Town,X,1,45,8,250", site))).expect(site);
            let place = (weather.site.latitude_deg, weather.site.longitude_deg, weather.site.elevation_m);
            assert_eq!(place, (45.0, 8.0, 250.0), "{site}");
        }
        let message =
            parse(&format!("{}{rows}", HEAD.replace("DNI (W/m^2)", "DNI (kW/m^2)"))).expect_err("a unit").to_string();
        assert!(message.contains("line 2: the unit of column `DNI (kW/m^2)` is not W/m2"), "{message}");
    }

    /// Eleven wrong files are refused with the line and the text found.
    #[test]
    fn wrong_tmy3_files_are_refused_with_the_line() {
        let row = |text: &str| format!("{HEAD}{text}\n");
        for (text, said) in [
            (HEAD.to_owned(), "no weather rows"),
            ("1,2\nDate (MM/DD/YYYY)\n".into(), "line 1: the site has fewer than five columns"),
            (HEAD.replace("45", "north"), "line 1: latitude of the site holds `north`"),
            (HEAD.replace("45", "450"), "line 1: "),
            (HEAD.replace("Time (HH:MM)", "Hour"), "line 2: there is no column `time`"),
            (row("02/30/2021,01:00,0,0,0"), "line 3: column `Date` holds `02/30/2021`"),
            (row("06/16/2021,00:00,0,0,0"), "line 3: column `Time` holds `00:00`"),
            (row("06/16/2021,01:30,0,0,0"), "line 3: column `Time` holds `01:30`"),
            (row("06/16/2021,01:00,0,nan,0"), "line 3: column `DNI` holds `nan`"),
            (row("06/16/2021,01:00,0,0"), "line 3: the row has 4 columns instead of 5"),
            (row("06/16/2021,01:00,0,0,0\n06/16/2021,03:00,0,0,0"), "line 4: the row starts at 2021-06-16T02:00"),
        ] {
            let message = parse(&text).map(drop).expect_err(said).to_string();
            assert!(message.starts_with("w.csv") && message.contains(said), "{said}: {message}");
        }
    }
}
