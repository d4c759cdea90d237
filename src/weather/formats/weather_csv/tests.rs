//! Tests of [`super`].

use std::path::{Path, PathBuf};

use crate::formats::weather_file::{parse_weather, parse_weather_as};
use crate::series::Weather;
use heliotile_core::error::Result;
use heliotile_core::weather::options::{StampedAt, TimeShift, WeatherOptions};
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::clock_zone::ClockZone;
use heliotile_core::weather::time::sun::Location;

/// Options with the place of the small files below.
const AT_NICE: WeatherOptions = WeatherOptions {
    latitude_deg: Some(43.7),
    longitude_deg: Some(7.3),
    zone: Some(ClockZone::Hours(1.0)),
    shift: TimeShift::Minutes(0.0),
    stamped_at: None,
    date_order: None,
    with_air: true,
};

fn read(text: &str, options: &WeatherOptions) -> Result<Weather> {
    parse_weather_as(Path::new("w.csv"), text.as_bytes(), options, &mut || Ok(None))
}

fn at_nice(text: &str) -> Result<Weather> {
    read(text, &AT_NICE)
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/weather").join(name)
}

fn file(name: &str, options: &WeatherOptions) -> Weather {
    let path = data(name);
    parse_weather_as(&path, &std::fs::read(&path).expect("data"), options, &mut || Ok(None)).expect("weather")
}

/// Returns a table with the hours of 1 March 2021 and these columns.
fn hours(names: &str, row: impl Fn(u32) -> String) -> String {
    (0..24).fold(format!("{names}\n"), |text, hour| text + &row(hour) + "\n")
}

/// One day in ten layouts, with names of pvlib, PVGIS and NSRDB, units, other separators, offsets
/// and parts of time, gives equal light, suns and labels, 24 hours of 24.
#[test]
fn ten_layouts_of_a_day_read_alike() {
    let plain =
        at_nice(&hours("time,ghi,dni,dhi", |h| format!("2021-03-01T{h:02}:00,{},{},50", 10 * h, h))).expect("valid");
    assert_eq!((plain.rows.len(), plain.interval_hours, plain.place.as_str()), (24, 1.0, "w.csv"));
    assert_eq!((plain.rows[9].ghi_w_m2, plain.rows[9].dni_w_m2, plain.rows[9].dhi_w_m2), (Some(90.0), 9.0, 50.0));
    let labels = |weather: &Weather| -> Vec<String> { weather.rows.iter().map(|row| row.interval.label()).collect() };
    assert_eq!((labels(&plain)[0].as_str(), labels(&plain)[23].as_str()), ("2021-03-01T00:00", "2021-03-01T23:00"));
    let light = |h: u32| format!("{},{},50", 10 * h, h);
    for (name, text) in [
        (
            "upper case, units",
            hours("Timestamp,GHI (W/m2),DNI [W/m^2],DHI_w_m2", |h| format!("2021-03-01 {h:02}:00:00,{}", light(h))),
        ),
        ("PVGIS names", hours("datetime,G(h),Gb(n),Gd(h)", |h| format!("20210301:{h:02}00,{}", light(h)))),
        ("no name", hours(",ghi,dni,dhi", |h| format!("2021-03-01 {h:02}:00,{}", light(h)))),
        ("offset", hours(",ghi,dni,dhi", |h| format!("2021-03-01 {h:02}:00+01:00,{}", light(h)))),
        (
            "UTC",
            hours(",ghi,dni,dhi", |h| {
                format!(
                    "2021-{}Z,{}",
                    if h == 0 { "02-28T23:00".into() } else { format!("03-01T{:02}:00", h - 1) },
                    light(h)
                )
            }),
        ),
        ("parts", hours("Year,Month,Day,Hour,Minute,GHI,DNI,DHI", |h| format!("2021,3,1,{h},0,{}", light(h)))),
        (
            "parts without minute",
            hours("x,year,month,day,hour,ghi,dni,dhi", |h| format!("{h},2021,3,1,{h},{}", light(h))),
        ),
        ("semicolons", hours("time;ghi;dni;dhi", |h| format!("2021-03-01T{h:02}:00;{}", light(h).replace(',', ";")))),
        (
            "tabs, byte order mark",
            hours("\u{feff}time\tghi\tdni\tdhi", |h| format!("2021-03-01T{h:02}:00\t{}", light(h).replace(',', "\t"))),
        ),
        (
            "comments, quotes",
            format!(
                "# made by hand\n{}",
                hours("\"time\",ghi,dni,dhi", |h| format!("\"2021-03-01T{h:02}:00\",{}\r", light(h)))
            ),
        ),
    ] {
        let other = at_nice(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(labels(&other), labels(&plain), "{name}");
        for (a, b) in plain.rows.iter().zip(&other.rows) {
            assert_eq!(
                (a.ghi_w_m2, a.dni_w_m2, a.dhi_w_m2, a.sun),
                (b.ghi_w_m2, b.dni_w_m2, b.dhi_w_m2, b.sun),
                "{name}"
            );
        }
    }
}

/// A stamp of 12:00 in steps of 10 minutes has the sun of 12:05, 12:00 and 11:55 if it is start,
/// middle and end, and 41 minutes later with a shift. The label is the start, and each row counts
/// to the day of its file: 5 of 5.
#[test]
fn stamps_are_start_middle_or_end_as_stated() {
    let site = Location::new(43.7, 7.3, 1.0, 0.0).expect("a site");
    let date = Date::new(2021, 6, 1).expect("a date");
    let text = "time,dni,dhi\n2021-06-01T12:00,1,1\n2021-06-01T12:10,1,1\n2021-06-01T12:20,1,1\n";
    for (stamped_at, shift_min, sun_min, label) in [
        (None, 0.0, 725.0, "2021-06-01T12:00"),
        (Some(StampedAt::Start), 0.0, 725.0, "2021-06-01T12:00"),
        (Some(StampedAt::Middle), 0.0, 720.0, "2021-06-01T11:55"),
        (Some(StampedAt::End), 0.0, 715.0, "2021-06-01T11:50"),
        (Some(StampedAt::Middle), 41.0, 761.0, "2021-06-01T12:36"),
    ] {
        let weather =
            read(text, &WeatherOptions { stamped_at, shift: TimeShift::Minutes(shift_min), ..AT_NICE }).expect("valid");
        let first = weather.rows[0];
        assert!((first.sun - site.sun(date, sun_min)).length() < 1e-12, "{label}");
        assert_eq!((first.interval.label().as_str(), first.interval.date), (label, date));
    }
    // The middle at midnight counts to the day of the stamp, the end to the day before it.
    let midnight = "time,dni,dhi\n2021-06-01T00:00,0,1\n2021-06-01T01:00,0,1\n";
    let of = |stamped_at| {
        let weather = read(midnight, &WeatherOptions { stamped_at: Some(stamped_at), ..AT_NICE }).expect("valid");
        (weather.rows[0].interval.date.day, weather.rows[0].interval.label())
    };
    assert_eq!(of(StampedAt::Middle), (1, "2021-05-31T23:30".into()));
    assert_eq!(of(StampedAt::End), (31, "2021-05-31T23:00".into()));
}

/// Days of Nice under a sky whose DNI is 700 W/m2 at the sun of 20 minutes after mid-interval are
/// found to need a shift of 20 minutes. With --shift auto the closure falls from over 15 W/m2 to
/// below 0.2. Stamps of the end that are declared as such need none.
#[test]
fn the_shift_of_time_stamps_is_found() {
    let site = Location::new(43.7, 7.3, 1.0, 0.0).expect("a site");
    let sky = |late_min: f64| {
        let mut text = "time,ghi,dni,dhi\n".to_owned();
        for day in 1..=20 {
            let date = Date::new(2021, 4, day).expect("a date");
            for quarter in 0..96_u32 {
                let sun = site.sun(date, f64::from(15 * quarter) + late_min);
                let dni = if sun.z > 0.05 { 700.0 } else { 0.0 };
                text += &format!("{},{},{dni},60\n", date.label(15 * quarter), 60.0 + dni * sun.z.max(0.0));
            }
        }
        text
    };
    let late = at_nice(&sky(27.5)).expect("valid").report;
    assert!(late.warnings.iter().any(|w| w.contains("shift 20min")), "{:?}", late.warnings);
    assert!(late.closure.expect("rows").rmse_w_m2 > 15.0);
    // Remedies are a longitude 5 degrees further, or a clock 20 minutes back. The second is none
    // where stamps state their zone.
    let ways = |text: &str| {
        let said = at_nice(text).expect("valid").report.told();
        ["a longitude of 12.3", "a time zone of 0.67", "time zone, longitude"].map(|way| said.contains(way))
    };
    assert_eq!(ways(&sky(27.5)), [true; 3]);
    assert_eq!(
        ways(
            &sky(27.5)
                .replace(":00,", ":00+01:00,")
                .replace(":15,", ":15+01:00,")
                .replace(":30,", ":30+01:00,")
                .replace(":45,", ":45+01:00,")
        ),
        [true, false, false]
    );
    let auto = read(&sky(27.5), &WeatherOptions { shift: TimeShift::Auto, ..AT_NICE }).expect("valid");
    assert_eq!(auto.moved_min, 20.0);
    let auto = auto.report;
    assert!(auto.closure.expect("rows").rmse_w_m2 < 0.2, "{:?}", auto.closure);
    assert!(auto.warnings[0].contains("moves time stamps by 20 min"), "{:?}", auto.warnings);
    let end = read(&sky(-7.5), &WeatherOptions { stamped_at: Some(StampedAt::End), ..AT_NICE }).expect("valid").report;
    assert!(end.closure.expect("rows").rmse_w_m2 < 0.01 && end.warnings.len() == 1, "{:?}", end.warnings);
}

/// Four days of PVGIS as CSV, in UTC at 0.1761 h after the stamps, and as EPW, moved by 40.566
/// minutes, have equal light and suns (to 1e-4), and the EPW's air within its rounding. The closure
/// of each is below 1.3 W/m2 and gives no warning.
#[test]
fn pvgis_gives_equal_light_as_csv_and_epw() {
    let with_air = WeatherOptions { with_air: true, ..WeatherOptions::default() };
    let csv = file("pvgis_4_days.csv", &with_air);
    let epw = file("pvgis_4_days.epw", &WeatherOptions { shift: TimeShift::Minutes(30.0 + 60.0 * 0.1761), ..with_air });
    assert_eq!((csv.rows.len(), epw.rows.len(), csv.site.zone_hours), (96, 96, 0.0));
    for (a, b) in csv.rows.iter().zip(&epw.rows) {
        assert!((a.sun - b.sun).length() < 1e-4, "line {}", a.line);
        let near = |x: f64, y: f64| (x - y).abs() <= 0.51;
        assert!(near(a.dni_w_m2, b.dni_w_m2) && near(a.dhi_w_m2, b.dhi_w_m2), "{a:?} {b:?}");
    }
    for (a, b) in csv.air.iter().zip(&epw.air) {
        let gap = |x: Option<f64>, y: Option<f64>| (x.expect("given") - y.expect("given")).abs();
        assert!(gap(a.dry_bulb_c, b.dry_bulb_c) < 0.06 && gap(a.infrared_w_m2, b.infrared_w_m2) < 0.6, "{a:?} {b:?}");
    }
    for weather in [&csv, &epw] {
        assert!(weather.report.closure.expect("rows").rmse_w_m2 < 1.3, "{:?}", weather.report.closure);
        assert_eq!(weather.report.warnings.len(), 1, "{:?}", weather.report.warnings);
    }
    // The row counts to the day of its stamp, although its hour starts before midnight.
    assert_eq!((csv.rows[0].interval.label().as_str(), csv.rows[0].interval.date.day), ("2009-03-21T23:40", 22));
}

/// Four days of NSRDB have a closure below 2 W/m2 with stamps at the middle, the default, and over
/// 10 with stamps at the start. The zenith angles of the file below 75 degrees are those of the sun
/// to 0.08, without refraction.
#[test]
fn stamps_of_nsrdb_are_the_middle() {
    let place = WeatherOptions {
        latitude_deg: Some(40.5137),
        longitude_deg: Some(-108.5449),
        zone: Some(ClockZone::Hours(-7.0)),
        ..WeatherOptions::default()
    };
    let weather = file("psm4_4_days.csv", &place);
    assert_eq!((weather.rows.len(), weather.interval_hours), (192, 0.5));
    assert!(weather.report.closure.expect("rows").rmse_w_m2 < 2.0, "{:?}", weather.report.closure);
    let start = file("psm4_4_days.csv", &WeatherOptions { stamped_at: Some(StampedAt::Start), ..place });
    assert!(start.report.closure.expect("rows").rmse_w_m2 > 10.0, "{:?}", start.report.closure);
    let text = std::fs::read_to_string(data("psm4_4_days.csv")).expect("data");
    let zeniths =
        text.lines().skip(1).map(|line| line.split(',').nth(22).expect("a cell").parse::<f64>().expect("degrees"));
    let high: Vec<_> = zeniths.zip(&weather.rows).filter(|(zenith, _)| *zenith < 75.0).collect();
    assert!(high.len() > 80 && high.iter().all(|(zenith, row)| (row.sun.z.acos().to_degrees() - zenith).abs() < 0.08));
    assert!(weather.rows.iter().all(|row| row.albedo.is_some()));
    // With the two lines above its names the file states place and zone itself.
    let head = "Source,Location ID,City,State,Country,Latitude,Longitude,Time Zone,Elevation,Local Time Zone,Version\n\
                NSRDB,149688,-,-,-,40.5137,-108.5449,-7,1820,-7,4.0\n";
    let rows = text.lines().fold(String::new(), |all, line| all + line.split_once(',').expect("cells").1 + "\n");
    let whole = parse_weather(Path::new("w.csv"), format!("{head}{rows}").as_bytes()).expect("valid");
    assert_eq!((whole.site.longitude_deg, whole.site.zone_hours, whole.site.elevation_m), (-108.5449, -7.0, 1820.0));
    assert!(
        whole.rows.iter().zip(&weather.rows).all(|(a, b)| (a.sun - b.sun).length() < 1e-5 && a.dni_w_m2 == b.dni_w_m2)
    );
}

/// Two hours of SURFRAD at San Luis Valley, in UTC, are 120 minutes around local noon. The sun of
/// each row is at the file's zenith angle within 0.3 degrees. Three flagged or missing values are
/// missing, and days one after the other in one file are one series.
#[test]
fn suns_agree_with_the_zenith_angles_of_surfrad() {
    let weather = file("surfrad_2_hours.dat", &WeatherOptions::default());
    assert_eq!((weather.rows.len(), weather.interval_hours, weather.place.as_str()), (120, 1.0 / 60.0, "Alamosa"));
    assert_eq!((weather.site.latitude_deg, weather.site.longitude_deg, weather.site.zone_hours), (37.7, -105.92, 0.0));
    assert_eq!(weather.rows[0].interval.label(), "2016-01-01T17:59");
    let text = std::fs::read_to_string(data("surfrad_2_hours.dat")).expect("data");
    for (line, row) in text.lines().skip(2).zip(&weather.rows) {
        let zenith: f64 = line.split_whitespace().nth(7).expect("a cell").parse().expect("degrees");
        assert!((row.sun.z.acos().to_degrees() - zenith).abs() < 0.3, "{zenith} {:?}", row.sun);
    }
    // -7 moves the clock, not the sun.
    let local = file(
        "surfrad_2_hours.dat",
        &WeatherOptions { zone: Some(ClockZone::Hours(-7.0)), ..WeatherOptions::default() },
    );
    assert_eq!((local.rows[0].interval.label().as_str(), local.site.zone_hours), ("2016-01-01T10:59", -7.0));
    assert!(local.rows.iter().zip(&weather.rows).all(|(a, b)| (a.sun - b.sun).length() < 1e-9));
    let lines: Vec<&str> = text.lines().collect();
    let twice = format!("{text}{}\n{}\n{}", lines[0], lines[1], lines[121].replace(" 19 59 ", " 20  0 "));
    assert_eq!(parse_weather(Path::new("w.dat"), twice.as_bytes()).expect("valid").rows.len(), 121);
    let broken = [("direct", 12, "-9999.9", 0), ("flag", 9, "1", 0), ("diffuse", 14, "-9999.9", 1)];
    let cells = |place: usize, word: &str, row: usize| {
        let mut words: Vec<&str> = lines[2 + row].split_whitespace().collect();
        words[place] = word;
        let changed = words.join(" ");
        let all =
            lines.iter().enumerate().map(|(i, line)| if i == 2 + row { changed.clone() } else { (*line).to_owned() });
        all.collect::<Vec<String>>().join("\n")
    };
    for (name, place, word, row) in broken {
        let weather = parse_weather(Path::new("w.dat"), cells(place, word, row).as_bytes()).expect(name);
        let whole = text.lines().count() - 2;
        let gaps = weather.report.warnings.iter().filter(|w| w.contains("missing")).count();
        assert_eq!(
            (weather.rows.len(), gaps),
            (whole, usize::from(name != "flag")),
            "{name} {:?}",
            weather.report.warnings
        );
        assert_eq!(weather.rows[row].ghi_w_m2.is_none(), name == "flag", "{name}");
    }
}

/// Light that is empty, NaN, -999 or 9999 is missing and is filled in as in an EPW file: DHI of 3
/// hours and DNI of 1, counted in two sentences. Snow in centimetres and albedo are taken, and
/// humidity gives the dew point.
#[test]
fn gaps_in_light_are_filled_and_counted() {
    let text = "time,ghi,dni,dhi,albedo,snow_depth,temp_air,relative_humidity,IR(h)\n\
                2021-06-01T10:00,600,500,,0.2,0,25,50,300\n\
                2021-06-01T11:00,700,500,NaN,0,12,25,50,\n\
                2021-06-01T12:00,700,500,-999,1.5,-1,25,,300\n\
                2021-06-01T13:00,700,9999,100,0.3,999,99.9,50,300\n";
    let weather = at_nice(text).expect("valid");
    let warnings = weather.report.told();
    for part in ["line 2 and on: missing DHI of 3 hours", "line 5 and on: missing DNI of 1 hours"] {
        assert!(warnings.contains(part), "{warnings}");
    }
    assert!(weather.rows.iter().all(|row| row.dni_w_m2 > 300.0 && row.dhi_w_m2 > 50.0));
    let albedos: Vec<Option<f64>> = weather.rows.iter().map(|row| row.albedo).collect();
    assert_eq!(albedos, [Some(0.2), None, None, Some(0.3)]);
    let snow: Vec<Option<f64>> = weather.rows.iter().map(|row| row.snow_depth_cm).collect();
    assert_eq!(snow, [Some(0.0), Some(12.0), None, None]);
    let dew: Vec<Option<i64>> = weather.air.iter().map(|air| air.dew_point_c.map(|c| c.round() as i64)).collect();
    assert_eq!(dew, [Some(14), Some(14), None, None]);
    assert_eq!(weather.air[1].infrared_w_m2, None);
}

/// Missing rows give a warning, 3 hours in 2 gaps, and the other rows keep their times. Months of a
/// typical year may jump in years, but only with their own clock.
#[test]
fn missing_rows_give_a_warning() {
    let rows = |stamps: &[&str]| stamps.iter().fold("time,dni,dhi\n".to_owned(), |all, stamp| all + stamp + ",1,1\n");
    let text =
        rows(&["2021-06-01T10:00", "2021-06-01T11:00", "2021-06-01T13:00", "2021-06-01T14:00", "2021-06-01T17:00"]);
    let weather = at_nice(&text).expect("valid");
    let told = weather.report.told();
    assert!(told.contains("line 4 and on: 3 rows (3.0 hours) are missing in 2 gaps"), "{told}");
    assert_eq!(weather.rows[4].interval.label(), "2021-06-01T17:00");
    let typical = rows(&["2018-01-31T22:00Z", "2018-01-31T23:00Z", "2007-02-01T00:00Z", "2007-02-01T01:00Z"]);
    let utc = read(&typical, &WeatherOptions { zone: None, ..AT_NICE }).expect("valid");
    assert!(utc.rows[2].interval.date.year == 2007 && utc.report.warnings.iter().all(|w| !w.contains("missing")));
    let moved = at_nice(&typical).expect_err("another clock").to_string();
    assert!(moved.contains("typical year") && moved.contains("leave time_zone out"), "{moved}");
}

/// Thirty-one wrong files are refused with the line, its content and what to do.
#[test]
fn wrong_files_are_refused_with_the_line() {
    let rows = |rows: &str| format!("time,ghi,dni,dhi\n2021-06-01T10:00,1,1,1\n2021-06-01T11:00,1,1,1\n{rows}");
    let late_by = |hours: &str| {
        "Latitude (decimal degrees): 45\nLongitude (decimal degrees): 8\nIrradiance Time Offset (h): ".to_owned()
            + hours
            + "\ntime(UTC),G(h),Gb(n),Gd(h)\n20090322:0000,0,0,0\n20090322:0100,0,0,0\n"
    };
    for (text, said) in [
        (String::new(), "the file is empty"),
        ("time,ghi\n".into(), "no weather rows"),
        ("time,ghi\n2021-06-01T10:00,1\n".into(), "no two rows in order of time"),
        ("a,b\n1,2\n".into(), "no column of time among `a,b`"),
        ("time,power\n2021-06-01T10:00,1\n".into(), "no column of light among `time,power`"),
        ("time,GHI,G(h)\n".into(), "columns `GHI` and `G(h)` are both GHI"),
        ("time,Gb(i),Gd(i)\n".into(), "ask PVGIS for hourly data of slope 0"),
        (rows("2021-06-01T11:00,1,1,1\n"), "line 4: the row has the time stamp of the row before, 2021-06-01T11:00"),
        (rows("2021-06-01T10:30,1,1,1\n"), "line 4: the row is stamped 2021-06-01T10:30, before"),
        (rows("2021-06-01T11:00,1,1,1\n"), "a clock with daylight saving repeats an hour"),
        (
            rows("2021-06-01T12:00,1,1,1\n2021-06-01T12:59,1,1,1\n"),
            "line 5: the row is stamped 2021-06-01T12:59, 59 min after",
        ),
        (rows("2021-06-01T12:00+01:00,1,1,1\n"), "line 4: some time stamps have an offset"),
        (rows("2021-06-31T12:00,1,1,1\n"), "line 4: column `time` holds `2021-06-31T12:00`"),
        (rows("06/01/2021 12:00,1,1,1\n"), "line 4: column `time` holds `06/01/2021 12:00`"),
        (rows("2021-06-01T12:00,1,1\n"), "line 4: the row has 3 columns instead of 4"),
        (rows("2021-06-01T12:00,x,1,1\n"), "line 4: column `ghi` holds `x`"),
        (rows("2021-06-01T12:00,1,inf,1\n"), "line 4: column `dni` holds `inf`"),
        (rows("2021-06-01T12:00,1,1,-98\n"), "line 4: column `dhi` holds `-98`"),
        ("time;ghi\n2021-06-01T10:00;1.000,5\n2021-06-01T11:00;1,5\n".into(), "line 2: column `ghi` holds `1.000,5`"),
        ("time,ghi\n2021-06-01,1\n2021-06-02,1\n".into(), "rows are 1440 min apart"),
        ("time,ghi\n2021-06-01T10:00:00,1\n2021-06-01T10:00:10,1\n".into(), "rows are 0.16666666666666666 min apart"),
        ("year,month,day,hour,ghi\n2021,2,30,1,1\n".into(), "line 2: year, month, day, hour and minute do not form"),
        ("year,month,day,hour,minute,ghi\n2021,2,3,24,30,1\n".into(), "line 2: year, month, day, hour and minute"),
        ("year,month,day,hour,minute,ghi\n2021,2,3,24,60,1\n".into(), "line 2: year, month, day, hour and minute"),
        ("year,month,day,hour,minute,ghi\n2021,2,3,9999,60,1\n".into(), "line 2: year, month, day, hour and minute"),
        (late_by("1e308"), "line 3: `Irradiance Time Offset` holds `1e308`"),
        (late_by("1e17"), "line 3: `Irradiance Time Offset` holds `1e17`, more than an hour"),
        (late_by("-1.01"), "line 3: `Irradiance Time Offset` holds `-1.01`"),
        (late_by("nan"), "line 3: `Irradiance Time Offset` holds `nan`"),
        ("Latitude (decimal degrees): north\n".into(), "line 1: `Latitude` holds `north`"),
        ("Latitude (decimal degrees): 45\nLongitude (decimal degrees): 8\n".into(), "no line of names"),
    ] {
        let message = at_nice(&text).map(drop).expect_err(said).to_string();
        assert!(message.starts_with("w.csv") && message.contains(said), "{said}: {message}");
    }
    let tilted = parse_weather(&data("pvgis_tilted.csv"), &std::fs::read(data("pvgis_tilted.csv")).expect("data"));
    let message = tilted.map(drop).expect_err("tilted").to_string();
    assert!(message.contains("slope 30 degrees") && message.contains("angle=0&components=1"), "{message}");
}

/// PVGIS' hourly data of slope 0 are beam and diffuse on the horizontal: DNI is computed from their
/// sum, and closes to 1e-9 W/m2.
#[test]
fn dni_is_computed_from_flat_pvgis() {
    let text =
        std::fs::read_to_string(data("pvgis_tilted.csv")).expect("data").replace("Slope: 30 deg.", "Slope: 0 deg. ");
    let weather = parse_weather(Path::new("w.csv"), text.as_bytes()).expect("valid");
    let row = weather.rows.iter().find(|row| row.ghi_w_m2 == Some(26.71 + 8.28)).expect("the morning's");
    let suns = weather.site.sunlit(&row.interval, row.sun.into(), 4);
    let cosine = suns.iter().map(|sun| sun.z).sum::<f64>() / 4.0;
    assert!(row.dhi_w_m2 == 8.28 && (row.dni_w_m2 * cosine - 26.71).abs() < 1e-9, "{row:?}");
    assert_eq!((weather.rows.len(), row.interval.label().as_str()), (14, "2016-01-01T07:40"));
}

/// A file without place or zone is refused with the option that gives it. The place of the scene is
/// used where it is known, with a warning.
#[test]
fn a_file_without_place_or_zone_is_refused() {
    let text = "time,dni,dhi\n2021-06-01T12:00,1,1\n2021-06-01T13:00,1,1\n";
    let nowhere = WeatherOptions { latitude_deg: None, longitude_deg: None, ..AT_NICE };
    for (options, said) in [
        (nowhere, "give latitude and longitude"),
        (WeatherOptions { latitude_deg: Some(43.7), ..nowhere }, "does not state its longitude"),
        (WeatherOptions { zone: None, ..AT_NICE }, "such as time_zone +00:00"),
        (WeatherOptions { zone: None, longitude_deg: Some(-105.0), ..AT_NICE }, "such as time_zone -07:00"),
        (WeatherOptions { latitude_deg: Some(95.0), ..AT_NICE }, "latitude is 95"),
    ] {
        let message = read(text, &options).map(drop).expect_err(said).to_string();
        assert!(message.contains(said), "{said}: {message}");
    }
    let scene =
        heliotile_core::site::place::Place { latitude_deg: 52.0, longitude_deg: 4.3, convergence_deg: 0.0, epsg: None };
    let mut place = || Ok(Some(scene));
    let weather = parse_weather_as(Path::new("w.csv"), text.as_bytes(), &nowhere, &mut place).expect("valid");
    assert_eq!((weather.site.latitude_deg, weather.site.longitude_deg), (52.0, 4.3));
    assert!(
        weather.report.warnings[0].contains("the place of the scene is used: latitude 52.0000"),
        "{:?}",
        weather.report.warnings
    );
}

/// Any cut of any of the four files, and changed bytes among their first 3000, are read or refused
/// without a panic: over 3000 tries.
#[test]
fn damaged_files_are_read_or_refused() {
    let mut tries = 0;
    for name in ["pvgis_4_days.csv", "psm4_4_days.csv", "surfrad_2_hours.dat", "pvgis_tilted.csv"] {
        let bytes = std::fs::read(data(name)).expect("data");
        let bytes = &bytes[..bytes.len().min(3000)];
        for at in (0..bytes.len()).step_by(3) {
            let mut noisy = bytes.to_vec();
            noisy[at] = (at * 37 % 256) as u8;
            for text in [&bytes[..at], &noisy] {
                tries += 1;
                if let Ok(weather) = parse_weather_as(Path::new(name), text, &AT_NICE, &mut || Ok(None)) {
                    let finite = |row: &heliotile_core::weather::row::WeatherRow| {
                        row.dni_w_m2.is_finite() && row.dhi_w_m2.is_finite() && row.sun.is_finite()
                    };
                    assert!(weather.rows.iter().all(finite) && weather.conditions(1).len() == weather.rows.len());
                }
            }
        }
    }
    assert!(tries > 3000, "{tries}");
}
