//! Longwave irradiance: closed forms through an archive, and the options of the program.

use std::collections::BTreeMap;
use std::fs;
use std::process::Output;

use glam::DVec3;
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::Archive;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::emission::Emission;

use crate::cli::{Folder, golden, stdout};
use crate::scenes::*;

/// Emission of a black body at 12.5 degrees Celsius, sigma 285.65^4, and below at 20, sigma
/// 293.15^4, W/m2.
const AT_12_5: f64 = 377.527_55;
const AT_20: f64 = 418.765_92;

/// Returns a cloudless night with ground at 12.5 degrees Celsius and walls at 20.
fn night() -> Condition {
    let emission = Emission { sky_w_m2: 300.0, ground_w_m2: AT_12_5, obstruction_w_m2: AT_20 };
    Condition { emission: Some(emission), ..sun(0.0, -20.0, 0.0, 0.0) }
}

/// Returns the longwave irradiance of each receiver in one condition.
fn longwave(site: &Site, condition: Condition) -> BTreeMap<String, f64> {
    let archive = Archive::open(&site.path).expect("an archive");
    let components = ComponentSet::new(&[Component::Longwave]);
    let settings = ReplaySettings { components, ..ReplaySettings::default() };
    let replay = Replay::new(&OpenSite::open(&archive).expect("a site"), &[condition], settings).expect("a replay");
    let tiles = replay.run(0..replay.tiles()).expect("tiles");
    let rows = tiles.into_iter().flat_map(|(ids, values)| {
        let row = |r: usize| f64::from(values.row(Component::Longwave, r)[0]);
        ids.into_iter().enumerate().map(|(r, id)| (id, row(r))).collect::<Vec<_>>()
    });
    rows.collect()
}

/// Under 300 W/m2 from an open sky, over endless ground at 12.5 degrees Celsius, a level receiver
/// gets 300 exactly (to 1e-6), a wall half of each (to 1e-4 of it), tilts in between (1 + cos) / 2
/// and (1 - cos) / 2 (to 3e-4). A receiver that looks down where the ground ends 3 m away gets the
/// emission of the ground, since rays that meet nothing count as ground.
#[test]
fn open_receivers_see_sky_and_ground_by_tilt() {
    let tilts = [0.0, 20.0, 37.0, 60.0, 90.0, 135.0, 180.0];
    let receivers: Vec<_> =
        tilts.iter().map(|&t| receiver(&format!("{t}"), v(3.3, 1.7, 2.0), tilted(t, 140.0))).collect();
    for half in [20_000.0, 5.0] {
        let scene = scene(&ground(half, 0.0, 0), &[0.2]);
        let found = longwave(&site(&scene, &receivers, &BuildSettings::default()), night());
        for tilt in tilts {
            let cos = tilt.to_radians().cos();
            let expected = 300.0 * (1.0 + cos) / 2.0 + AT_12_5 * (1.0 - cos) / 2.0;
            let tolerance = if tilt == 0.0 {
                1e-6
            } else if tilt == 90.0 {
                1e-4
            } else {
                3e-4
            };
            let error = found[&format!("{tilt}")] / expected - 1.0;
            println!("tilt {tilt} over {half} m: off by {error:.1e}");
            assert!(error.abs() < tolerance, "tilt {tilt} over {half} m: off by {error:.1e}");
        }
    }
}

/// Inside a closed box at 20 degrees Celsius every receiver gets sigma T^4 = 418.77 W/m2, to 1e-6
/// of it; in a box whose material is ground, 377.53.
#[test]
fn a_closed_box_radiates_sigma_t4() {
    for (material, expected) in [(1, AT_20), (0, AT_12_5)] {
        let scene = scene(&block(v(-4.0, -3.0, 0.0), v(5.0, 6.0, 7.0), material), &[0.9, 0.9]);
        let receivers = [
            receiver("up", v(0.1, 0.2, 1.0), DVec3::Z),
            receiver("side", v(0.1, 0.2, 3.0), tilted(70.0, 33.0)),
            receiver("down", v(0.1, 0.2, 3.0), DVec3::NEG_Z),
            receiver("wall", v(-4.0, 0.0, 3.0), DVec3::X),
        ];
        for (id, got) in longwave(&site(&scene, &receivers, &BuildSettings::default()), night()) {
            assert!((got / expected - 1.0).abs() < 1e-6, "{id}: {got} {expected}");
        }
    }
}

/// On the floor and four heights of a wall of a long canyon the sky's share is that of Hottel's
/// crossed strings, and so is the floor's share of a wall's view; walls make up the rest: all
/// within 0.3 W/m2 of 300 to 419.
#[test]
fn canyon_shares_are_those_of_crossed_strings() {
    let (width, height) = (20.0_f64, 15.0_f64);
    let heights = [1.0, 5.0, 10.0, 14.0];
    let mut receivers = vec![receiver("floor", v(0.0, 0.3, 0.0), DVec3::Z)];
    receivers.extend(heights.map(|h| receiver(&format!("{h}"), v(-10.0, 0.7, h), DVec3::X)));
    let found = longwave(&site(&scene(&canyon(width, height, 6000.0), &[0.3, 0.3]), &receivers, &fine()), night());
    let near = |id: &str, sky: f64, floor: f64| {
        let expected = 300.0 * sky + AT_12_5 * floor + AT_20 * (1.0 - sky - floor);
        println!("{id}: off by {:.2} W/m2", found[id] - expected);
        assert!((found[id] - expected).abs() < 0.3, "{id}: {} {expected}", found[id]);
    };
    near("floor", (width / 2.0) / (width * width / 4.0 + height * height).sqrt(), 0.0);
    for h in heights {
        let share = |over: f64| (1.0 - over / (over * over + width * width).sqrt()) / 2.0;
        near(&format!("{h}"), share(height - h), share(h));
    }
}

/// Builds the site of the command line's tests with areas and surfaces: a roof and a wall whose
/// lower half of the view is ground.
fn town() -> Folder {
    let folder = Folder::new();
    let rows = "roof,5,5,10.02,0,0,1,1,top\nlow,5,-0.02,2,0,-1,0,1,front\nhigh,5,-0.02,8,0,-1,0,3,front\n";
    folder.write("receivers.csv", &format!("receiver,x,y,z,nx,ny,nz,area,surface\n{rows}"));
    assert_eq!(folder.build().status.code(), Some(0));
    folder
}

fn replay(folder: &Folder, rest: &str) -> Output {
    let output = folder.run(&format!("replay site.helio --weather {} {rest}", golden().display()));
    assert_eq!(output.status.code(), Some(0), "{rest}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Parses values by time and receiver.
fn table(text: &str) -> BTreeMap<(String, String), Vec<f64>> {
    let row = |line: &str| {
        let mut cells = line.split(',').map(str::to_string);
        let key = (cells.next().unwrap_or_default(), cells.next().unwrap_or_default());
        (key, cells.map(|cell| cell.parse().expect("a number")).collect())
    };
    text.lines().skip(1).map(row).collect()
}

fn key(time: &str, place: &str) -> (String, String) {
    (time.to_string(), place.to_string())
}

/// The open roof gets the file's infrared radiation in each of 72 hours, 237 W/m2 in the first. A
/// wall gets half of it and half of sigma T^4, of the air's -5.7 degrees Celsius or of 12.5 given
/// for the ground. The total beside the column is that without it, to the last digit, and brighter
/// ground changes the total alone.
#[test]
fn hours_hold_the_infrared_of_the_weather_file() {
    let folder = town();
    let text = fs::read_to_string(golden()).expect("weather");
    let infrared: Vec<f64> =
        text.lines().skip(8).filter_map(|l| l.split(',').nth(12)).map(|c| c.parse().expect("a number")).collect();
    let plain = stdout(&replay(&folder, "--columns longwave,total"));
    assert!(plain.starts_with("time,receiver,longwave,total\n"), "{plain}");
    let roof: Vec<f64> =
        plain.lines().filter(|l| l.contains(",roof,")).filter_map(|l| l.split(',').nth(2)?.parse().ok()).collect();
    assert_eq!((roof.len(), infrared[0]), (72, 237.0));
    assert!(roof.iter().zip(&infrared).all(|(got, given)| (got - given).abs() < 1e-3));
    let (whole, all) = (table(&plain), table(&stdout(&replay(&folder, ""))));
    assert_eq!(all.len(), 216);
    assert!(all.iter().all(|(place, values)| values.len() == 7 && whole[place][1] == values[6]));

    let bright = table(&stdout(&replay(&folder, "--columns longwave,total --reflectance ground=0.9")));
    let summed = |rows: &BTreeMap<(String, String), Vec<f64>>, i: usize| rows.values().map(|row| row[i]).sum::<f64>();
    assert!(bright.iter().all(|(place, values)| values[0] == whole[place][0]));
    assert!(summed(&bright, 1) > 1.1 * summed(&whole, 1));

    let first = key("1998-03-20T00:00-07:00", "low");
    let air = 5.670_374_419e-8 * (273.15_f64 - 5.7).powi(4);
    let expected = 0.5 * 237.0 + 0.5 * air;
    assert!((whole[&first][0] - expected).abs() < 0.1, "{:?} {expected}", whole[&first]);
    let warm =
        table(&stdout(&replay(&folder, "--columns longwave --temperature obstruction=-40 --temperature ground=12.5")));
    let expected = 0.5 * 237.0 + 0.5 * AT_12_5;
    assert!((warm[&first][0] - expected).abs() < 0.1, "{:?} {expected}", warm[&first]);
}

/// Sums of days are those of their 24 hours (to 1e-5), sums of a span those of its hours. Means of
/// surfaces are weighted by areas of 1 and 3. A schedule of twelve months and one of 72 equal rows
/// give the results of a constant, and receivers can be chosen: 2 of 3.
#[test]
fn sums_of_longwave_are_those_of_its_hours() {
    let folder = town();
    let hours = table(&stdout(&replay(&folder, "--columns longwave --temperature ground=12.5")));
    let text = stdout(&replay(&folder, "--columns longwave --temperature ground=12.5 --every day"));
    assert!(text.starts_with("time,receiver,longwave_kwh_m2\n"), "{text}");
    let days = table(&text);
    assert_eq!((hours.len(), days.len()), (216, 9));
    for ((day, id), sum) in &days {
        let of_day = hours.iter().filter(|((time, place), _)| place == id && time.starts_with(day.as_str()));
        let expected = of_day.map(|(_, values)| values[0]).sum::<f64>() / 1000.0;
        assert!((sum[0] / expected - 1.0).abs() < 1e-5, "{day} {id}: {} {expected}", sum[0]);
    }
    let every = |rest: &str| table(&stdout(&replay(&folder, &format!("--columns longwave {rest}"))));
    let span = every("--temperature ground=12.5 --every total --from 03-21");
    let two = days[&key("1998-03-21", "high")][0] + days[&key("1998-03-22", "high")][0];
    assert!((span[&key("total", "high")][0] / two - 1.0).abs() < 1e-5, "{span:?} {two}");
    let surfaces = every("--temperature ground=12.5 --every day --by surface");
    assert_eq!(surfaces.len(), 6);
    let mean = 0.25 * days[&key("1998-03-20", "low")][0] + 0.75 * days[&key("1998-03-20", "high")][0];
    assert!((surfaces[&key("1998-03-20", "front")][0] / mean - 1.0).abs() < 1e-5, "{surfaces:?} {mean}");

    folder.write("months.csv", &format!("temperature_c\n{}", "12.5\n".repeat(12)));
    folder.write("rows.csv", &format!("time,temperature_c\n{}", "x,12.5\n".repeat(72)));
    for file in ["months.csv", "rows.csv"] {
        assert_eq!(every(&format!("--temperature ground=0 --temperature ground={file}")), hours, "{file}");
    }
    folder.write("few.csv", "receiver\nlow\nroof\n");
    let few = every("--temperature ground=12.5 --receivers few.csv");
    assert!(few.len() == 144 && few.iter().all(|(place, values)| hours[place] == *values));
}

/// All 6 formats hold the column; arrays of NumPy hold the 216 values of the CSV to 3 decimals, by
/// receiver and hour.
#[test]
fn all_formats_hold_the_longwave_column() {
    let folder = town();
    for ending in ["csv", "parquet", "arrow", "feather", "npy", "npz"] {
        replay(&folder, &format!("--columns sky_direct,longwave -o t.{ending}"));
        let bytes = fs::read(folder.path(&format!("t.{ending}"))).expect("a table");
        let named = |bytes: &[u8]| bytes.windows(8).any(|part| part == b"longwave");
        // An .npz writes names as UTF-32.
        let wide: Vec<u8> = "longwave".bytes().flat_map(|b| [b, 0, 0, 0]).collect();
        let listed = match ending {
            "npy" => named(&fs::read(folder.path("t.axes.json")).expect("axes")),
            "npz" => bytes.windows(32).any(|part| part == wide),
            _ => named(&bytes),
        };
        assert!(listed, "{ending}");
    }
    let text = fs::read_to_string(folder.path("t.csv")).expect("a table");
    let written: Vec<f64> = text.lines().skip(1).filter_map(|l| l.rsplit(',').next()?.parse().ok()).collect();
    let bytes = fs::read(folder.path("t.npy")).expect("an array");
    let values: Vec<f64> = bytes[bytes.len() - 216 * 8..]
        .chunks_exact(8)
        .map(|pair| f64::from(f32::from_le_bytes([pair[4], pair[5], pair[6], pair[7]])))
        .collect();
    assert_eq!((written.len(), values.len()), (216, 216));
    assert!(written.iter().zip(&values).all(|(a, b)| *b > 200.0 && (a - b).abs() <= 0.000_6));
}

/// Writes Golden's three days with a column of the file overwritten in some of its 72 rows.
fn weather(folder: &Folder, name: &str, cells: &[(usize, &str)], rows: std::ops::Range<usize>) {
    let text = fs::read_to_string(golden()).expect("weather");
    let lines = text.lines().enumerate().map(|(i, line)| {
        let mut row: Vec<&str> = line.split(',').collect();
        for (column, value) in cells.iter().filter(|_| i >= 8 && rows.contains(&(i - 8))) {
            row[*column] = value;
        }
        row.join(",") + "\n"
    });
    folder.write(name, &lines.collect::<String>());
}

/// Without infrared radiation 24 hours are computed from temperatures and clouds, within 0.6 W/m2
/// of the file's, and a warning counts them. Without dew points the row is named with the missing
/// value. A part of the file that has them is replayed, and without the column the whole file is,
/// without a message about it.
#[test]
fn missing_infrared_is_computed_with_a_warning() {
    let folder = town();
    weather(&folder, "gone.epw", &[(12, "9999")], 24..48);
    let run =
        |file: &str, rest: &str| folder.run(&format!("replay site.helio --weather {file} --receivers roof.csv {rest}"));
    folder.write("roof.csv", "receiver\nroof\n");
    let computed = run("gone.epw", "--columns longwave");
    let said = String::from_utf8_lossy(&computed.stderr).into_owned();
    assert!(said.contains("line 33 and on: missing infrared radiation of 24 hours computed from dry bulb"), "{said}");
    let (got, given) = (table(&stdout(&computed)), table(&stdout(&replay(&folder, "--columns longwave"))));
    assert_eq!(got.len(), 72);
    assert!(got.iter().all(|(place, values)| (values[0] - given[place][0]).abs() < 0.6));
    assert!(got.iter().filter(|(place, values)| values[0] != given[*place][0]).count() > 20);

    weather(&folder, "both.epw", &[(12, "9999"), (7, "99.9"), (23, "99")], 24..48);
    let replay = "replay site.helio --weather both.epw";
    folder.fails(&format!("{replay} --columns longwave"), "input lacks both.epw:33 infrared");
    assert_eq!(table(&stdout(&run("both.epw", "--columns longwave --to 03-20"))).len(), 24);
    let light = run("both.epw", "--columns total");
    let said = String::from_utf8_lossy(&light.stderr).into_owned();
    assert!(light.status.code() == Some(0) && !said.contains("infrared"), "{said}");
}

/// Infrared radiation is read only for the column: a value of `x` is replayed with exit code 0
/// without it, and refused with it. 9 wrong requests end with exit code 2.
#[test]
fn infrared_is_checked_only_if_requested() {
    let folder = town();
    weather(&folder, "word.epw", &[(12, "x")], 5..6);
    assert_eq!(folder.run("replay site.helio --weather word.epw --every day").status.code(), Some(0));
    let word = "replay site.helio --weather word.epw --columns longwave";
    folder.fails(word, "input value word.epw:14 horizontal infrared radiation x");
    weather(&folder, "cold.epw", &[(6, "99.9")], 5..6);
    let cold = "replay site.helio --weather cold.epw --columns longwave";
    folder.fails(&format!("{cold} --temperature ground=5"), "input lacks cold.epw:14 temperature");
    let given = folder.run(&format!("{cold} --temperature ground=5 --temperature obstruction=5"));
    assert_eq!(given.status.code(), Some(0));

    folder.fails(
        "replay site.helio -c conditions.csv --columns longwave",
        "unsupported conditions, which have no infrared radiation and no temperatures",
    );
    folder.write("short.csv", "temperature_c\n5\n");
    folder.write("kelvin.csv", &format!("temperature_c\n{}", "285.65\n".repeat(12)));
    folder.write("other.csv", &format!("reflectance\n{}", "0.5\n".repeat(12)));
    let replay = format!("replay site.helio --weather {}", golden().display());
    folder.fails(&format!("{replay} --temperature ground=5"), "argument needs --temperature --columns");
    for (rest, expected) in [
        ("roof=5", "argument unreadable --temperature roof=5"),
        ("ground=285.65", "argument unreadable --temperature ground=285.65"),
        ("ground=none.csv", "missing-file none.csv"),
        ("ground=short.csv", "input out-of-range short.csv 1.0"),
        ("ground=kelvin.csv", "input value kelvin.csv:2 temperature_c 285.65"),
        ("ground=other.csv", "input no-column other.csv:1 temperature_c"),
    ] {
        folder.fails(&format!("{replay} --columns longwave --temperature {rest}"), expected);
    }
    folder.fails(
        &format!("{replay} --columns longwave --temperature ground=short.csv -o short.csv"),
        "input same-file short.csv short.csv",
    );
}
