//! One weather in many layouts: each gives the sums of the plain table to 0.1 %, or is refused by a
//! message that names the cause.

use std::path::Path;

use glam::DVec3;
use serde_json::json;

use crate::formats::weather_csv::made_layouts::{
    AT_PLACE, Hour, Layout, SILENT, cams, hours, in_unit, nasa_csv, nsrdb, open_meteo_json, plain, services,
    solar_anywhere, stamps, table, units,
};
use crate::formats::weather_file::parse_weather_as;
use crate::series::Weather;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_core::weather::time::clock_zone::ClockZone;

/// Returns the energy on a flat plane, one to the east and one inclined to the west.
fn sums(weather: &Weather) -> [f64; 3] {
    let west = DVec3::new(-(60.0_f64.to_radians().sin()), 0.0, 0.5);
    let mut sums = [0.0; 3];
    for condition in weather.conditions(6) {
        for (sum, normal) in sums.iter_mut().zip([DVec3::Z, DVec3::X, west]) {
            let beam: f64 = condition.suns.iter().map(|sun| sun.weight * sun.sun.dot(normal).max(0.0)).sum();
            *sum += weather.interval_hours * (condition.dni_w_m2 * beam + condition.dhi_w_m2 * (1.0 + normal.z) / 2.0);
        }
    }
    sums
}

fn read(name: &str, bytes: &[u8], options: &WeatherOptions) -> Result<Weather, String> {
    parse_weather_as(Path::new(name), bytes, options, &mut || Ok(None)).map_err(|error| error.to_string())
}

/// Sixty-three layouts and units of one weather, those of people, of programs and of services, give
/// the sums of the plain table on three planes to 0.1 %, and no warning about their clocks.
#[test]
fn sixty_three_layouts_give_the_same_sums() {
    let right = sums(&read("right.csv", in_unit("time,ghi,dni,dhi", 1.0).as_bytes(), &AT_PLACE).expect("valid"));
    assert!((right[0] / 16_700.0 - 1.0).abs() < 0.1, "{right:?}");
    let all: Vec<Layout> = [units(), stamps(), services()].into_iter().flatten().collect();
    let mut wrong = Vec::new();
    for (name, bytes, options) in &all {
        match read("town.txt", bytes, options) {
            Ok(weather) => {
                let off = sums(&weather).iter().zip(&right).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
                let words = weather.report.warnings.iter().map(|said| said.plain()).collect::<Vec<_>>().join("; ");
                let odd = ["cos(z)", "apart", "midnight", "missing"].into_iter().any(|word| words.contains(word));
                let gaps = if ["WEA", "EPW"].contains(name) { false } else { odd };
                if off > 1e-3 || gaps || weather.rows.len() != 48 {
                    wrong.push(format!("{name}: {off:.4} off, {} rows: {words}", weather.rows.len()));
                }
            }
            Err(error) => wrong.push(format!("{name}: {error}")),
        }
    }
    assert!(wrong.is_empty(), "{} of {} are wrong:\n{}", wrong.len(), all.len(), wrong.join("\n"));
    assert_eq!(all.len(), 63);
}

/// Sixteen files that can be read in two ways, or in none, are refused by a message of at most four
/// lines and 400 characters that names the cause.
#[test]
fn sixteen_refusals_name_the_cause() {
    let no_statement = nasa_csv("", 0).replace(" in \n", "\n");
    let day = |hour: Hour| format!("01/06/2021 {:02}:00,{}", hour.hour, hour.light(plain));
    let one_day =
        hours().into_iter().take(24).fold("time,ghi,dni,dhi\n".to_owned(), |text, hour| text + &day(hour) + "\n");
    let long = "x".repeat(70_000);
    for (text, options, cause) in [
        (in_unit("time,ghi (lux),dni,dhi", 1.0), AT_PLACE, "the unit `lux` of column `ghi (lux)` is not known"),
        (in_unit("time,ghi_umol_m2_s,dni,dhi", 1.0), AT_PLACE, "of column `ghi_umol_m2_s` is not known"),
        (in_unit("time,ghi,dni,dhi\n,furlongs,W/m2,W/m2", 1.0), AT_PLACE, "the unit `furlongs` of column `ghi`"),
        (in_unit("time,ghi (W/m2),ghi (kW/m2),dhi", 1.0), AT_PLACE, "are both GHI"),
        (one_day, AT_PLACE, "date_order dmy or mdy"),
        (nsrdb("", -7, true), SILENT, "does not state the time zone"),
        (no_statement, SILENT, "does not state the time zone"),
        (cams("True solar time (TST)"), SILENT, "true solar time"),
        (solar_anywhere("", 60), SILENT, "states no averaging method"),
        ("Meteonorm\n".to_owned() + &in_unit("time,ghi,dni,dhi", 1.0), AT_PLACE, "is a Meteonorm file"),
        (
            format!("[{0},{0}]", open_meteo_json(|hour| json!(hour.iso(0, 60)), "iso8601")),
            SILENT,
            "2 places of Open-Meteo",
        ),
        (
            json!({"a": long, "b": [1, 2]}).to_string(),
            AT_PLACE,
            "is JSON without a table of hours: an object of 2 members, `a`, `b`",
        ),
        (format!("{{\"a\": \"{long}"), AT_PLACE, "is not a complete JSON document"),
        ("PK\u{3}\u{4}abc".into(), AT_PLACE, "is a zip archive, not a text file of weather"),
        (format!("{long},{long}\n1,2\n"), AT_PLACE, "no column of time among `xxx"),
        (format!("time,ghi\n2021-06-01T00:00,{long}\n"), AT_PLACE, "line 2: column `ghi` holds `xxx"),
    ] {
        let message = read("town.txt", text.as_bytes(), &options).map(drop).expect_err(cause);
        assert!(message.contains(cause), "{cause}: {}", message.chars().take(500).collect::<String>());
        assert!(message.len() <= 400 && message.lines().count() <= 4, "{cause}: {} bytes", message.len());
    }
}

/// Pairs of start and end whose length is not the step, and a stated period of another length, are
/// refused with the two numbers: 2 of 2.
#[test]
fn stated_lengths_are_checked() {
    let pair = table("period_start,period_end,dni,dhi", |hour| format!("{},{},1,1", hour.iso(-7, 0), hour.iso(-7, 30)));
    let period = table("time,period,dni,dhi", |hour| format!("{},PT15M,1,1", hour.iso(-7, 0)));
    for (text, minutes) in [(pair, 30), (period, 15)] {
        let message = read("w.csv", text.as_bytes(), &AT_PLACE).map(drop).expect_err("a length");
        let said = format!("the interval is stated as {minutes} min, but rows are 60 min apart");
        assert!(message.contains(&said), "{message}");
    }
}

/// Snow of 0.30 m, 11.8 in and 30 cm is equal to a millimetre, and so are albedo of 20 % and 0.2,
/// and temperatures of 288.15 K, 59 F and 15 C. Numbers outside their range are counted in one
/// sentence a column.
#[test]
fn units_of_ground_and_air_are_converted() {
    let with_air = WeatherOptions { with_air: true, ..AT_PLACE };
    let made = |names: &str, cells: &str| {
        let text = table(&format!("time,dni,dhi,{names}"), |hour| format!("{}Z,0,1,{cells}", hour.iso(0, 0)));
        read("w.csv", text.as_bytes(), &with_air).expect("valid")
    };
    for (names, cells) in [
        ("snow_depth (m),albedo (%),temp_air (K)", "0.30,20,288.15"),
        ("snow_depth [in],albedo,temp_air_f", "11.8,0.2,59"),
        ("snow_depth,Albedo (fraction),temp_air", "30,0.2,15"),
    ] {
        let weather = made(names, cells);
        let (row, air) = (weather.rows[0], weather.air[0]);
        assert!((row.snow_depth_cm.expect("snow") - 30.0).abs() < 0.1, "{names}: {row:?}");
        assert!((row.albedo.expect("albedo") - 0.2).abs() < 1e-9 && (air.dry_bulb_c.expect("air") - 15.0).abs() < 1e-9);
        assert_eq!(weather.report.warnings.len(), 2, "no year, and light at night: {:?}", weather.report.warnings);
    }
    let said = made("albedo,temp_air", "20,288.15").report.told();
    for part in
        ["48 values of `albedo`, the first `20`, lie outside 0 to 1", "48 values of `temp_air`, the first `288.15`"]
    {
        assert!(said.contains(part), "{said}");
    }
}

/// A table of GHI alone, stamped 01:00 to 24:00 in ISO 8601, is read as starts with one warning
/// that names the option. Stamped 00:00 to 23:00 it gives no warning.
#[test]
fn stamps_to_midnight_give_a_warning() {
    for (minutes, told) in [(60, 1), (0, 0)] {
        let text = table("time,ghi", |hour| format!("{},{:.1}", hour.iso(-7, minutes), hour.ghi));
        let warnings = read("w.csv", text.as_bytes(), &AT_PLACE).expect("valid").report.warnings;
        let found = warnings.iter().filter(|warning| warning.contains("weather_stamp end reads them as ends")).count();
        assert_eq!(found, told, "{warnings:?}");
    }
}

/// An unknown unit of albedo or snow leaves the column out with one warning; a unit of air is
/// refused only where air is read. A column of row numbers named `period` states no length.
#[test]
fn unknown_units_beside_light_leave_columns_out() {
    let text = table("time,dni,dhi,albedo (x),temp_air (x),period", |hour| {
        format!("{}Z,0,1,0.2,15,{}", hour.iso(0, 0), hour.hour)
    });
    let weather = read("w.csv", text.as_bytes(), &AT_PLACE).expect("valid");
    assert!(weather.rows.iter().all(|row| row.albedo.is_none()));
    let told = weather
        .report
        .warnings
        .iter()
        .filter(|warning| warning.contains("`albedo (x)` is not known, and the column is left out"));
    assert_eq!(told.count(), 1, "{:?}", weather.report.warnings);
    let with_air = WeatherOptions { with_air: true, ..AT_PLACE };
    let message = read("w.csv", text.as_bytes(), &with_air).map(drop).expect_err("air");
    assert!(message.contains("the unit `x` of column `temp_air (x)` is not known"), "{message}");
}

/// Any cut of the 63 layouts, and changed bytes in them, are read or refused without a panic, and
/// every number that is read is finite: over 4000 tries.
#[test]
fn damaged_layouts_are_read_or_refused() {
    let mut tries = 0;
    for (name, bytes, options) in [units(), stamps(), services()].into_iter().flatten() {
        let bytes = &bytes[..bytes.len().min(1500)];
        for at in (0..bytes.len()).step_by(41) {
            let mut noisy = bytes.to_vec();
            noisy[at] = (at * 37 % 256) as u8;
            for text in [&bytes[..at], &noisy] {
                tries += 1;
                if let Ok(weather) = read(name, text, &options) {
                    assert!(
                        weather
                            .rows
                            .iter()
                            .all(|row| row.dni_w_m2.is_finite() && row.dhi_w_m2.is_finite() && row.sun.is_finite())
                    );
                }
            }
        }
    }
    assert!(tries > 4000, "{tries}");
}

/// In layouts whose stamps are in UTC, a zone of -7 moves days and labels and no sun: the first of
/// 48 hours is 00:00, and the sums stay.
#[test]
fn zones_of_layouts_move_labels() {
    let local = WeatherOptions { zone: Some(ClockZone::Hours(-7.0)), ..SILENT };
    for text in
        [cams("Universal time (UT)"), nasa_csv("UTC", 0), open_meteo_json(|hour| json!(hour.iso(0, 60)), "iso8601")]
    {
        let [moved, plain] =
            [&local, &SILENT].map(|options| read("town.txt", text.as_bytes(), options).expect("valid"));
        let label = |weather: &Weather| weather.rows[0].interval.label();
        assert_eq!((label(&moved).as_str(), label(&plain).as_str()), ("2021-06-01T00:00", "2021-06-01T07:00"));
        assert!(sums(&moved).iter().zip(&sums(&plain)).all(|(a, b)| (a / b - 1.0).abs() < 1e-9));
    }
}
