//! Variants of a site: `compare` agrees with results worked out by hand, and with two replays.

use std::collections::BTreeMap;
use std::fs::{self, File};

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;

use crate::cli::{Folder, golden, stderr, stdout};
use crate::maps::{AT, Place, fgb, geoparquet, glb_json};

const GROUND: &str = "v -2000 -2000 0\nv 2000 -2000 0\nv 2000 2000 0\nv -2000 2000 0\nusemtl grass\nf 1 2 3 4\n";
const MATERIALS: &str = "[grass]\ndiffuse = 0.2\nclass = \"ground\"\n[wall]\ndiffuse = 0.4\n";

/// Writes a wall in the plane x, from `low` to `high`, so long that its ends do not matter.
fn long_wall(x: f64, low: f64, high: f64) -> String {
    let corners = [(-2000.0, low), (2000.0, low), (2000.0, high), (-2000.0, high)];
    let corners: String = corners.map(|(y, z)| format!("v {x} {y} {z}\n")).concat();
    format!("{corners}usemtl wall\nf -4 -3 -2 -1\n")
}

/// Builds `before.helio` and `after.helio` from two scenes and the same receivers.
fn built(before: &str, after: &str, receivers: &str) -> Folder {
    let folder = Folder::new();
    folder.write("materials.toml", MATERIALS);
    folder.write("receivers.csv", &format!("receiver,x,y,z,nx,ny,nz\n{receivers}"));
    for (name, scene) in [("before", before), ("after", after)] {
        folder.write(&format!("{name}.obj"), scene);
        run(&folder, &format!("build {name}.obj -m materials.toml -r receivers.csv -o {name}.helio"));
    }
    folder
}

/// Runs a command that must succeed; returns its output.
fn run(folder: &Folder, arguments: &str) -> String {
    let output = folder.run(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments}: {}", stderr(&output));
    stdout(&output)
}

/// Parses a table: cells as text by column, for each pair of the first two cells of a row.
fn cells(text: &str) -> BTreeMap<[String; 2], BTreeMap<String, String>> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let row = |line: &str| {
        let cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        let others = header.iter().zip(&cells).skip(2).map(|(name, cell)| ((*name).to_owned(), cell.clone()));
        ([cells[0].clone(), cells[1].clone()], others.collect())
    };
    lines.map(row).collect()
}

fn number(cells: &BTreeMap<String, String>, column: &str) -> f64 {
    cells.get(column).and_then(|cell| cell.parse().ok()).unwrap_or_else(|| panic!("{column} in {cells:?}"))
}

/// A street is closed by a wall of 12 m, 10 m before a facade. At 5 heights the facade loses the
/// sky below the wall's edge, DHI sin(b)/2 of DHI/2 under an isotropic sky with tan(b) = (12 -
/// z)/10, within 0.05 % of DHI. Under 3 suns it loses all direct light where the profile angle is
/// below b and none where it is above.
#[test]
fn a_wall_closes_a_street() {
    let heights = [1.0, 3.0, 6.0, 9.0, 11.5];
    let receivers: String = heights.map(|z| format!("{z},0,0,{z},1,0,0\n")).concat();
    let folder = built(GROUND, &(GROUND.to_owned() + &long_wall(10.0, 0.0, 12.0)), &receivers);
    let suns = [("low", 90.0, 20.0), ("high", 90.0, 55.0), ("aslant", 150.0, 15.0)];
    let rows = suns.map(|(name, azimuth, altitude)| format!("{name},{azimuth},{altitude},800,0\n")).concat();
    let head = "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\n";
    folder.write("conditions.csv", &format!("{head}sky,180,30,0,100\n{rows}"));
    let options = "--conditions conditions.csv --sky uniform --columns sky_direct,sun_direct";
    let table = cells(&run(&folder, &format!("compare before.helio after.helio {options}")));
    let of = |condition: &str, z: f64, column: &str| number(&table[&[condition.into(), z.to_string()]], column);
    let mut blocked = 0;
    for z in heights {
        let edge = ((12.0 - z) / 10.0_f64).atan();
        let expected = [50.0, 50.0 * (1.0 - edge.sin()), -50.0 * edge.sin()];
        let found = ["before", "after", "change"].map(|side| of("sky", z, &format!("{side}_sky_direct")));
        assert!(expected.iter().zip(found).all(|(a, b)| (a - b).abs() < 0.05), "{z}: {found:?}, not {expected:?}");
        let percent = of("sky", z, "change_sky_direct_percent");
        assert!((percent + 100.0 * edge.sin()).abs() < 0.2, "{z}: {percent}");
        for (name, azimuth, altitude) in suns {
            let [azimuth, altitude] = [azimuth - 90.0, altitude].map(f64::to_radians);
            let full = 800.0 * altitude.cos() * azimuth.cos();
            let profile = (altitude.tan() / azimuth.cos()).atan();
            assert!((profile - edge).abs() > 0.01, "{name} stands at the edge");
            let left = if profile < edge { 0.0 } else { full };
            blocked += usize::from(left == 0.0);
            let found = ["before", "after"].map(|side| of(name, z, &format!("{side}_sun_direct")));
            assert!((found[0] - full).abs() < 0.1 && (found[1] - left).abs() < 0.1, "{name} {z}: {found:?} {full}");
        }
    }
    assert!((4..=11).contains(&blocked), "{blocked}");
}

/// A roof loses its afternoon to a slab that rises 30 m above it, 5 m west of it. In three days of
/// March the hours to 11:00 do not change. From 13:00 on, when the sun is at most 57 degrees high
/// and the slab's edge at 80.5, all direct sun is lost. The sum of the changes is the sum of the
/// hours' losses.
#[test]
fn a_slab_takes_the_afternoon() {
    let folder = built(GROUND, &(GROUND.to_owned() + &long_wall(-5.0, 0.0, 40.0)), "roof,0,0,10,0,0,1\n");
    let weather = golden().display().to_string();
    let compare = |every: &str| {
        let options = format!("--weather {weather} --columns sun_direct --every {every}");
        cells(&run(&folder, &format!("compare before.helio after.helio {options}")))
    };
    let (mut lost, mut kept) = (0.0, 0);
    for ([time, _], row) in compare("hour") {
        let hour: u32 = time[11..13].parse().expect("an hour");
        let [before, after, change] =
            ["before", "after", "change"].map(|side| number(&row, &format!("{side}_sun_direct")));
        match hour {
            0..11 => assert!(change == 0.0 && before == after, "{time}: {row:?}"),
            13.. => assert!(after == 0.0 && change == -before, "{time}: {row:?}"),
            _ => assert!(after <= before, "{time}: {row:?}"),
        }
        kept += usize::from(hour < 11 && before > 0.0);
        lost += before - after;
        let percent = row["change_sun_direct_percent"].as_str();
        assert_eq!(percent.is_empty(), before == 0.0, "{time}: {row:?}");
    }
    let total = compare("total");
    let change = number(total.values().next().expect("a row"), "change_sun_direct_kwh_m2");
    assert!(kept == 9 && lost > 1000.0 && (change + lost / 1000.0).abs() < 1e-3, "{kept} {lost} {change}");
}

/// Parses decimals as whole numbers of 1e-14.
fn exact(text: &str) -> i128 {
    let (whole, part) = text.trim_start_matches('-').split_once('.').unwrap_or((text.trim_start_matches('-'), ""));
    let digits: i128 = format!("{whole}{part:0<14}").parse().expect("digits");
    if text.starts_with('-') { -digits } else { digits }
}

/// Builds the cube of the command line tests in RD New, covered with receivers, alone and beside a
/// tower of 25 m.
fn towers() -> Folder {
    let folder = Folder::new();
    let scene = fs::read_to_string(folder.path("scene.obj")).expect("the scene");
    let moved = |line: &str| match line.strip_prefix("v ") {
        Some(numbers) => {
            let numbers: Vec<f64> = numbers.split(' ').map(|number| number.parse().expect("a number")).collect();
            format!("v {} {} {}\n", numbers[0] + AT.x, numbers[1] + AT.y, numbers[2] + AT.z)
        }
        None => format!("{line}\n"),
    };
    let tower: String = [(16.0, -4.0), (24.0, -4.0), (24.0, 4.0), (16.0, 4.0)]
        .into_iter()
        .flat_map(|(x, y)| [0.0, 25.0].map(|z| format!("v {x} {y} {z}\n")))
        .collect();
    let sides = "usemtl wall\nf -8 -6 -5 -7\nf -6 -4 -3 -5\nf -4 -2 -1 -3\nf -2 -8 -7 -1\nf -7 -5 -3 -1\n";
    folder.write("before.obj", &scene.lines().map(moved).collect::<String>());
    folder.write("after.obj", &format!("{scene}{tower}{sides}").lines().map(moved).collect::<String>());
    let cover = "--materials materials.toml --on wall,roof --spacing 2.5 --crs 28992";
    run(&folder, &format!("receivers before.obj {cover} -o cube.csv"));
    for side in ["before", "after"] {
        let build = "-m materials.toml --quality draft --crs 28992";
        run(&folder, &format!("build {side}.obj {build} -r cube.csv -o {side}.helio"));
    }
    folder
}

/// A tower beside a cube: in each row of 3 periods the change is the difference of two replays to
/// the last digit they print, and so are their sums. Rows of surfaces are those of the receivers of
/// both sides.
#[test]
fn changes_are_differences_of_two_replays() {
    let folder = towers();
    let weather = golden().display().to_string();
    let replay = |side: &str, rest: &str| {
        cells(&run(&folder, &format!("replay {side}.helio --weather {weather} --columns total,sky_direct {rest}")))
    };
    for every in ["--every day", "--every total", "--every hour --from 03-20T10:00 --to 03-20T11:00"] {
        let options = format!("--weather {weather} --columns total,sky_direct {every}");
        let changes = cells(&run(&folder, &format!("compare before.helio after.helio {options}")));
        let (before, after) = (replay("before", every), replay("after", every));
        assert!(changes.len() == before.len() && after.len() == before.len(), "{}", changes.len());
        let mut sums = [0; 3];
        for (key, row) in &changes {
            for name in ["total", "sky_direct"] {
                let ending = if every.contains("hour") { "" } else { "_kwh_m2" };
                let cell = |side: &str| exact(&row[&format!("{side}_{name}{ending}")]);
                let [first, second] = [&before, &after].map(|table| exact(&table[key][&format!("{name}{ending}")]));
                assert_eq!((cell("before"), cell("after"), cell("change")), (first, second, second - first), "{key:?}");
                let parts = [first, second, cell("change")];
                sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
            }
        }
        assert!(sums[2] < 0 && sums[1] - sums[0] == sums[2], "{sums:?}");
    }
    let options = format!("--weather {weather} --every total --by surface");
    let surfaces = cells(&run(&folder, &format!("compare before.helio after.helio {options}")));
    let before = cells(&run(&folder, &format!("replay before.helio {options}")));
    assert_eq!(surfaces.len(), before.len());
    for (key, row) in &surfaces {
        assert_eq!(row["before_total_kwh_m2"], before[key]["total_kwh_m2"]);
        let energy = number(row, "change_total_kwh_m2") * number(row, "area_m2");
        assert!((energy - number(row, "change_total_kwh")).abs() < 0.1, "{row:?}");
    }
}

/// Four receivers: one is renamed, one is moved, one is removed and one is added. 3 are on both
/// sides, 1 of them moved, and 1 is left on either side. A choice of receivers before takes its
/// partner after, whatever its name.
#[test]
fn receivers_are_matched_by_place_or_name() {
    let rows = |list: &[(&str, f64)]| list.iter().map(|(id, x)| format!("{id},{x},0,1,0,0,1\n")).collect::<String>();
    let folder = built(GROUND, GROUND, &rows(&[("a", 0.0), ("b", 5.0), ("c", 10.0), ("d", 15.0)]));
    let after = rows(&[("1", 0.004), ("c", 12.0), ("d", 15.0), ("e", 20.0)]);
    folder.write("receivers.csv", &format!("receiver,x,y,z,nx,ny,nz\n{after}"));
    run(&folder, "build after.obj -m materials.toml -r receivers.csv -o after.helio");
    let options = "--conditions conditions.csv --summary summary.csv --unmatched unmatched.csv -o change.csv";
    let said = run(&folder, &format!("compare before.helio after.helio {options}"));
    for part in ["3 receivers in both, 1 of them moved", "1 only before: b", "1 only after: e"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let read = |name: &str| fs::read_to_string(folder.path(name)).expect("a table");
    let names: Vec<String> = cells(&read("change.csv")).into_keys().map(|[_, receiver]| receiver).collect();
    assert_eq!(names, ["a", "c", "d", "a", "c", "d"]);
    let expected =
        "variant,side,receiver,x,y,z\nafter.helio,before,b,5.000,0.000,1.000\nafter.helio,after,e,20.000,0.000,1.000\n";
    assert_eq!(read("unmatched.csv"), expected);
    let summary = read("summary.csv");
    assert!(summary.lines().nth(1).is_some_and(|row| row.starts_with("after.helio,3,1,1,1,,")), "{summary}");
    folder.write("some.csv", "receiver\na\nb\n");
    let some = run(&folder, "compare before.helio after.helio -c conditions.csv -r some.csv");
    assert_eq!(some.lines().count(), 1 + 2, "{some}");
}

/// Tables, maps and pictures of one change agree: independent readers find the changes of the CSV,
/// at 80 places each.
#[test]
fn every_format_holds_the_change() {
    let folder = towers();
    let weather = golden().display().to_string();
    let write = |rest: &str| {
        run(&folder, &format!("compare before.helio after.helio --weather {weather} --every total {rest}"))
    };
    let table = cells(&write(""));
    assert_eq!(table.len(), 80);
    let expected = |name: &str, column: &str| number(&table[&["total".into(), name.into()]], column);
    for ending in ["csv", "parquet", "arrow", "feather", "npy", "npz", "glb", "fgb", "geojson", "vtu", "ply", "pvd"] {
        let said = write(&format!("-o change.{ending}"));
        assert!(said.contains("80 receivers in both"), "{ending}: {said}");
        assert!(fs::metadata(folder.path(&format!("change.{ending}"))).is_ok_and(|file| file.len() > 200), "{ending}");
    }
    let columns = ["before_total_kwh_m2", "after_total_kwh_m2", "change_total_kwh_m2", "change_total_percent"];
    let reader =
        SerializedFileReader::new(File::open(folder.path("change.parquet")).expect("a file")).expect("Parquet");
    for row in reader.get_row_iter(None).expect("rows") {
        let row = row.expect("a row");
        let cells: BTreeMap<String, Field> =
            row.get_column_iter().map(|(n, field)| (n.clone(), field.clone())).collect();
        let Field::Str(name) = &cells["receiver"] else { panic!("{cells:?}") };
        for column in columns {
            let Field::Float(found) = cells[column] else { panic!("{cells:?}") };
            assert!((f64::from(found) - expected(name, column)).abs() < 6e-3, "{name} {column} {found}");
        }
    }
    let near = |places: &BTreeMap<String, Place>| {
        assert_eq!(places.len(), 80);
        let differences = places
            .iter()
            .flat_map(|(name, (numbers, _))| columns.map(|column| (numbers[column] - expected(name, column)).abs()));
        assert!(differences.fold(0.0, f64::max) < 6e-3);
    };
    near(&fgb(&folder.path("change.fgb")).1);
    write("--geo -o map.parquet");
    near(&geoparquet(&folder.path("map.parquet")).1);
    let colours = &glb_json(&folder.path("change.glb"))["asset"]["extras"]["colours"];
    let end = |name: &str| colours[name].as_f64().expect("a number");
    assert_eq!((&colours["map"], &colours["column"]), (&"PuOr".into(), &"change_total_kwh_m2".into()));
    let largest = table.values().map(|row| number(row, "change_total_kwh_m2").abs()).fold(0.0, f64::max);
    assert!(end("from") == -end("to") && (end("to") - largest).abs() < 1e-3, "{colours}");
    let ply = fs::read(folder.path("change.ply")).expect("a map");
    let head = String::from_utf8_lossy(&ply[..3000]);
    assert!(head.contains("property float change_total_kwh_m2\n") && head.contains("(loss) to "), "{head}");

    write("--plot map.png");
    let picture = File::open(folder.path("map.png")).expect("a picture");
    let reader = png::Decoder::new(std::io::BufReader::new(picture)).read_info().expect("PNG");
    let text = |key: &str| {
        let texts = &reader.info().uncompressed_latin1_text;
        texts.iter().find(|text| text.keyword == key).map(|text| text.text.clone()).unwrap_or_default()
    };
    let end = |key: &str| text(key).parse::<f64>().expect("a number");
    assert_eq!(text("heliotile.colours"), "PuOr");
    assert_eq!(end("heliotile.colours_from"), -end("heliotile.colours_to"));
    // At least 98 % of the changes lie on the scale, and the picture says so if not all do.
    let changes = table.values().map(|row| number(row, "change_total_kwh_m2").abs());
    let within = changes.filter(|change| *change <= end("heliotile.colours_to")).count();
    assert!(100 * within >= 98 * table.len(), "{within} of {}", table.len());
    assert_eq!(text("heliotile.colours_percentile").is_empty(), end("heliotile.colours_to") >= largest);
    let days = format!("--weather {weather} --every day --plot days.svg");
    run(&folder, &format!("compare before.helio after.helio {days}"));
    let days = fs::read_to_string(folder.path("days.svg")).expect("a chart");
    assert!(days.contains("Change of total irradiation by day") && days.contains(">loss<"), "{days}");
}

/// Two variants give a row each, whose means are those of single comparisons. A file of results
/// holds one variant. Another place, no common receiver, and wrong names and tables are refused: 7
/// of 7.
#[test]
fn rows_of_variants_equal_single_comparisons() {
    let folder = towers();
    let weather = golden().display().to_string();
    fs::copy(folder.path("before.helio"), folder.path("same.helio")).expect("copied");
    let compare = "compare before.helio after.helio same.helio";
    let output = folder.run(&format!("{compare} --weather {weather} --summary two.csv"));
    assert!(
        stderr(&output).contains("note: before.helio and same.helio: the archives are equal"),
        "{}",
        stderr(&output)
    );
    let two = fs::read_to_string(folder.path("two.csv")).expect("a table");
    run(&folder, &format!("compare before.helio after.helio --weather {weather} --summary one.csv"));
    let one = fs::read_to_string(folder.path("one.csv")).expect("a table");
    assert_eq!(two.lines().take(2).collect::<Vec<_>>(), one.lines().collect::<Vec<_>>());
    let same = two.lines().nth(2).expect("a second row");
    assert!(same.starts_with("same.helio,80,0,0,0,") && same.contains(",0,0,0"), "{same}");

    let with = format!("--weather {weather}");
    folder.fails(&format!("{compare} {with} -o x.csv"), "argument excludes --output,--plot after");
    folder.fails(&format!("{compare} {with} --plot x.png"), "argument excludes --output,--plot after");
    folder.fails("compare before.helio after.helio", "argument missing --weather");
    folder.fails(
        &format!("compare before.helio after.helio {with} --summary x.csv -o x.csv"),
        "input same-file x.csv x.csv",
    );
    folder.fails(&format!("compare before.helio after.helio {with} -o after.helio"), "unsupported `after.helio`");
    let build =
        "build before.obj -m materials.toml --quality draft -r cube.csv --latitude 52 --longitude 4 -o other.helio";
    run(&folder, build);
    folder.fails(&format!("compare before.helio other.helio {with}"), "input other-site other.helio");
    folder.write("far.csv", "receiver,x,y,z,nx,ny,nz\nnowhere,80003,455003,40,0,0,1\n");
    run(&folder, "build before.obj -m materials.toml --quality draft -r far.csv --crs 28992 -o far.helio");
    folder.fails(&format!("compare before.helio far.helio {with}"), "input other-site far.helio");
}

/// Archives built with other settings are compared, and a warning names the settings.
#[test]
fn other_settings_are_named() {
    let folder = built(GROUND, GROUND, "a,0,0,1,0,0,1\n");
    run(&folder, "build after.obj -m materials.toml -r receivers.csv --set probe=32 -o after.helio");
    let output = folder.run("compare before.helio after.helio --conditions conditions.csv");
    let message = stderr(&output);
    assert!(message.contains("built with different settings") && message.contains("probe 16 and 32"), "{message}");
    assert_eq!(stdout(&output).lines().count(), 1 + 2);
}
