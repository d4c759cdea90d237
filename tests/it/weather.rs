//! Weather that is hard to replay, through an archive and the program: messages, exit codes, light
//! on receivers.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

use glam::DVec3;
use heliotile_builder::settings::BuildSettings;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::sun::Location as Place;

use crate::cli::failure;
use crate::scenes::{Site, ground, receiver, scene, site, v};

/// A lawn with one horizontal and four vertical receivers 20 m above it.
static LAWN: LazyLock<Site> = LazyLock::new(|| {
    let facing = [("up", DVec3::Z), ("n", DVec3::Y), ("e", DVec3::X), ("s", DVec3::NEG_Y), ("w", DVec3::NEG_X)];
    let receivers: Vec<_> = facing.iter().map(|(id, normal)| receiver(id, v(0.0, 0.0, 20.0), *normal)).collect();
    site(&scene(&ground(50.0, 0.0, 0), &[0.2]), &receivers, &BuildSettings::default())
});

pub fn data(name: &str) -> PathBuf {
    Path::new(crate::ROOT).join("tests/data/weather").join(name)
}

/// Writes a weather file of hourly rows; `light` gives GHI, DNI and DHI of a date and hour 0 to 23.
pub fn epw(place: &str, days: &[Date], light: impl Fn(Date, u32) -> [f64; 3]) -> String {
    let mut text = format!(
        "LOCATION,Town,S,Country,X,0,{place},0\nDESIGN CONDITIONS,0\nTYPICAL/EXTREME PERIODS,0\nGROUND TEMPERATURES,0\n\
         HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,\nCOMMENTS 2,\nDATA PERIODS,1,1,Data,Sunday,1/1,12/31\n"
    );
    for date in days {
        for hour in 0..24 {
            let [ghi, dni, dhi] = light(*date, hour);
            let Date { year, month, day } = date;
            text += &format!("{year},{month},{day},{},0,?,1,1,1,1,1,1,1,{ghi},{dni},{dhi}", hour + 1);
            text += ",1,1,1,1,1,1,1,1,1,1,1,1,1,1,999,1,999,1,1\n";
        }
    }
    text
}

/// Returns all days of a month, or of a year if `month` is 0.
pub fn days(year: i32, month: u32) -> Vec<Date> {
    let months = if month == 0 { 1..=12 } else { month..=month };
    months.flat_map(|m| (1..=31).filter_map(move |day| Date::new(year, m, day))).collect()
}

fn run(command: &str, table: &str, text: &str, rest: &str) -> Output {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let path = folder.path().join("table");
    fs::write(&path, text).expect("written");
    let mut program = Command::new(env!("CARGO_BIN_EXE_heliotile"));
    program.arg(command).arg(&LAWN.path).arg(table).arg(&path).args(rest.split_whitespace());
    program.output().expect("the program")
}

/// Returns the direct light of sun and sky on each receiver, by row label, and the warnings. Every
/// value must be finite and not negative.
pub fn replay(text: &str, rest: &str) -> (BTreeMap<(String, String), [f64; 2]>, String) {
    let output = run("replay", "--weather", text, rest);
    let warnings = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{warnings}");
    let mut rows = BTreeMap::new();
    for line in String::from_utf8_lossy(&output.stdout).lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let values: Vec<f64> = cells[2..].iter().map(|c| c.parse().expect("a number")).collect();
        assert!(values.len() == 7 && values.iter().all(|x| x.is_finite() && *x >= 0.0), "{line}");
        rows.insert((cells[0].into(), cells[1].into()), [values[0], values[1]]);
    }
    (rows, warnings)
}

fn at(rows: &BTreeMap<(String, String), [f64; 2]>, label: &str, id: &str) -> [f64; 2] {
    rows[&(label.to_string(), id.to_string())]
}

/// The PVGIS file whose rows are in UTC ends with exit code 0 and a warning that names a shift of
/// 40 min (the file's own comment, an offset of -0.8239 h in UTC, means 40.6) and RMSE 51 and 1
/// W/m2. With the zone that it names there is no warning, and the east wall gets 18 % less sun.
#[test]
fn pvgis_rows_in_utc_get_a_warning() {
    let text = fs::read_to_string(data("pvgis_4_days.epw")).expect("data");
    let (rows, warnings) = replay(&text, "--every month");
    for part in [
        "the sun 40 min after mid-interval",
        "(1.1 W/m2 RMSE against 51.2",
        "a time zone of 0.33 or a longitude of 18.0",
    ] {
        assert!(warnings.contains(part), "{warnings}");
    }
    let (mended, quiet) = replay(&text.replacen("8.000000,1,", "8.000000,0.33,", 1), "--every month");
    assert!(!quiet.contains("cos(z)"), "{quiet}");
    let change = at(&mended, "2009-03", "e")[0] / at(&rows, "2009-03", "e")[0];
    assert!((change - 0.823).abs() < 0.01, "{change} {warnings}");
}

/// In December at 72 N no row has sun; the sky's 3 W/m2 of two hours of twilight a day arrive whole
/// on the horizontal in all 62 (to 1e-5) under each of three skies, and every value is finite.
#[test]
fn polar_night_has_light_of_the_sky_alone() {
    let text =
        epw("72,15,1", &days(2019, 12), |_, hour| if (11..13).contains(&hour) { [3.0, 0.0, 3.0] } else { [0.0; 3] });
    for sky in ["perez", "uniform", "cie:12"] {
        let (rows, warnings) = replay(&text, &format!("--sky {sky}"));
        let flat: Vec<_> = rows.iter().filter(|((_, id), _)| id == "up").map(|(_, value)| *value).collect();
        let lit = flat.iter().filter(|[sun, sky]| *sun == 0.0 && (sky / 3.0 - 1.0).abs() < 1e-5).count();
        assert_eq!((flat.len(), lit, flat.iter().filter(|value| **value == [0.0; 2]).count()), (744, 62, 682), "{sky}");
        assert!(warnings.contains("744 of the 8760") && warnings.lines().count() == 1, "{warnings}");
    }
}

/// Under the midnight sun (78.2 N, 21 June, DNI 500 W/m2) all 24 hours have sun on the horizontal,
/// and the day's sums there and on four walls are those of the sun's path in steps of 1 min, to 0.3
/// %: the north wall, low sun in front, gets a third more than the south wall.
#[test]
fn the_midnight_sun_shines_24_hours() {
    let date = Date::new(2019, 6, 21).expect("a date");
    let place = Place::new(78.2, 15.6, 1.0, 0.0).expect("a site");
    let path: Vec<DVec3> = (0..1440).map(|i| place.sun(date, f64::from(i) + 0.5)).collect();
    let text = epw("78.2,15.6,1", &[date], |_, _| [9999.0, 500.0, 40.0]);
    let (rows, _) = replay(&text, "--steps 4");
    assert_eq!(rows.iter().filter(|((_, id), value)| id == "up" && value[0] > 90.0).count(), 24);
    let sum = |id: &str| rows.iter().filter(|((_, r), _)| r == id).map(|(_, value)| value[0]).sum::<f64>();
    for (id, normal) in [("up", DVec3::Z), ("n", DVec3::Y), ("e", DVec3::X), ("s", DVec3::NEG_Y), ("w", DVec3::NEG_X)] {
        let expected = path.iter().map(|sun| 500.0 / 60.0 * sun.dot(normal).max(0.0)).sum::<f64>();
        assert!((sum(id) / expected - 1.0).abs() < 0.003, "{id}: {} {expected}", sum(id));
    }
    assert!((sum("n") / sum("s") - 1.33).abs() < 0.02, "{} {}", sum("n"), sum("s"));
}

/// In Sydney at noon of 21 June the sun is in the north: the north wall gets 500 W/m2 x cos 32.7
/// deg, 421, within 1 %, the south wall none, and in the morning the east wall more than the west.
#[test]
fn in_sydney_the_noon_sun_is_in_the_north() {
    let date = Date::new(2019, 6, 21).expect("a date");
    let text = epw(
        "-33.87,151.21,10",
        &[date],
        |_, hour| if (8..16).contains(&hour) { [9999.0, 500.0, 50.0] } else { [0.0; 3] },
    );
    let (rows, _) = replay(&text, "--steps 4");
    let noon = |id| at(&rows, "2019-06-21T11:00+10:00", id)[0];
    assert!((noon("n") / 421.0 - 1.0).abs() < 0.01 && noon("s") == 0.0, "{} {}", noon("n"), noon("s"));
    let morning = |id| at(&rows, "2019-06-21T08:00+10:00", id)[0];
    assert!(morning("e") > 300.0 && morning("w") == 0.0);
}

/// A leap year of 8784 rows gives 366 days, 29 February among them, and no warning about its
/// length; the same year without that day is read as well, with 365.
#[test]
fn a_leap_year_has_366_days_without_a_warning() {
    let all = days(2020, 0);
    let without: Vec<Date> = all.iter().copied().filter(|d| (d.month, d.day) != (2, 29)).collect();
    for (days, count) in [(all, 366), (without, 365)] {
        let by_day = |_, hour| [9999.0, 0.0, if (9..15).contains(&hour) { 10.0 } else { 0.0 }];
        let (rows, warnings) = replay(&epw("40,-105,-7", &days, by_day), "--every day");
        let labels: Vec<&String> = rows.keys().filter(|(_, id)| id == "up").map(|(label, _)| label).collect();
        assert_eq!((labels.len(), labels.iter().any(|l| *l == "2020-02-29")), (count, count == 366));
        assert_eq!(warnings, "");
    }
}

/// Light before sunrise: DHI of 7 W/m2 with the sun down arrives whole on the horizontal (to 1e-5),
/// the walls that face where the sun will rise get more of it than those behind, and DNI of that
/// hour is left out, with a warning that counts 1 hour.
#[test]
fn twilight_keeps_dhi_and_leaves_dni_out() {
    let date = Date::new(2019, 3, 21).expect("a date");
    let text = epw("50,0,0", &[date], |_, hour| if hour == 5 { [7.0, 80.0, 7.0] } else { [0.0; 3] });
    let (rows, warnings) = replay(&text, "");
    let dawn = |id| at(&rows, "2019-03-21T05:00+00:00", id);
    assert_eq!(dawn("up")[0] + dawn("e")[0], 0.0);
    assert!((dawn("up")[1] / 7.0 - 1.0).abs() < 1e-5, "{:?}", dawn("up"));
    assert!(dawn("e")[1] > dawn("w")[1] && dawn("w")[1] > 1.0, "{:?} {:?}", dawn("e"), dawn("w"));
    assert!(
        warnings.contains("line 14 and on: DNI with the sun below the horizon in 1 hours, 0.080 kWh/m2"),
        "{warnings}"
    );
}

/// A DNI of 1,000,000 W/m2 at an altitude of 0.1 deg is DNI sin(0.1 deg), 1745 W/m2, on the
/// horizontal and DNI cos on the wall, each to 0.1 %, and nothing is infinite.
#[test]
fn a_huge_dni_at_the_horizon_stays_finite() {
    let text = "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\na,90,0.1,1000000,10\n";
    let output = run("replay", "--conditions", text, "");
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    let sun = |id: &str| -> f64 {
        let row = table.lines().find(|l| l.starts_with(&format!("a,{id},"))).expect("the receiver");
        assert!(row.split(',').skip(2).all(|c| c.parse::<f64>().is_ok_and(f64::is_finite)), "{row}");
        row.split(',').nth(2).and_then(|c| c.parse().ok()).expect("a number")
    };
    assert!((sun("up") / 1745.3 - 1.0).abs() < 1e-3 && (sun("e") / 1e6 - 1.0).abs() < 1e-3, "{table}");
    assert_eq!(sun("w"), 0.0);
}

/// EPW rows are in standard time whatever the header says about daylight saving: the same 72 hours
/// with and without give the same bytes.
#[test]
fn daylight_saving_is_ignored() {
    let text = fs::read_to_string(data("golden_3_days.epw")).expect("data");
    let saving =
        text.replacen("DAYLIGHT SAVINGS,No,0,0", "DAYLIGHT SAVINGS,Yes,2nd Sunday in March,1st Sunday in November", 1);
    assert_ne!(text, saving);
    let [plain, saving] = [text, saving].map(|t| run("replay", "--weather", &t, "").stdout);
    assert!(plain.len() > 72 * 5 * 20 && plain == saving);
}

/// GHI in kW/m2 under a name without a unit, and GHI on a clock that is eight hours off: each is
/// reported once, and neither is reported of the same days as they should be.
#[test]
fn faint_light_and_light_at_night_are_reported() {
    let days = days(2021, 6);
    let table = |share: f64, late: f64| {
        let mut text = "time,ghi\n".to_owned();
        for (date, hour) in days.iter().flat_map(|date| (0..24).map(move |hour| (date, hour))) {
            let ghi = share * (800.0 * ((f64::from(hour) - late - 5.5) / 13.0 * std::f64::consts::PI).sin()).max(0.0);
            text += &format!("{:04}-{:02}-{:02}T{hour:02}:00+01:00,{ghi:.4}\n", date.year, date.month, date.day);
        }
        text
    };
    for (share, late, faint, night) in [(1.0, 0.0, 0, 0), (0.001, 0.0, 1, 0), (1.0, 8.0, 0, 1)] {
        let output = run("replay", "-w", &table(share, late), "--every total --latitude 45 --longitude 8");
        let said = String::from_utf8_lossy(&output.stderr);
        let count = |part: &str| said.matches(part).count();
        assert_eq!(
            (count("if the file holds kW/m2"), count("with the sun below the horizon")),
            (faint, night),
            "{said}"
        );
    }
}

/// Without any light a file is refused with exit code 2 and the line; with GHI only it is replayed
/// with a warning that counts the hours with sun, 13 of 24, and the sum of sun and sky on the
/// horizontal is GHI to 1 W/m2.
#[test]
fn missing_light_is_refused_or_split_from_ghi() {
    let date = Date::new(2019, 3, 21).expect("a date");
    let output = run("replay", "--weather", &epw("50,0,0", &[date], |_, _| [9999.0; 3]), "");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("line 15: no row holds light") && message.contains("to fix"), "{message}");
    let ghi = epw("50,0,0", &[date], |_, hour| [if (7..17).contains(&hour) { 400.0 } else { 0.0 }, 9999.0, 9999.0]);
    let (rows, warnings) = replay(&ghi, "");
    assert!(warnings.contains("line 15 and on: missing DNI and DHI of 13 hours estimated from GHI"), "{warnings}");
    let [sun, sky] = at(&rows, "2019-03-21T12:00+00:00", "up");
    assert!((sun + sky - 400.0).abs() < 1.0 && sun > 90.0, "{sun} {sky}");
}

/// The four days of PVGIS as CSV, and as EPW with the shift that its warning names, given or found,
/// or with the zone of it, give the east wall the same sun within 1 %, 18 % less than without.
/// Stamps of the start in place of the end are an hour later.
#[test]
fn a_shift_or_a_zone_gives_the_same_sun() {
    let epw = fs::read_to_string(data("pvgis_4_days.epw")).expect("data");
    let csv = fs::read_to_string(data("pvgis_4_days.csv")).expect("data");
    let east = |text: &str, rest: &str| at(&replay(text, &format!("--every total {rest}")).0, "total", "e")[0];
    let (plain, right) = (east(&epw, ""), east(&csv, ""));
    assert!((right / plain - 0.823).abs() < 0.01, "{right} {plain}");
    for rest in ["--shift 40min", "--shift auto", "--time-zone +00:20", "--weather-stamp middle --shift 10min"] {
        let mended = east(&epw, rest);
        assert!((mended / right - 1.0).abs() < 0.01, "{rest}: {mended} {right}");
    }
    let hour = east(&epw, "--weather-stamp start") / east(&epw, "--shift 1h");
    assert!((hour - 1.0).abs() < 1e-9, "{hour}");
}

/// Weather and conditions compressed by gzip are read as they are, under any name; a file that
/// unpacks to 300 MiB, 800 times its size, and one that is cut off, are refused with exit code 2.
#[test]
fn packed_weather_is_read_and_bombs_are_refused() {
    let pack = |bytes: &[u8]| {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        std::io::Write::write_all(&mut packed, bytes).expect("packed");
        packed.finish().expect("packed")
    };
    let folder = tempfile::tempdir().expect("a scratch folder");
    let command = |command: &str, option: &str, bytes: &[u8]| {
        let path = folder.path().join("table.gz");
        fs::write(&path, bytes).expect("written");
        let mut program = Command::new(env!("CARGO_BIN_EXE_heliotile"));
        program.arg(command).arg(&LAWN.path).arg(option).arg(&path);
        program
    };
    let run = |verb: &str, option: &str, bytes: &[u8]| command(verb, option, bytes).output().expect("the program");
    let conditions = b"condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nnoon,180,50,800,100\n".as_slice();
    let weather = fs::read(data("golden_3_days.epw")).expect("data");
    for (command, option, bytes) in [("replay", "--conditions", conditions), ("replay", "--weather", &weather)] {
        let (plain, packed) = (run(command, option, bytes), run(command, option, &pack(bytes)));
        assert_eq!((plain.status.code(), packed.status.code()), (Some(0), Some(0)));
        assert!(plain.stdout.len() > 100 && plain.stdout == packed.stdout, "{command}");
    }
    let bomb = pack(&vec![b'0'; 1 << 20]).repeat(300);
    let whole = pack(&weather);
    for (bytes, expected) in [
        (bomb.as_slice(), "input out-of-range table.gz 268435457.0"),
        (&whole[..whole.len() / 2], "input damaged table.gz"),
    ] {
        assert_eq!(failure(&mut command("replay", "--weather", bytes)), expected);
    }
}

/// A CSV that does not state its place takes the place of the archive, with a note, and needs a
/// zone; with both, noon of 21 June at 52 N has 800 W/m2 x sin 61.4 deg on the horizontal, within
/// 0.5 %.
#[test]
fn a_csv_takes_the_place_of_the_archive() {
    let mut lawn = scene(&ground(50.0, 0.0, 0), &[0.2]);
    lawn.place = Some(heliotile_core::site::place::Place {
        latitude_deg: 52.0,
        longitude_deg: 4.3,
        convergence_deg: 0.0,
        epsg: None,
    });
    let archive = site(&lawn, &[receiver("up", v(0.0, 0.0, 20.0), DVec3::Z)], &BuildSettings::default());
    let folder = tempfile::tempdir().expect("a scratch folder");
    let csv = folder.path().join("station.csv");
    // Noon of the sun: 12 h - 4.3 / 15 h + 1.8 min.
    fs::write(&csv, "time,dni,dhi\n2021-06-21T11:40,800,0\n2021-06-21T11:50,800,0\n").expect("written");
    let command = |rest: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_heliotile"));
        program.args(["replay", "--columns", "sun_direct"]).arg(&archive.path).arg("--weather").arg(&csv).args(rest);
        program
    };
    assert_eq!(failure(&mut command(&[])), "input lacks station.csv time zone");
    let done = command(&["--time-zone", "UTC"]).output().expect("the program");
    let note = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(note.contains("the place of the scene is used: latitude 52.0000, longitude 4.3000"), "{note}");
    let table = String::from_utf8_lossy(&done.stdout).into_owned();
    let noon: f64 =
        table.lines().nth(1).and_then(|line| line.rsplit(',').next()).expect("a cell").parse().expect("W/m2");
    assert!((noon / (800.0 * 61.44_f64.to_radians().sin()) - 1.0).abs() < 0.005, "{table}");
}

/// Two clear days in seven layouts, with the ends of intervals, kW/m2, services' heads, a .wea file
/// and a zip archive, give the five sums of the plain table to 0.2 %. Dates of one day that can be
/// read in two ways end with exit code 2, and with `--date-order` they do not.
#[test]
fn seven_layouts_give_the_same_sums() {
    let place = ["--latitude", "40", "--longitude=-105", "--every", "total"];
    let replay = |file: &Path, rest: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_heliotile"));
        program.arg("replay").arg(&LAWN.path).arg("--weather").arg(file).args(place).args(rest);
        program
    };
    let sums = |name: &str| {
        let output = replay(&data(name), &[]).output().expect("the program");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{name}: {said}");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let cells = text
            .lines()
            .skip(1)
            .map(|line| line.split(',').skip(2).take(2).map(|cell| cell.parse::<f64>().expect("a number")).sum());
        cells.collect::<Vec<f64>>()
    };
    let right = sums("right_start.csv");
    assert_eq!(right.len(), 5);
    for name in
        ["period_end.csv", "open_meteo.csv", "unit_kw.csv", "tmy3_eighth_cell.csv", "town.wea", "weather_in_zip.zip"]
    {
        for (found, right) in sums(name).iter().zip(&right) {
            assert!((found / right - 1.0).abs() < 2e-3, "{name}: {found} {right}");
        }
    }
    let folder = tempfile::tempdir().expect("a scratch folder");
    let file = folder.path().join("day.csv");
    let rows = (0..24).fold("time,dni,dhi\n".to_owned(), |text, hour| text + &format!("01/06/2021 {hour:02}:00,1,1\n"));
    fs::write(&file, rows).expect("written");
    assert_eq!(failure(&mut replay(&file, &["--time-zone=-7"])), "input value day.csv:2 time 01/06/2021 00:00");
    assert!(replay(&file, &["--time-zone=-7", "--date-order", "dmy"]).status().is_ok_and(|status| status.success()));
}
