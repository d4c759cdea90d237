//! Two clear days as stations, programs and services write them, with columns that are empty, named
//! otherwise, or stamped otherwise: each gives the sums of the plain table, or a message that names
//! the cause.

use std::fmt::Write as _;
use std::path::Path;

use glam::DVec3;
use serde_json::{Map, Value, json};

use crate::formats::weather_file::parse_weather_as;
use crate::series::Weather;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_core::weather::time::calendar::Date;

/// An hour of the two days, by its start in +01:00.
#[derive(Clone, Copy)]
struct Hour {
    day: u32,
    hour: u32,
    ghi: f64,
    dni: f64,
    dhi: f64,
}

const HEAD: &str = "# latitude: 47.2\n# longitude: 8.6\n";

fn hours() -> Vec<Hour> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/weather/two_clear_days.csv");
    let text = std::fs::read_to_string(path).expect("data");
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |place: usize| cells[place].parse::<f64>().expect("a number");
        let of = |from: usize, to: usize| cells[0][from..to].parse::<u32>().expect("a number");
        Hour { day: of(8, 10), hour: of(11, 13), ghi: number(1), dni: number(2), dhi: number(3) }
    };
    text.lines().skip(3).map(row).collect()
}

fn table(names: &str, row: impl Fn(Hour) -> String) -> String {
    hours().into_iter().fold(format!("{HEAD}{names}\n"), |mut text, hour| {
        writeln!(text, "{}", row(hour)).expect("a text");
        text
    })
}

fn stamp(hour: Hour) -> String {
    format!("2021-06-{:02}T{:02}:00+01:00", hour.day, hour.hour)
}

fn read(text: &str) -> Result<Weather, String> {
    parse_weather_as(Path::new("w.csv"), text.as_bytes(), &WeatherOptions::default(), &mut || Ok(None))
        .map_err(|error| error.to_string())
}

/// Returns the energy on a flat plane, and on vertical ones to the east and to the west, kWh/m2.
fn sums(weather: &Weather) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for condition in weather.conditions(6) {
        for (sum, normal) in sums.iter_mut().zip([DVec3::Z, DVec3::X, -DVec3::X]) {
            let beam: f64 = condition.suns.iter().map(|sun| sun.weight * sun.sun.dot(normal).max(0.0)).sum();
            *sum += condition.dni_w_m2 * beam + condition.dhi_w_m2 * f64::midpoint(1.0, normal.z);
        }
    }
    sums.map(|sum| sum * weather.interval_hours / 1000.0)
}

/// Returns the largest difference from the plain table on the three planes, as a share.
fn off(weather: &Weather) -> f64 {
    let plain = table("time,ghi,dni,dhi", |h| format!("{},{},{},{}", stamp(h), h.ghi, h.dni, h.dhi));
    let right = sums(&read(&plain).expect("the plain table"));
    assert!((right[0] - 14.26).abs() < 0.05, "{right:?}");
    sums(weather).iter().zip(&right).map(|(found, right)| (found / right - 1.0).abs()).fold(0.0, f64::max)
}

/// A column of zeros is computed from the others: DNI or DHI within 2 %, both from GHI within 6 %.
/// The warning names the column, the month and the sum of GHI, 14.3 kWh/m2. An overcast day of DNI
/// 0 keeps its zeros.
#[test]
fn columns_of_zeros_are_computed_from_the_others() {
    for (name, shares, most) in [("DNI", [0.0, 1.0], 0.02), ("DHI", [1.0, 0.0], 0.02), ("DHI", [0.0, 0.0], 0.06)] {
        let text = table("time,ghi,dni,dhi", |h| {
            format!("{},{},{},{}", stamp(h), h.ghi, h.dni * shares[0], h.dhi * shares[1])
        });
        let weather = read(&text).expect("weather");
        let words = weather.report.told();
        assert!(off(&weather) < most, "{name}: {} {words}", off(&weather));
        assert!(words.contains(&format!("{name} is 0 in all rows of 2021-06, where GHI sums to 14.3")), "{words}");
    }
    let overcast = table("time,ghi,dni,dhi", |h| format!("{},{},0,{}", stamp(h), h.dhi, h.dhi));
    let weather = read(&overcast).expect("weather");
    assert!(weather.rows.iter().all(|row| row.dni_w_m2 == 0.0));
    assert!(!weather.report.told().contains("is 0 in all rows"));
}

/// The names of BSRN, short and long, of PVWatts, of oemof and of SARAH give the sums of the plain
/// table within 1 %, 2 % where DNI is computed.
#[test]
fn names_of_archives_are_read() {
    let horizontal = |h: Hour| (h.ghi - h.dhi).max(0.0);
    for (names, row) in [
        (
            "time,SWD [W/m**2],DIR [W/m**2],DIF [W/m**2]",
            (|h| format!("{},{},{}", h.ghi, h.dni, h.dhi)) as fn(Hour) -> String,
        ),
        (
            "time,Short-wave downward (GLOBAL) radiation [W/m**2],Direct radiation [W/m**2],Diffuse radiation [W/m**2]",
            |h| format!("{},{},{}", h.ghi, h.dni, h.dhi),
        ),
        ("time,Direct radiation [W/m**2],Diffuse radiation [W/m**2]", |h| format!("{},{}", h.dni, h.dhi)),
        ("time,Beam Irradiance (W/m^2),Diffuse Irradiance (W/m^2)", |h| format!("{},{}", h.dni, h.dhi)),
    ] {
        let weather = read(&table(names, |h| format!("{},{}", stamp(h), row(h)))).unwrap_or_else(|e| panic!("{e}"));
        assert!(off(&weather) < 0.01, "{names}: {}", off(&weather));
    }
    let oemof = table("time,dhi,dirhi,v_wind", |h| format!("{},{},{:.1},2", stamp(h), h.dhi, horizontal(h)));
    let sarah = table("time,SIS,SID,DNI", |h| format!("{},{},{:.1},{}", stamp(h), h.ghi, horizontal(h), h.dni));
    for text in [oemof, sarah] {
        assert!(off(&read(&text).expect("weather")) < 0.02, "{text}");
    }
}

/// A table with DHI alone beside `direct` and `sum` is refused with both names. One with GHI beside
/// `direct` is read, and its warning names the column. A direct horizontal column above GHI in 30
/// rows is refused.
#[test]
fn columns_that_are_not_read_are_named() {
    let error = read(&table("time,dhi,direct,sum", |h| format!("{},{},{},{}", stamp(h), h.dhi, h.dni, h.ghi)));
    let error = error.expect_err("no total");
    assert!(error.contains("`dhi`, give no total, and `direct`, `sum` are not read"), "{error}");
    let weather = read(&table("time,ghi,direct", |h| format!("{},{},{}", stamp(h), h.ghi, h.dni))).expect("weather");
    assert!(weather.report.told().contains("not read: `direct`"), "{:?}", weather.report.warnings);
    let error = read(&table("time,ghi,bhi", |h| format!("{},{},{}", stamp(h), h.ghi, h.dni))).expect_err("above");
    assert!(error.contains("column `bhi`") && error.contains("exceeds GHI"), "{error}");
}

/// Stamps at half past are middles, those of minute 59 or second 59 ends, and those with the zenith
/// of their moment middles: each within 1 % on east and west, and said. India's hours in UTC, from
/// 18:30, stay starts.
#[test]
fn stamps_that_cannot_be_starts_are_placed() {
    for (minute, said) in [("30", "middle"), ("59", "end"), ("59:59", "end")] {
        let text =
            table("time,dni,dhi", |h| format!("2021-06-{:02}T{:02}:{minute}+01:00,{},{}", h.day, h.hour, h.dni, h.dhi));
        let weather = read(&text).expect("weather");
        assert!(off(&weather) < 0.01, "{minute}: {}", off(&weather));
        assert!(weather.report.told().contains(&format!("read as the {said}")), "{minute}");
    }
    let plain = read(&table("time,dni,dhi", |h| format!("{},{},{}", stamp(h), h.dni, h.dhi))).expect("weather");
    // The zenith of the stamp, of half an hour later and of half an hour earlier.
    for (name, later_min, starts_min) in [("zenith (deg)", 0.0, 690.0), ("sza", 30.0, 720.0), ("sza", -30.0, 660.0)] {
        let zenith = |place: usize| {
            let interval = plain.rows[place].interval;
            plain.site.sun(interval.date, interval.start_min + later_min).z.acos().to_degrees()
        };
        let text = table(&format!("time,dni,dhi,{name}"), |h| {
            let place = ((h.day - 1) * 24 + h.hour) as usize;
            format!("{},{},{},{:.2}", stamp(h), h.dni, h.dhi, zenith(place))
        });
        let weather = read(&text).expect("weather");
        assert_eq!(weather.rows[12].interval.start_min, starts_min, "{later_min}");
    }
    let india = hours().into_iter().enumerate().fold(
        "# latitude: 28\n# longitude: 77\ntime,ghi\n".to_owned(),
        |text, (i, h)| {
            let (day, hour) = ((i + 18) / 24, (i + 18) % 24);
            format!("{text}2021-06-{:02}T{hour:02}:30Z,{}\n", day + 1, h.ghi)
        },
    );
    let weather = read(&india).expect("weather");
    assert_eq!(weather.rows[0].interval.start_min, 18.5 * 60.0);
}

/// A column named DNI whose sum with DHI is GHI is read as direct horizontal irradiance, within 2
/// %, and the warning says to name it `bhi`.
#[test]
fn direct_horizontal_light_named_dni_is_found_by_its_sum() {
    let text = table("time,ghi,dni,dhi", |h| format!("{},{},{:.1},{}", stamp(h), h.ghi, h.ghi - h.dhi, h.dhi));
    let weather = read(&text).expect("weather");
    assert!(off(&weather) < 0.02, "{}", off(&weather));
    assert!(weather.report.told().contains("name it `bhi`"), "{:?}", weather.report.warnings);
}

/// A logger that shows 1 W/m2 all night adds nothing: DHI of the hours with the sun below -6
/// degrees is 0, 12 hours in two nights of June, and the warning says so.
#[test]
fn an_offset_at_night_is_left_out() {
    let text = table("time,ghi,dni,dhi", |h| format!("{},{},{},{}", stamp(h), h.ghi.max(1.0), h.dni, h.dhi.max(1.0)));
    let weather = read(&text).expect("weather");
    let dark = weather.rows.iter().filter(|row| row.dhi_w_m2 == 0.0).count();
    let words = weather.report.told();
    assert_eq!(dark, 12, "{words}");
    assert!(words.contains("light of 12 hours with the sun more than 6 degrees below"), "{words}");
}

/// Eight tables of services and programs give the sums of the plain table within 1 %: basic ISO
/// 8601 stamps, `DATE,MST` of MIDC, CAMS McClear, SolarAnywhere's TMY3, TMY3 with seconds and with
/// 00:00 for 24:00, fill values -99 and `--` at night, and a row of totals.
#[test]
fn tables_of_services_are_read() {
    let light = |h: Hour| format!("{},{},{}", h.ghi, h.dni, h.dhi);
    let basic = table("time,ghi,dni,dhi", |h| format!("202106{:02}T{:02}0000+0100,{}", h.day, h.hour, light(h)));
    let fill = |h: Hour, value: f64| match (h.ghi, h.hour) {
        (0.0, 0..12) => "-99".to_owned(),
        (0.0, _) => "--".to_owned(),
        _ => value.to_string(),
    };
    let filled =
        table("time,ghi,dni,dhi", |h| format!("{},{},{},{}", stamp(h), fill(h, h.ghi), fill(h, h.dni), fill(h, h.dhi)));
    let total = table("time,ghi,dni,dhi", |h| format!("{},{}", stamp(h), light(h))) + "Totals,14255,24000,3000\n";
    let next = |h: Hour| if h.hour == 23 { (h.day + 1, 0) } else { (h.day, h.hour + 1) };
    let tmy3 = |first: &str, names: &str, clock: &dyn Fn(Hour) -> String| {
        let row = |h: Hour| format!("{},{}", clock(h), light(h));
        table("", row).replacen(HEAD, "", 1).replacen('\n', &format!("{first}\n{names}\n"), 1)
    };
    let names = "Date (MM/DD/YYYY),Time (HH:MM),GHI (W/m^2),DNI (W/m^2)),DHI (W/m^2)";
    let at_end = |h: Hour| {
        let (day, hour) = next(h);
        format!("06/{day:02}/2021,{hour:02}:00")
    };
    let site = "0,Somewhere,NA,1,47.2,8.6,100";
    let anywhere = tmy3(&format!("{site},\"Averaging Method: End of Period\""), names, &at_end);
    let midnight = tmy3(site, &names.replace("))", ")"), &at_end);
    let seconds = tmy3(site, &names.replace("))", ")"), &|h| format!("06/{:02}/2021,{:02}:00:00", h.day, h.hour + 1));
    let midc = table("", |h| format!("06/{:02}/2021,{:02}:00,{}", h.day, h.hour, light(h)));
    let midc = midc.replacen("\n\n", "\nDATE (MM/DD/YYYY),MST,GHI,DNI,DHI\n", 1).replace("8.6", "-105");
    for (name, text) in [
        ("ISO basic", &basic),
        ("fill values", &filled),
        ("totals", &total),
        ("SolarAnywhere", &anywhere),
        ("TMY3 00:00", &midnight),
        ("TMY3 with seconds", &seconds),
    ] {
        let weather = read(text).unwrap_or_else(|error| panic!("{name}: {error}\n{text}"));
        assert!(weather.rows.len() == 48 && off(&weather) < 0.01, "{name}: {}", off(&weather));
    }
    let weather = read(&midc).expect("MIDC");
    assert_eq!((weather.site.zone_hours, weather.rows.len()), (-7.0, 48));
    let mut clear = "# Latitude (positive North, ISO 19115): 47.2\n# Longitude (positive East, ISO 19115): 8.6\n# Time reference: Universal time (UT)\n# Observation period;TOA;Clear sky GHI;Clear sky BHI;Clear sky DHI;Clear sky BNI\n".to_owned();
    for h in hours() {
        let at = |hour: u32| {
            let hours = (h.day + 29) * 24 + hour - 1;
            let (month, day) = if hours / 24 < 31 { (5, hours / 24 + 1) } else { (6, hours / 24 - 30) };
            format!("2021-{month:02}-{day:02}T{:02}:00:00.0", hours % 24)
        };
        let (start, end) = (at(h.hour + 24), at(h.hour + 25));
        writeln!(clear, "{start}/{end};900;{};0;{};{}", h.ghi, h.dhi, h.dni).expect("a text");
    }
    let weather = read(&clear).expect("McClear");
    assert!(off(&weather) < 0.01, "{}", off(&weather));
}

/// A typical year whose months change at 17:30 of the last day, because it was put together in UTC,
/// keeps 24 hours on that day.
#[test]
fn a_year_may_change_within_the_last_day_of_a_month() {
    let mut text =
        "Latitude,Longitude,Time Zone,Elevation\n33.4,-112,-7,300\nYear,Month,Day,Hour,Minute,GHI\n".to_owned();
    for hour in 0..72 {
        let (month, day) = if hour < 48 { (1, 30 + hour / 24) } else { (2, 1) };
        let year = if hour < 24 + 17 { 2012 } else { 2001 };
        writeln!(text, "{year},{month},{day},{},30,{}", hour % 24, 10 * (hour % 24)).expect("a text");
    }
    let weather = read(&text).expect("weather");
    let of = |year, month, day| weather.rows.iter().filter(|row| row.interval.date == date(year, month, day)).count();
    assert_eq!((of(2012, 1, 31), of(2001, 2, 1), weather.rows.len()), (24, 24, 72));
}

fn date(year: i32, month: u32, day: u32) -> Date {
    Date::new(year, month, day).expect("a date")
}

fn at_place(text: &str, zone: &str) -> Result<Weather, String> {
    let zone = Some(zone.parse().expect("a zone"));
    let options =
        WeatherOptions { latitude_deg: Some(47.2), longitude_deg: Some(8.6), zone, ..WeatherOptions::default() };
    parse_weather_as(Path::new("w.json"), text.as_bytes(), &options, &mut || Ok(None))
        .map_err(|error| error.to_string())
}

/// Records whose first ones lack DNI and DHI, columns and rows keyed by stamps, records newest
/// first, PVGIS' typical year and Open-Meteo with temperatures by quarters of hours give the sums
/// of the plain table within 1 %.
#[test]
fn json_of_six_shapes_is_read() {
    let utc = |h: Hour| {
        let hours = (h.day + 29) * 24 + h.hour + 23;
        let (month, day) = if hours / 24 < 31 { (5, hours / 24 + 1) } else { (6, hours / 24 - 30) };
        format!("2021-{month:02}-{day:02}T{:02}:00", hours % 24)
    };
    let record = |h: Hour, time: &str| match h.ghi {
        0.0 => json!({ "time": time, "ghi": 0.0 }),
        _ => json!({ "time": time, "ghi": h.ghi, "dni": h.dni, "dhi": h.dhi }),
    };
    let all = hours();
    let sparse: Vec<Value> = all.iter().map(|h| record(*h, &(utc(*h) + "Z"))).collect();
    let newest: Vec<Value> = sparse.iter().rev().cloned().collect();
    let column =
        |of: fn(&Hour) -> f64| -> Value { all.iter().map(|h| (utc(*h), json!(of(h)))).collect::<Map<_, _>>().into() };
    let columns = json!({ "ghi": column(|h| h.ghi), "dni": column(|h| h.dni), "dhi": column(|h| h.dhi) });
    let index: Map<String, Value> =
        all.iter().map(|h| (utc(*h), json!({ "ghi": h.ghi, "dni": h.dni, "dhi": h.dhi }))).collect();
    let pvgis: Vec<Value> = all
        .iter()
        .map(|h| {
            let time = utc(*h).replace('-', "").replace('T', ":");
            let time = format!("{}{}", &time[..11], &time[12..]);
            json!({ "time(UTC)": time, "G(h)": h.ghi, "Gb(n)": h.dni, "Gd(h)": h.dhi })
        })
        .collect();
    let pvgis = json!({
        "inputs": { "location": { "latitude": 47.2, "longitude": 8.6, "irradiance_time_offset": 0.5 } },
        "outputs": { "months_selected": [{ "month": 1, "year": 2018 }, { "month": 2, "year": 2019 }], "tmy_hourly": pvgis },
    });
    let quarters: Vec<String> = (0..8).map(|i| format!("2021-06-01T{:02}:{:02}", i / 4, i % 4 * 15)).collect();
    let ends = |h: &Hour| {
        let hours = (h.day - 1) * 24 + h.hour + 1;
        format!("2021-06-{:02}T{:02}:00", hours / 24 + 1, hours % 24)
    };
    let open_meteo = json!({
        "latitude": 47.2, "longitude": 8.6, "utc_offset_seconds": 3600,
        "minutely_15": { "time": quarters, "temperature_2m": [10, 10, 10, 10, 10, 10, 10, 10] },
        "hourly": {
            "time": all.iter().map(ends).collect::<Vec<_>>(),
            "shortwave_radiation": all.iter().map(|h| h.ghi).collect::<Vec<_>>(),
            "direct_normal_irradiance": all.iter().map(|h| h.dni).collect::<Vec<_>>(),
            "diffuse_radiation": all.iter().map(|h| h.dhi).collect::<Vec<_>>(),
        },
    });
    for (name, document, zone) in [
        ("sparse", Value::from(sparse), "+01:00"),
        ("newest first", Value::from(newest), "+01:00"),
        ("columns", columns, "UTC"),
        ("index", Value::from(index), "UTC"),
        ("PVGIS", pvgis, "+01:00"),
        ("Open-Meteo", open_meteo, "+01:00"),
    ] {
        let weather = at_place(&document.to_string(), zone).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(weather.rows.len() == 48 && off(&weather) < 0.01, "{name}: {}", off(&weather));
    }
    let error = at_place("{\"hourly\": [{\"time\": \"2021-06-01T00:00Z\"}, {\"time\": \"2021-06-01T01:00Z\"}]}", "UTC");
    assert!(error.expect_err("no light").starts_with("w.json: no column of light"));
}

/// Two days of June in Amsterdam are two days of 24 hours, from stamps in UTC and from the legal
/// clock's own, with the sun of the plain table. 31 October has 25 hours, 28 March has 23; a stamp
/// of 02:00 on 28 March is refused.
#[test]
fn days_go_by_a_clock_with_summer_time() {
    let rows = |start: (i32, u32, u32), count: i64, ahead: fn(i64) -> i64| {
        let start_s = i64::from(date(start.0, start.1, start.2).day_number()) * 86_400;
        (0..count).fold("time,ghi\n".to_owned(), |text, hour| {
            let at = start_s + hour * 3600;
            let (day, minutes) = Date::OF_DAY_0.after((at + ahead(at)) as f64 / 60.0);
            format!("{text}{},{}\n", day.label(minutes as u32), 1)
        })
    };
    let days = |weather: &Weather| {
        let mut all: Vec<(u32, usize)> = Vec::new();
        for row in &weather.rows {
            match all.last_mut() {
                Some((day, count)) if *day == row.interval.date.day => *count += 1,
                _ => all.push((row.interval.date.day, 1)),
            }
        }
        all
    };
    let amsterdam = |text: &str| at_place(text, "Europe/Amsterdam");
    // 22:00 UTC is midnight in summer.
    let june = rows((2021, 6, 1), 48, |_| -7200).replace(",1\n", "Z,1\n");
    let june = amsterdam(&june).expect("UTC");
    assert_eq!((days(&june), june.site.zone_hours), (vec![(1, 24), (2, 24)], 1.0));
    assert_eq!(june.rows[0].interval.start_min, -60.0);
    let legal = amsterdam(&rows((2021, 6, 1), 48, |_| 0)).expect("legal time");
    assert_eq!(days(&legal), [(1, 24), (2, 24)]);
    assert_eq!(legal.rows[12].sun, june.rows[12].sun);
    // From 1 UTC of 31 October on the clock is an hour ahead, before two.
    let autumn = rows((2021, 10, 31), 26, |at| if at % 86_400 < 10_800 && at / 86_400 == 18_931 { 0 } else { -3600 });
    assert_eq!(days(&amsterdam(&autumn).expect("autumn")), [(31, 25), (1, 1)]);
    let spring = rows((2021, 3, 28), 23, |at| if at % 86_400 < 7200 { 0 } else { 3600 });
    assert_eq!(days(&amsterdam(&spring).expect("spring")), [(28, 23)]);
    let error = amsterdam(&rows((2021, 3, 28), 24, |_| 0)).expect_err("never shown");
    assert!(error.contains("line 4: the clock of Europe/Amsterdam never shows this time"), "{error}");
}
