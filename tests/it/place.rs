//! Places of sites: suns by true north, stated places, impossible units and places.

use std::path::Path;

use heliotile_core::site::place::Place;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::sun::Location;
use heliotile_scene::Scene;

use crate::cli::{Folder, golden, stderr, stdout};

/// Angle from true north to grid north at the western edge of UTM zone 32, at 54 N 6.2 E, degrees
/// (PROJ by pyproj 3.7.2).
const CONVERGENCE_DEG: f64 = -2.26587;
const AT: [f64; 2] = [316_483.8, 5_987_150.6];

/// Writes a meadow of 60 m, and a receiver 5 m above it that looks to true south.
fn southern(folder: &Folder) {
    let [x, y] = AT;
    let corner = |dx: f64, dy: f64| format!("v {:.1} {:.1} 0\n", x + dx, y + dy);
    let corners = [corner(-30., -30.), corner(30., -30.), corner(30., 30.), corner(-30., 30.)].concat();
    folder.write("meadow.obj", &format!("{corners}usemtl grass\nf 1 2 3 4\n"));
    let south = (180.0 - CONVERGENCE_DEG).to_radians();
    folder.write(
        "south.csv",
        &format!("receiver,x,y,z,nx,ny,nz\nsouth,{x},{y},5,{:.9},{:.9},0\n", south.sin(), south.cos()),
    );
}

/// Suns of midsummer three hours before and after solar noon give a wall that looks to true south
/// the same light, to 0.01 degrees of its turn. With grid north taken for true north they are off
/// by the 2.27 degrees between the two, to 0.01 degrees.
#[test]
fn south_is_symmetric_about_solar_noon() {
    let folder = Folder::new();
    southern(&folder);
    let site = Location::new(54.0, 6.2, 0.0, 0.0).expect("a site");
    let date = Date::new(2024, 6, 21).expect("a date");
    let (mut before, mut behind) = (600.0, 800.0);
    for _ in 0..50 {
        let middle = 0.5 * (before + behind);
        if site.sun(date, middle).x > 0.0 { before = middle } else { behind = middle }
    }
    let suns = [before - 180.0, before + 180.0].map(|minutes| site.sun(date, minutes));
    let azimuth = |i: usize| suns[i].x.atan2(suns[i].y).to_degrees().rem_euclid(360.0);
    let row = |i: usize| format!("{i},{:.6},{:.6},10000,0\n", azimuth(i), suns[i].z.asin().to_degrees());
    let header = "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\n";
    folder.write("suns.csv", &format!("{header}{}{}", row(0), row(1)));
    let built = folder.run("build meadow.obj --crs EPSG:25832 -r south.csv -o s.helio");
    assert_eq!(built.status.code(), Some(0), "{}", stderr(&built));
    assert!(
        stderr(&built).contains("note: the y axis points 2.27 degrees west of true north in EPSG:25832: suns"),
        "{}",
        stderr(&built)
    );
    let turn_deg = |options: &str| {
        let output = folder.run(&format!("replay s.helio -c suns.csv --columns sun_direct{options}"));
        let said = stderr(&output).contains("the y axis points 2.27 degrees west of true north");
        assert_eq!(said, options.is_empty(), "{}", stderr(&output));
        let table = stdout(&output);
        let values = table.lines().skip(1).map(|line| line.rsplit(',').next().and_then(|v| v.parse::<f64>().ok()));
        let values: Vec<f64> = values.map(|value| value.expect("a number")).collect();
        let [morning, evening] = values[..] else { panic!("{table}") };
        // The results are cos(a - c) and cos(a + c), with azimuths a to both sides of the wall's
        // normal, which is off by c.
        let off = (morning - evening) / (morning + evening);
        (off / (azimuth(1) - 180.0).to_radians().tan()).atan().to_degrees()
    };
    let (corrected, grid) = (turn_deg(""), turn_deg(" --grid-north"));
    assert!(corrected.abs() < 0.01, "{corrected}");
    assert!((grid.abs() - CONVERGENCE_DEG.abs()).abs() < 0.01, "{grid}");
}

/// `info` states the place of a scene and of its archive in the same words, with 2.27 degrees, and
/// for a scene without one the options to give. An archive accepts no other place.
#[test]
fn info_states_the_place() {
    let folder = Folder::new();
    southern(&folder);
    let unknown = stdout(&folder.run("info meadow.obj"));
    assert!(unknown.contains("place       not known, y is taken for north: give --crs"), "{unknown}");
    let words = "place       latitude 54.0000, longitude 6.2000, y 2.27 degrees west of true north, EPSG:25832";
    let scene = stdout(&folder.run("info meadow.obj --crs 25832"));
    assert!(scene.contains(words), "{scene}");
    folder.run("build meadow.obj --crs 25832 -r south.csv -o s.helio");
    assert!(stdout(&folder.run("info s.helio")).contains(words));
    folder.fails("info s.helio --crs 25832", "input other-kind s.helio archive");
    let turned = stdout(&folder.run("info meadow.obj --latitude 54 --longitude 6.2 --rotate-deg -30"));
    assert!(turned.contains("y 30.00 degrees west of true north\n"), "{turned}");
    assert!(turned.contains("rotation    -30 degrees clockwise"), "{turned}");
}

/// An archive whose place was stated by an option is repaired, after one byte of its materials was
/// changed, to its bytes without the option, 2 of 2, the second one from a list that states a turn
/// and no place. The 3 options of a place are refused; options that change coordinates are not.
#[test]
fn repair_keeps_the_place() {
    let folder = Folder::new();
    southern(&folder);
    folder.write("turned.toml", "[site]\nrotate_deg = 30\n[[scene]]\nfile = \"meadow.obj\"\n");
    for (scene, place) in [("meadow.obj", "--crs 25832"), ("turned.toml", "--latitude 54 --longitude 6.2")] {
        repaired(&folder, scene, place);
    }
    for options in ["--crs 25832", "--latitude 54 --longitude 6.2", "--rotate-deg 30"] {
        folder.fails(&format!("archive repair s.helio meadow.obj {options}"), "input other-kind s.helio archive");
    }
    let scaled = folder.run("archive repair s.helio meadow.obj --scale 1 --elevation 0");
    assert_eq!(scaled.status.code(), Some(0), "{}", stderr(&scaled));
}

fn repaired(folder: &Folder, scene: &str, place: &str) {
    let built = folder.run(&format!("build {scene} {place} -r south.csv -o s.helio"));
    assert_eq!(built.status.code(), Some(0), "{}", stderr(&built));
    let whole = std::fs::read(folder.path("s.helio")).expect("built");
    let archive = heliotile_core::archive::Archive::open(&folder.path("s.helio")).expect("an archive");
    let entry = archive.entries_of(heliotile_core::archive::format::MATERIALS)[0];
    let at = entry.offset as usize + 3;
    drop(archive);
    let mut bad = whole.clone();
    bad[at] ^= 1;
    std::fs::write(folder.path("s.helio"), &bad).expect("written");
    let repaired = folder.run(&format!("archive repair s.helio {scene} -r south.csv"));
    assert_eq!(repaired.status.code(), Some(0), "{}", stderr(&repaired));
    assert!(std::fs::read(folder.path("s.helio")).expect("repaired") == whole);
}

/// Seven wrong options are refused.
#[test]
fn wrong_place_options_are_refused() {
    let folder = Folder::new();
    for (options, expected) in [
        ("--crs 4326", "argument unreadable --crs 4326"),
        ("--crs RD", "argument unreadable --crs RD"),
        ("--crs EPSG:99999", "argument unreadable --crs EPSG:99999"),
        ("--latitude 95 --longitude 5", "argument out-of-range --latitude 95.0"),
        ("--latitude 52", "argument missing --longitude"),
        ("--rotate-deg 20", "argument needs --rotate-deg --latitude,--longitude"),
        ("--scale 0", "argument unreadable --scale 0"),
    ] {
        folder.fails(&format!("info scene.obj {options}"), expected);
    }
}

/// A second `run` with another turn is refused, and traces again with `--replace`; a third one with
/// the same turn does not. Sides of its table go by true north: a model that is turned by 90
/// degrees has its wall towards -y in the west.
#[test]
fn a_run_with_another_turn_is_refused() {
    let folder = Folder::new();
    let weather = Path::new(crate::ROOT).join("tests/data/weather/golden_3_days.epw");
    let command = |turn: u32| {
        let at = format!("--latitude 39.74 --longitude -105.18 --rotate-deg {turn}");
        format!("run scene.obj -m materials.toml -r receivers.csv --weather {} {at} -o sun", weather.display())
    };
    let run = |turn: u32| {
        let output = folder.run(&format!("{} --replace", command(turn)));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stdout(&output)
    };
    let first = run(0);
    assert!(first.contains("upright, south") && !first.contains("upright, west"), "{first}");
    folder.fails(&command(90), "input other-inputs sun");
    let turned = run(90);
    assert!(!turned.contains("up to date"), "{turned}");
    assert!(turned.contains("upright, west") && !turned.contains("upright, south"), "{turned}");
    assert!(run(90).contains("up to date"));
}

/// For receivers 90 km from the scene `plan` gives a warning with the distance and a guess; for a
/// house in millimetres `info` does, and `receivers` refuses its area, with a spacing and the unit.
#[test]
fn wrong_places_and_units_are_reported_before_work() {
    let folder = Folder::new();
    folder.write("far.csv", "receiver,x,y,z,nx,ny,nz\na,90000,5,1,0,0,1\nb,90001,5,1,0,0,1\n");
    let plan = stderr(&folder.run("build --dry-run scene.obj -m materials.toml -r far.csv"));
    assert!(plan.contains("far.csv: all 2 receivers lie far from the scene"), "{plan}");
    assert!(plan.contains("is 90 km from the scene"), "{plan}");
    folder.write("far_scene.obj", "v 78000 457000 0\nv 78009 457000 0\nv 78009 457009 0\nusemtl a\nf 1 2 3\n");
    folder.write("swapped.csv", "receiver,x,y,z,nx,ny,nz\na,457001,78001,1,0,0,1\n");
    folder.fails("build far_scene.obj -r swapped.csv -o a.helio", "input misplaced swapped.csv");
    let scene = std::fs::read_to_string(folder.path("scene.obj")).expect("written").replace('0', "0000");
    folder.write("mm.obj", &scene);
    let told = stderr(&folder.run("info mm.obj"));
    assert!(told.contains("warning: mm.obj: walls are") && told.contains("give --scale 0.001"), "{told}");
    folder.fails("receivers mm.obj", "argument out-of-range --spacing 125000000.0");
    let scaled = folder.run("receivers mm.obj --scale 0.001 -o r.csv");
    assert!(stdout(&scaled).contains("125 receivers on 5 surfaces"), "{} {}", stdout(&scaled), stderr(&scaled));
}

/// No scene of the tests, 7 files of 5 kinds, gets a warning about its unit or place.
#[test]
fn good_scenes_get_no_warning_about_their_place() {
    let data = Path::new(crate::ROOT).join("tests/data");
    let files = [
        "cityjson/hague.city.json",
        "cityjson/small.city.jsonl",
        "cityjson/vegetation_templates.city.jsonl",
        "energyplus/box.epJSON",
        "energyplus/box.idf",
        "hague/scene.obj",
        "terrain/lakes_basin.tif",
    ];
    for file in files {
        let scene = Scene::load(&data.join(file), None).expect(file);
        for warning in &scene.report.warnings {
            let words = ["--scale", "degrees", "lies", "km from", "on the ground", "--elevation"];
            assert!(!words.iter().any(|word| warning.contains(word)), "{file}: {warning:?}");
        }
        let somewhere: Option<Place> = scene.place;
        assert!(somewhere.is_none_or(|place| place.convergence_deg.abs() < 3.0), "{file}");
    }
}

/// A result is a table of points: at 54 N 6.2 E, where y lies 2.27 degrees west of true north, five
/// receivers of `replay --positions` are built again, and four points of `pv` are given again. All
/// sums are equal to the last digit, the azimuths are those that were asked for, and a wall with
/// azimuth 180 looks to true south. By `--grid-north` the same table looks along the axes.
#[test]
fn rows_of_results_are_read_as_points() {
    let folder = Folder::new();
    southern(&folder);
    let [x, y] = AT;
    let rows = [(30.0, 180.0), (90.0, 180.0), (90.0, 93.5), (0.0, 0.0), (135.0, 271.25)];
    let row = |(i, (tilt, azimuth)): (usize, &(f64, f64))| {
        format!("r{i},{},{y},{},{tilt},{azimuth}\n", x + i as f64, 2.1 + 0.7 * i as f64)
    };
    let text: String = rows.iter().enumerate().map(row).collect();
    folder.write("asked.csv", &format!("receiver,x,y,z,tilt_deg,azimuth_deg\n{text}"));
    let weather = golden();
    let build = |table: &str, archive: &str, rest: &str| {
        let built =
            folder.run(&format!("build meadow.obj --crs EPSG:25832 -r {table} -o {archive} --quality draft {rest}"));
        assert_eq!(built.status.code(), Some(0), "{}", stderr(&built));
        let table = folder.run(&format!("replay {archive} -w {} --every total --positions", weather.display()));
        assert_eq!(table.status.code(), Some(0), "{}", stderr(&table));
        stdout(&table)
    };
    let first = build("asked.csv", "first.helio", "");
    folder.write("result.csv", &first);
    let again = build("result.csv", "again.helio", "");
    assert_eq!(first, again);
    let mut reader = csv::Reader::from_reader(first.as_bytes());
    let header = reader.headers().expect("a header").clone();
    let place = |name: &str| header.iter().position(|column| column == name).expect(name);
    let mut read: Vec<(String, f64, f64)> = Vec::new();
    for record in reader.records() {
        let record = record.expect("a row");
        let number = |name: &str| record[place(name)].parse::<f64>().expect(name);
        read.push((record[place("receiver")].to_owned(), number("tilt_deg"), number("azimuth_deg")));
    }
    read.sort_by(|a, b| a.0.cmp(&b.0));
    for ((_, tilt, azimuth), asked) in read.iter().zip(rows) {
        assert!((tilt - asked.0).abs() < 1e-9 && (azimuth - asked.1).abs() < 1e-9, "{tilt} {azimuth} {asked:?}");
    }
    let grid = build("asked.csv", "grid.helio", "--grid-north");
    let south = grid.lines().find(|line| line.contains(",r1,")).expect("a wall").to_owned();
    let azimuth: f64 = south.rsplit(',').nth(1).expect("a cell").parse().expect("an azimuth");
    assert!((azimuth - 180.0 - CONVERGENCE_DEG).abs() < 1e-4, "{south}");
    let pv = |points: &str, to: &str| {
        let done = folder.run(&format!(
            "pv meadow.obj --crs EPSG:25832 -w {} --points {points} -o {to} --quality draft --no-hourly",
            weather.display()
        ));
        assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
        std::fs::read_to_string(folder.path(to).join("points.csv")).expect("points.csv")
    };
    let lines: Vec<&str> = text.lines().take(4).collect();
    folder.write("points.csv", &format!("point,x,y,height_m,tilt,azimuth\n{}\n", lines.join("\n")));
    let first = pv("points.csv", "pv");
    assert_eq!(first, pv("pv/points.csv", "pv2"));
    assert!(first.contains(",90,93.5,"), "{first}");
    folder.write("both.csv", "receiver,x,y,z,nx,ny,nz,tilt_deg,azimuth_deg\na,316483.8,5987150.6,2,0,-1,0,90,180\n");
    folder.refused(
        "build meadow.obj --crs EPSG:25832 -r both.csv -o both.helio",
        &["both.csv, line 2", "differ by 2.27 degrees"],
    );
    let grouped = format!("replay first.helio -w {} --by surface --positions", weather.display());
    folder.fails(&grouped, "argument excludes --positions --by");
}
