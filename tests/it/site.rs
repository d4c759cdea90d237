//! From scene files to receivers, and on to a year: the surfaces that get receivers, and the files
//! that `run` writes.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::cli::{Folder, stderr, stdout};

/// Writes two houses of 10 m a side with a wall in common, 1 m deep in a meadow.
pub fn houses(reversed: bool) -> String {
    let mut text = String::new();
    for x in [0, 10] {
        for (dx, y, z) in
            [(0, 0, 0), (10, 0, 0), (10, 10, 0), (0, 10, 0), (0, 0, 10), (10, 0, 10), (10, 10, 10), (0, 10, 10)]
        {
            text += &format!("v {} {y} {z}\n", x + dx);
        }
    }
    text += "v -99 -99 1\nv 99 -99 1\nv 99 99 1\nv -99 99 1\n";
    let mut faces = vec!["o meadow\nusemtl grass\nf 17 18 19 20\n".to_owned()];
    for (name, first) in [("west", 1), ("east", 9)] {
        for ring in [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7], [3, 2, 1, 0]] {
            let [a, b, c, d] = ring.map(|corner| corner + first);
            faces.push(format!("o {name}\nusemtl brick\nf {a} {b} {c} {d}\n"));
        }
    }
    if reversed {
        faces.reverse();
    }
    text + &faces.concat()
}

fn rows(csv: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = csv.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    lines.map(|line| header.iter().map(|h| h.to_string()).zip(line.split(',').map(str::to_owned)).collect()).collect()
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// 740 of 1,000 receivers on walls and roofs of two houses get light: 200 lie in the wall between
/// them, 60 more below the meadow. The areas of those that are written are 740 m2, and the order of
/// the file changes only the line numbers of faces.
#[test]
fn buried_receivers_are_left_out() {
    let folder = Folder::new();
    fs::write(folder.path("a.obj"), houses(false)).expect("written");
    fs::write(folder.path("b.obj"), houses(true)).expect("written");
    let tables = ["a", "b"].map(|name| {
        let output = folder.run(&format!("receivers {name}.obj -o {name}.csv --buried {name}_buried.csv --spacing 1m"));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let report = stdout(&output);
        assert!(report.contains("740 receivers on 10 surfaces of 3 objects"), "{report}");
        assert!(report.contains("260 inside a neighbour or below the terrain, 0 covered"), "{report}");
        [format!("{name}.csv"), format!("{name}_buried.csv")].map(|file| read(&folder.path(&file)))
    });
    let without_faces = |tables: &[String; 2]| {
        tables.each_ref().map(|table| {
            let mut rows = rows(table);
            rows.iter_mut().for_each(|row| drop(row.remove("face")));
            rows
        })
    };
    assert_eq!(without_faces(&tables[0]), without_faces(&tables[1]));
    let free = rows(&tables[0][0]);
    let area: f64 = free.iter().map(|row| row["area_m2"].parse::<f64>().expect("a number")).sum();
    assert_eq!((free.len(), (area - 740.0).abs() < 1e-6), (740, true));
    assert!(free.iter().all(|row| row["receiver"].starts_with(&format!("{}#", row["surface"]))));
    assert!(free.iter().any(|row| row["surface"] == "west/roof1"), "{:?}", free[0]);
    let buried = rows(&tables[0][1]);
    assert_eq!((buried.len(), buried.iter().filter(|row| row["reason"] == "inside").count()), (260, 260));
}

/// 3 receivers a surface on 2 roofs are 6 rows 5 mm off the roof; by the name of a material 8 of 10
/// surfaces get receivers, as two are hidden.
#[test]
fn receivers_are_chosen_by_kind_and_material() {
    let folder = Folder::new();
    fs::write(folder.path("a.obj"), houses(false)).expect("written");
    let roofs = folder.run("receivers a.obj --on roof --per-surface 3 --offset 5mm");
    let table = rows(&stdout(&roofs));
    assert_eq!(table.len(), 6);
    assert!(table.iter().all(|row| row["z"] == "10.0050" && row["area_m2"] == "33.3333" && row["nz"] == "1.000000"));
    assert!(stderr(&roofs).contains("6 receivers on 2 surfaces"), "{}", stderr(&roofs));
    let bricks = rows(&stdout(&folder.run("receivers a.obj --on brick --per-surface 1")));
    // Eight walls but the two between the houses, and two roofs.
    assert_eq!(bricks.len(), 8);
}

/// Five wrong requests are refused with exit code 2; no file is written.
#[test]
fn wrong_requests_are_refused() {
    let folder = Folder::new();
    fs::write(folder.path("a.obj"), houses(false)).expect("written");
    folder.write("b.abc", "0 0 0\n");
    for (arguments, expected) in [
        ("a.obj --on door", "argument unknown --on door"),
        ("a.obj --on window", "argument empty --on"),
        ("a.obj --spacing 2ft", "argument unreadable --spacing 2ft"),
        ("a.obj --on floor", "argument empty --on"),
        ("a.obj b.abc", "unsupported a name that ends with .abc"),
    ] {
        folder.fails(&format!("receivers -o out.csv {arguments}"), expected);
        assert!(!folder.path("out.csv").exists());
    }
    folder.fails("receivers a.obj -o a.obj", "input ending a.obj");
}

pub fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// One command writes 9 files. Its sums are those of `replay`, and rows of `south` get more sun
/// than `north`. A second run traces nothing and leaves the archive's bytes.
#[test]
fn a_second_run_traces_nothing() {
    let folder = Folder::new();
    fs::write(folder.path("a.obj"), houses(false)).expect("written");
    let weather = format!("{}/tests/data/weather/golden_3_days.epw", crate::ROOT);
    let run = |more: &str| {
        let output = folder.run(&format!("run a.obj --weather {weather} --quality draft {more}"));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stdout(&output)
    };
    let report = run("--spacing 5m");
    let made = folder.path("a.sun");
    assert_eq!(names(&made), ["golden_3_days", "receivers.csv", "site.helio"]);
    let results =
        ["annual.csv", "annual.csv-metadata.json", "annual.png", "index.html", "made-from.json", "months.svg"];
    assert_eq!(names(&made.join("golden_3_days")), results);
    let table = rows(&read(&made.join("golden_3_days/annual.csv")));
    let count = rows(&read(&made.join("receivers.csv"))).len();
    assert_eq!(table.len(), count);
    let replayed = rows(&stdout(&folder.run(&format!("replay a.sun/site.helio --weather {weather} --every total"))));
    for (row, same) in table.iter().zip(&replayed) {
        assert_eq!(row["receiver"], same["receiver"]);
        let [a, b] = [row, same].map(|row| row["total_kwh_m2"].parse::<f64>().expect("a number"));
        assert!((a - b).abs() <= 6e-4 * b.max(1.0), "{a} {b}");
    }
    let total = |group: &str| -> f64 {
        let line = report.lines().find(|line| line.starts_with(group)).expect(group);
        line.split_whitespace().rev().nth(1).expect("a total").parse().expect("a number")
    };
    assert!(total("wall, south") > 1.5 * total("wall, north"), "{report}");

    let before = fs::read(made.join("site.helio")).expect("an archive");
    assert!(run("--spacing 5m").contains("up to date, nothing is traced again"));
    assert_eq!(fs::read(made.join("site.helio")).expect("an archive"), before);
}

/// Three buildings of 3DBAG (EPSG:7415) lie near 51.9 N 4.4 E: `info` prints one place of scene and
/// archive, `run` and `replay` warn that Golden's weather is more than 7,000 km away, and
/// convergence is named once.
#[test]
fn the_place_of_a_scene_reaches_its_results() {
    let folder = Folder::new();
    let root = crate::ROOT;
    let (city, weather) = (
        format!("{root}/tests/data/cityjson/small.city.jsonl"),
        format!("{root}/tests/data/weather/golden_3_days.epw"),
    );
    let run = folder.run(&format!("run {city} --weather {weather} --quality draft --spacing 10m -o made"));
    let said = stderr(&run);
    assert_eq!(run.status.code(), Some(0), "{said}");
    let apart = |text: &str| {
        let line = text.lines().find(|line| line.contains("km from the scene at")).expect("a warning").to_owned();
        let km: f64 =
            line.split(" km from").next().and_then(|s| s.rsplit(' ').next()).expect("km").parse().expect("km");
        assert!((7_000.0..8_500.0).contains(&km), "{line}");
        line
    };
    let warned = apart(&said);
    assert_eq!(said.matches("true north").count(), 1, "{said}");
    let replayed = folder.run(&format!("replay made/site.helio --weather {weather} --every total"));
    assert_eq!(apart(&stderr(&replayed)), warned);
    let place = |what: &str| {
        let text = stdout(&folder.run(&format!("info {what}")));
        text.lines().find(|line| line.starts_with("  place ")).expect("a place").to_owned()
    };
    assert_eq!(place(&city), place("made/site.helio"));
    assert!(place(&city).contains("EPSG:28992") && place(&city).contains("latitude 5"), "{}", place(&city));
}
