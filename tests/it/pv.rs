//! Modules that `pv` places: sums and hours that fit together, losses, horizons and best turns by
//! closed forms, rows, and wrong input.

use std::collections::HashMap;
use std::fs;

use parquet::file::reader::{FileReader, SerializedFileReader};

use crate::cli::{Folder, golden, stderr, stdout};

/// Returns the rows of a table by column.
pub fn table(folder: &Folder, name: &str) -> Vec<HashMap<String, String>> {
    let mut lines = csv::Reader::from_path(folder.path(name)).expect("a table");
    let header = lines.headers().expect("a header").clone();
    let row = |line: csv::StringRecord| header.iter().map(str::to_owned).zip(line.iter().map(str::to_owned)).collect();
    lines.records().map(|line| row(line.expect("a line"))).collect()
}

pub fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: {row:?}"))
}

pub fn good(folder: &Folder, arguments: &str) -> String {
    let output = folder.run(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments}: {}", stderr(&output));
    stdout(&output)
}

/// Six hours of a uniform sky of 100 W/m2: 0.6 kWh/m2 on open level ground.
pub const EVEN: &str = "time,ghi,dni,dhi\n2019-06-21T09:00+01:00,100,0,100\n2019-06-21T10:00+01:00,100,0,100\n\
                    2019-06-21T11:00+01:00,100,0,100\n2019-06-21T12:00+01:00,100,0,100\n\
                    2019-06-21T13:00+01:00,100,0,100\n2019-06-21T14:00+01:00,100,0,100\n";
pub const PLACE: &str = "--latitude 50 --longitude 15";

/// Returns a folder with a wall of 8 km x 4 km half a metre north of the origin on black ground,
/// and a uniform sky.
fn wall(material: &str) -> Folder {
    let folder = Folder::new();
    folder.write("even.csv", EVEN);
    folder
        .write("wall.obj", "v -4000 0.5 0\nv 4000 0.5 0\nv 4000 0.5 4000\nv -4000 0.5 4000\nusemtl wall\nf 1 2 3 4\n");
    folder.write("wall.toml", &format!("[wall]\n{material}\n[endless_ground]\ndiffuse = 0\n"));
    folder
}

/// On a lawn and beside a cube of 10 m, hours in pvlib's names add up to the months and these to
/// the year, within 1e-3 of them, and the year is that of `replay` within 0.001 kWh/m2. The roof
/// loses at most 1.5 %, the lawn, which ends, less than 4 %, the cube's foot more than 20 %. A
/// second run traces nothing, and the hours in Parquet have 3 x 72 rows.
#[test]
fn hours_add_up_to_months_and_months_to_the_year() {
    let folder = Folder::new();
    folder.write(
        "points.csv",
        "point,x,y,z,height,tilt,azimuth\nlawn,5,-25,,1,0,0\nfoot,5,11,,0.5,90,180\nroof,5,5,11,,30,180\n",
    );
    let weather = golden();
    let command = format!("pv scene.obj -m materials.toml -w {} --points points.csv -o out", weather.display());
    good(&folder, &command);
    let points = table(&folder, "out/points.csv");
    assert_eq!(points.len(), 3);
    let months = table(&folder, "out/months.csv");
    let hours = table(&folder, "out/hourly.csv");
    assert_eq!((months.len(), hours.len()), (3, 3 * 72));
    good(&folder, &format!("replay out/site.helio -w {} --every total -o total.csv", weather.display()));
    let totals = table(&folder, "total.csv");
    for row in &points {
        let of = |table: &[HashMap<String, String>], column: &str| -> f64 {
            table.iter().filter(|other| other["point"] == row["point"]).map(|other| number(other, column)).sum()
        };
        let total = number(row, "total_kwh_m2");
        assert!((of(&months, "total_kwh_m2") - total).abs() < 1e-3 * total);
        assert!((of(&hours, "poa_global") / 1000.0 - total).abs() < 1e-3 * total);
        let parts = of(&hours, "poa_direct") + of(&hours, "poa_sky_diffuse") + of(&hours, "poa_ground_diffuse");
        assert!((parts / 1000.0 - total).abs() < 1e-3 * total, "{parts} {total}");
        let diffuse = of(&hours, "poa_sky_diffuse") + of(&hours, "poa_ground_diffuse");
        assert!((of(&hours, "poa_diffuse") - diffuse).abs() < 1.0);
        let replayed = totals.iter().find(|other| other["receiver"] == row["point"]).expect("the receiver");
        assert!((number(replayed, "total_kwh_m2") - total).abs() < 1e-3, "{replayed:?}");
    }
    let loss = |point: &str| {
        number(points.iter().find(|row| row["point"] == point).expect("the point"), "shading_loss_percent")
    };
    assert!(loss("roof").abs() < 1.5 && loss("lawn") < 4.0 && loss("foot") > 20.0, "{points:?}");
    let z: Vec<f64> = points.iter().map(|row| number(row, "z")).collect();
    assert!((z[0] - 1.0).abs() < 1e-3 && (z[1] - 0.5).abs() < 1e-3 && z[2] == 11.0, "{z:?}");
    let again = good(&folder, &format!("{command} --format parquet"));
    assert!(again.contains("nothing is traced again"), "{again}");
    let parquet = fs::File::open(folder.path("out/hourly.parquet")).expect("a file");
    let reader = SerializedFileReader::new(parquet).expect("Parquet");
    assert_eq!(reader.metadata().file_metadata().num_rows(), 3 * 72);
}

/// An upright module on a plain gets half of an even sky and half of what the ground reflects: 0.36
/// of 0.6 kWh/m2 with the usual 0.2, 0.48 with the albedo of 0.6 of the weather file, within 1 %.
#[test]
fn snow_takes_the_albedo_of_the_weather() {
    let folder = Folder::new();
    let rows = EVEN.lines().skip(1).map(|row| format!("{row},0.6\n")).collect::<String>();
    folder.write("even.csv", &format!("time,ghi,dni,dhi,albedo\n{rows}"));
    folder.write("far.obj", "v 4000 4000 0\nv 4001 4000 0\nv 4000 4000 1\nusemtl far\nf 1 2 3\n");
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\nupright,0,0,1,90,180\n");
    for (option, right) in [("", 0.36), ("--snow albedo", 0.48)] {
        let command =
            format!("pv far.obj -w even.csv {PLACE} --points points.csv --sky uniform --replace -o out {option}");
        good(&folder, &command);
        let total = number(&table(&folder, "out/points.csv")[0], "total_kwh_m2");
        assert!((total / right - 1.0).abs() < 0.01, "{option}: {total}");
    }
}

/// 10 m south of the middle of a cube's wall, at its foot, the horizon is 45 degrees in the north
/// and 0 in the south, in PVGIS's format: 360 lines of one number. The table has pvlib's columns.
/// If y points 30 degrees east of north the wall is at 30 degrees.
#[test]
fn horizon_lists_show_a_wall_at_45_degrees() {
    let folder = Folder::new();
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\np,5,-10,0.001,0,0\n");
    for (turn, north) in [("", 0), (" --latitude 40 --longitude -105 --rotate-deg 30", 30)] {
        let weather = golden();
        good(
            &folder,
            &format!(
                "pv scene.obj -m materials.toml -w {} --points points.csv --no-hourly --replace -o out{turn}",
                weather.display()
            ),
        );
        let list = fs::read_to_string(folder.path("out/horizon/p.csv")).expect("a list");
        let heights: Vec<f64> = list.lines().map(|line| line.parse().expect("a number")).collect();
        assert_eq!(heights.len(), 360);
        assert!(
            (heights[north] - 45.0).abs() < 0.05 && heights[north + 180] == 0.0,
            "{} {}",
            heights[north],
            heights[north + 180]
        );
        let table = table(&folder, "out/horizons.csv");
        assert_eq!(table.len(), 360);
        let row = &table[north];
        assert!(
            number(row, "horizon_azimuth") == north as f64 && (number(row, "horizon_elevation") - 45.0).abs() < 0.05
        );
    }
}

/// Under a uniform sky a level point at the foot of an endless black wall loses 50 % against an
/// open plain, within 0.2 %; a white wall of 0.8 gives 20 % of the open sky back, within 0.5.
#[test]
fn a_black_wall_hides_half_of_the_sky() {
    for (material, expected, most) in [("diffuse = 0", 50.0, 0.2), ("diffuse = 0.8", 30.0, 0.5)] {
        let folder = wall(material);
        folder.write("points.csv", "point,x,y,z,tilt,azimuth\np,0,0,1,0,0\n");
        good(
            &folder,
            &format!("pv wall.obj -m wall.toml {PLACE} -w even.csv --points points.csv --sky uniform -o out"),
        );
        let row = &table(&folder, "out/points.csv")[0];
        let (open, loss) = (number(row, "open_kwh_m2"), number(row, "shading_loss_percent"));
        assert!((open - 0.6).abs() < 0.001 && (loss - expected).abs() < most, "{material}: {open} {loss}");
        assert!((number(row, "sky_view") - 0.5).abs() < 0.002);
    }
}

/// Under a uniform sky the best turn before a wall in the north is, by lunes of directions,
/// `atan(1 - w)` south of level, where the wall is w times as bright as the sky: 45 degrees before
/// a black one, 31.0 before one that reflects 0.8 diffusely, 11.3 before a mirror of 0.8, found
/// within 0.5 degrees. With limits the result lies on them, and a point without angles takes it.
#[test]
fn the_best_turn_depends_on_the_light_of_the_wall() {
    for (material, bright) in [("diffuse = 0", 0.0_f64), ("diffuse = 0.8", 0.4), ("diffuse = 0\nspecular = 0.8", 0.8)] {
        let folder = wall(material);
        folder.write("points.csv", "point,x,y,z,tilt,azimuth\np,0,0,1,,\ngiven,0,0,1,60,180\n");
        good(
            &folder,
            &format!("pv wall.obj -m wall.toml {PLACE} -w even.csv --points points.csv --sky uniform --search -o out"),
        );
        let row = &table(&folder, "out/best.csv")[0];
        let expected = (1.0 - bright).atan().to_degrees();
        let (tilt, azimuth) = (number(row, "tilt_deg"), number(row, "azimuth_deg"));
        let side = (azimuth - 180.0).abs() * tilt.to_radians().sin();
        assert!((tilt - expected).abs() < 0.5 && side < 0.5, "{material}: {tilt} {azimuth}, not {expected}");
        assert!(number(row, "scatter_percent") < 0.2, "{row:?}");
        let points = table(&folder, "out/points.csv");
        assert!((number(&points[0], "tilt_deg") - tilt).abs() < 0.01 && number(&points[1], "tilt_deg") == 60.0);
        // By lunes: the light on a surface 60 degrees steep, beside the best.
        let light = |tilt: f64| {
            let height = (90.0 - tilt).to_radians();
            height.cos() + height.sin() + bright * (1.0 - height.cos())
        };
        let loss = 100.0 * (1.0 - light(60.0) / light(expected));
        let found = number(&table(&folder, "out/best.csv")[1], "given_loss_percent");
        assert!((found - loss).abs() < 0.15, "{material}: {found}, not {loss}");
        assert!(fs::read_to_string(folder.path("out/turns/p.svg")).expect("a picture").starts_with("<svg"));
    }
    let folder = wall("diffuse = 0");
    folder.write("points.csv", "point,x,y,z\np,0,0,1\n");
    let limited = "--search --tilts 0..20 --azimuths 90..150 --no-hourly";
    good(
        &folder,
        &format!("pv wall.obj -m wall.toml {PLACE} -w even.csv --points points.csv --sky uniform {limited} -o out"),
    );
    let row = &table(&folder, "out/best.csv")[0];
    assert!(
        (number(row, "tilt_deg") - 20.0).abs() < 0.01 && (number(row, "azimuth_deg") - 150.0).abs() < 0.01,
        "{row:?}"
    );
}

/// The middle one of 9 black rows, 2 m wide and 3 m apart at 30 degrees on black ground, sees as
/// much of the uniform sky as Hottel's crossed strings give a front of endless rows, within 1 %,
/// and so does its rear; hours have pvlib's columns of both sides.
#[test]
fn rows_see_the_sky_of_crossed_strings() {
    let folder = wall("diffuse = 0");
    folder.write("field.obj", "v -100 -100 0\nv 100 -100 0\nv 100 100 0\nv -100 100 0\nusemtl grass\nf 1 2 3 4\n");
    folder.write("field.toml", "[grass]\ndiffuse = 0\nclass = \"ground\"\n");
    folder.write(
        "rows.toml",
        "[[rows]]\nname = \"r\"\narea = [[-90, -13], [90, -13], [90, 13], [-90, 13]]\ntilt = 30\nazimuth = 180\npitch = 3\nwidth = 180\n\
         height = 2\nclearance = 0.5\nthickness = 0.001\nfront = 0\nrear = 0\nsamples = 4\n",
    );
    good(&folder, &format!("pv field.obj -m field.toml {PLACE} -w even.csv --rows rows.toml --sky uniform -o out"));
    let points = table(&folder, "out/points.csv");
    assert_eq!(points.len(), 2 * 9);
    let side =
        |side: &str| points.iter().find(|row| row["point"] == "r/5/1" && row["side"] == side).expect("the middle row");
    let (slope, pitch, tilt) = (2.0_f64, 3.0_f64, 30.0_f64.to_radians());
    let (deep, high) = (slope * tilt.cos(), slope * tilt.sin());
    // Strings go from the edges of one row to those of the next.
    let gap = (pitch - deep).hypot(high);
    let front = (slope + pitch - gap) / (2.0 * slope);
    let far = (pitch + deep).hypot(high);
    let rear = (slope + pitch - far) / (2.0 * slope);
    for (name, expected) in [("front", front), ("rear", rear)] {
        let found = number(side(name), "total_kwh_m2") / 0.6;
        assert!((found - expected).abs() < 0.01 * front, "{name}: {found}, not {expected}");
    }
    let gain = number(side("front"), "bifacial_gain_percent");
    assert!((gain - 80.0 * rear / front).abs() < 1.0, "{gain}");
    let hours = table(&folder, "out/hourly.csv");
    assert_eq!(hours.len(), 9 * 6);
    let row = hours.iter().find(|row| row["point"] == "r/5/1").expect("an hour");
    let both = number(row, "poa_front") + 0.8 * number(row, "poa_back");
    assert!((number(row, "poa_global") - both).abs() < 0.01 && (number(row, "poa_front") - 100.0 * front).abs() < 1.0);
    assert!(folder.path("out/modules.obj").exists() && !folder.path("out/horizons.csv").exists());
}

/// Two rows of three black modules at 30 degrees stand on an open plain without a scene, around
/// the place that is stated. Fronts of the first row get (1 + cos 30) / 2 of a uniform sky within
/// 0.3 % and lose nothing; those of the second lose at least 5 %.
#[test]
fn rows_stand_on_an_open_plain_without_a_scene() {
    let folder = Folder::new();
    folder.write("even.csv", EVEN);
    folder.write("black.toml", "[ground]\ndiffuse = 0\nclass = \"ground\"\n");
    let rows = "[[rows]]\nname = \"r\"\nrows = 2\nmodules = 3\nat = [100, 50]\ntilt = 30\nazimuth = 200\npitch = 2.5\nwidth = 1\n\
                height = 2\nclearance = 0.5\nfront = 0\nrear = 0\n";
    folder.write("rows.toml", rows);
    let pv = format!("pv -m black.toml {PLACE} -w even.csv --rows rows.toml --sky uniform -o out");
    good(&folder, &pv);
    let points = table(&folder, "out/points.csv");
    assert_eq!(points.len(), 2 * 6);
    let fronts: Vec<_> = points.iter().filter(|row| row["side"] == "front").collect();
    let open = 0.3 * (1.0 + 30.0_f64.to_radians().cos());
    for front in &fronts {
        let (sky, loss) = (number(front, "total_kwh_m2"), number(front, "shading_loss_percent"));
        match front["point"].starts_with("r/1/") {
            true => assert!((sky / open - 1.0).abs() < 0.003 && loss.abs() < 0.3, "{front:?}"),
            false => assert!(loss > 5.0, "{front:?}"),
        }
    }
    let of = |axis: &str| fronts.iter().map(|front| number(front, axis)).sum::<f64>() / 6.0;
    assert!((of("x") - 100.0).abs() < 0.05 && (of("y") - 50.0).abs() < 0.05, "{} {}", of("x"), of("y"));
    assert!(folder.path("out/plain.obj").exists() && folder.path("out/modules.obj").exists());
    folder
        .write("rows.toml", &rows.replace("rows = 2\nmodules = 3\nat = [100, 50]", "area = [[0, 0], [9, 0], [9, 9]]"));
    folder.fails(&pv.replace("-o out", "-o other"), "input other rows.toml");
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\na,20,5,1,30,180\n");
    folder.fails(&pv.replace("--rows rows.toml", "--points points.csv"), "argument missing SCENE|--dsm");
}

/// Wrong input is refused with file and line, 13 of 13, and leaves no folder of results.
#[test]
fn wrong_input_is_refused_with_file_and_line() {
    let folder = Folder::new();
    let weather = golden();
    let pv = |rest: &str| format!("pv scene.obj -m materials.toml -w {} -o out {rest}", weather.display());
    for (text, expected) in [
        ("point,x,y,height,tilt,azimuth\na,20,5,1,200,180\n", "input value points.csv:2 tilt 200"),
        ("point,x,y,z,tilt,azimuth\nwall,5,5,4,30,180\n", "input misplaced points.csv:2"),
        ("point,x,y,z,tilt,azimuth\na,20,5,-1,30,180\n", "input misplaced points.csv:2"),
        ("point,x,y,height,tilt,azimuth\na,20,5,-1,30,180\n", "input value points.csv:2 height -1"),
        ("point,x,y,height,tilt,azimuth\na,500,5,1,30,180\n", "input misplaced points.csv:2"),
        ("point,x,y,z,tilt,azimuth\na,20,5,1,30,180\na,21,5,1,30,180\n", "input duplicate points.csv:3 a"),
        ("point,x,y,z\na,20,5,1\n", "input no-column points.csv:1 tilt_deg"),
    ] {
        folder.write("points.csv", text);
        folder.fails(&pv("--no-ground --points points.csv"), expected);
    }
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\na,20,5,1,30,180\n");
    folder.fails("pv scene.obj -m materials.toml --points points.csv -o out", "argument missing --weather");
    folder.fails(&pv(""), "argument missing --points");
    folder.fails(&pv("--points points.csv --search --tilts 10..200"), "argument unreadable --tilts 10..200");
    folder.fails(&pv("--points points.csv --search --azimuths 0..400"), "argument unreadable --azimuths 0..400");
    let rows =
        "[[rows]]\nname = \"a\"\nsurface = \"roof\"\ntilt = 30\nazimuth = 180\npitch = 3\nwidth = 1\nheight = 2\n";
    folder.write("rows.toml", rows);
    folder.fails(&pv("--rows rows.toml"), "input unknown rows.toml roof");
    let two = rows.replace("surface = \"roof\"", "area = [[0, 0], [9, 0], [9, 9], [0, 9]]");
    let other = two.replace("azimuth = 180", "azimuth = 90").replacen("name = \"", "name = \"other", 1);
    folder.write("rows.toml", &format!("{two}{other}"));
    folder.refused(
        &pv("--rows rows.toml"),
        &["rows pass through each other at", "give each [[rows]] an area of its own"],
    );
    folder.write("rows.toml", &rows.replace("surface = \"roof\"", "area = [[15, 0], [16, 0], [16, 1]]"));
    folder.fails(&pv("--rows rows.toml"), "input empty rows.toml");
    folder.write("rows.toml", &rows.replace("surface = \"roof\"", "area = [[0, 0], [9e7, 0], [9e7, 9e7]]"));
    folder.fails(&pv("--rows rows.toml"), "input other rows.toml");
    assert!(!folder.path("out/points.csv").exists());
}

/// Lists and pictures of points that no longer exist are removed with replaced results, and files
/// of others stay: 2 and 1 of 3 files.
#[test]
fn lists_of_earlier_points_are_removed() {
    let folder = wall("diffuse = 0");
    let pv = |rest: &str| {
        format!("pv wall.obj -m wall.toml {PLACE} -w even.csv --points points.csv --no-hourly -o out {rest}")
    };
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\np,0,0,1,0,0\nq,1,-1,1,0,0\n");
    good(&folder, &pv("--search --tilts 10..20 --azimuths 170..190"));
    folder.write("out/horizon/mine.txt", "x");
    let there = |names: &[&str]| names.iter().filter(|name| folder.path(&format!("out/{name}")).exists()).count();
    let (stale, kept) = (["horizon/q.csv", "turns/q.svg"], ["horizon/mine.txt", "horizon/p.csv"]);
    assert_eq!((there(&stale), there(&kept)), (2, 2));
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\np,0,0,1,0,0\n");
    good(&folder, &pv("--replace"));
    assert_eq!((there(&stale), there(&kept)), (0, 2));
}

/// Results of other points or other weather are kept, and replaced on request: 2 refusals.
#[test]
fn results_of_other_inputs_are_kept() {
    let folder = wall("diffuse = 0");
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\np,0,0,1,0,0\n");
    let pv = |rest: &str| format!("pv wall.obj -m wall.toml {PLACE} --points points.csv --no-hourly -o out {rest}");
    good(&folder, &pv("-w even.csv"));
    folder.write("other.csv", &EVEN.replace("100", "90"));
    folder.fails(&pv("-w other.csv"), "input other-inputs out");
    folder.write("points.csv", "point,x,y,z,tilt,azimuth\np,0,0,2,0,0\n");
    folder.fails(&pv("-w even.csv"), "input other-inputs out");
    good(&folder, &pv("-w other.csv --replace"));
    let row = &table(&folder, "out/points.csv")[0];
    assert!(number(row, "z") == 2.0 && (number(row, "open_kwh_m2") - 0.54).abs() < 0.001, "{row:?}");
}
