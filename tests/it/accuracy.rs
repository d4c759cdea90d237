//! Accuracy as a number: builds for a target error, and the report of what accuracy costs.

use std::fs;

use glam::DVec3;
use heliotile_core::archive::Archive;

use crate::cli::{Folder, stdout};
use crate::scenes::{town, v};

/// Writes twelve blocks on a square as files, and 40 receivers on the ground and on walls.
fn site() -> Folder {
    let folder = Folder::new();
    let (mut obj, mut vertices) = (String::new(), 0);
    for (corners, material) in &town() {
        obj += &format!("usemtl {}\n", ["grass", "wall"][usize::from(*material)]);
        for p in corners {
            obj += &format!("v {} {} {}\n", p.x, p.y, p.z);
        }
        obj += &format!("f {} {} {}\n", vertices + 1, vertices + 2, vertices + 3);
        vertices += 3;
    }
    folder.write("scene.obj", &obj);
    let mut receivers = String::from("receiver,x,y,z,nx,ny,nz\n");
    for i in 0..40 {
        let (x, y) = (f64::from(i % 4) * 22.0 - 44.0, f64::from(i / 4 % 3) * 25.0 - 37.0);
        let (place, normal) = match i % 2 {
            0 => (v(x + 15.0, y + f64::from(i) / 4.0, 0.02), DVec3::Z),
            _ => (v(x + 2.0 + f64::from(i) / 5.0, y - 0.02, 1.0 + f64::from(i) / 10.0), DVec3::NEG_Y),
        };
        receivers += &format!("r{i},{},{},{},{},{},{}\n", place.x, place.y, place.z, normal.x, normal.y, normal.z);
    }
    folder.write("receivers.csv", &receivers);
    folder
}

/// Parses the number behind a word.
fn after(text: &str, word: &str) -> f64 {
    let rest = text.split(word).nth(1).unwrap_or_else(|| panic!("`{word}` is not in {text}"));
    let digits: String = rest.trim_start().chars().take_while(|c| c.is_ascii_digit() || "-.".contains(*c)).collect();
    digits.parse().expect("a number")
}

/// Builds for 4 % and 1 % expect no more than that and find it on all receivers within a factor
/// of 2. The archive states the error, and is the same on one thread. The archive for 1 % has more
/// bytes. `info` shows the error and its tiles; a part of the site keeps the error without the
/// tiles.
#[test]
fn targets_are_kept() {
    let folder = site();
    let inputs = "build scene.obj -m materials.toml -r receivers.csv";
    let mut bytes = Vec::new();
    for target in [4.0, 1.0] {
        let said = stdout(&folder.run(&format!("{inputs} -o {target}.helio --error {target}%")));
        let archive = Archive::open(&folder.path(&format!("{target}.helio"))).expect("an archive");
        let stated = archive.manifest().accuracy.clone().expect("an estimate");
        let [expected, found] = [stated.predicted_percent, stated.rmse_percent];
        assert!(expected <= target && stated.target_percent == target, "{stated:?}");
        assert!(found < 2.0 * expected && expected < 2.0 * found, "{stated:?}");
        assert!((after(&said, "error: ") - expected).abs() < 0.006, "{said}");
        assert!((after(&said, "% expected, ") - found).abs() < 0.006, "{said}");
        assert_eq!((stated.sample, stated.conditions, stated.components_percent.len()), (40, 512, 6));
        let sun = stated.components_percent["sun_direct"];
        assert!(sun > 0.0 && sun <= found, "{stated:?}");
        bytes.push(fs::metadata(archive.path()).expect("a file").len());
    }
    assert!(bytes[1] > bytes[0], "{bytes:?}");
    let mut alone = folder.command(&format!("{inputs} -o alone.helio --error 4%"));
    assert!(alone.env("RAYON_NUM_THREADS", "1").status().expect("the program").success());
    let read = |name: &str| fs::read(folder.path(name)).expect(name);
    assert!(read("alone.helio") == read("4.helio"));

    let info = stdout(&folder.run("info 1.helio"));
    assert!(info.contains("RMSE of hourly totals; target 1 %") && info.contains("tile 0 (40 receivers): "), "{info}");
    folder.write("some.csv", "receiver\nr1\nr2\n");
    assert_eq!(folder.run("archive extract 1.helio -r some.csv -o some.helio").status.code(), Some(0));
    let some = Archive::open(&folder.path("some.helio")).expect("an archive").manifest().accuracy.clone();
    let some = some.expect("an estimate");
    assert!(some.tiles.is_empty() && some.rmse_percent > 0.0);
}

/// A build for 2 % states errors of all hours, and of hours without direct sun. An audit of all
/// receivers by other paths in other hours finds both within a factor of 1.5, and `info` states
/// them in percent and W/m2.
#[test]
fn stated_errors_hold_in_hours_without_direct_sun() {
    let folder = site();
    let inputs = "scene.obj -m materials.toml";
    let said = stdout(&folder.run(&format!("build {inputs} -r receivers.csv -o site.helio --error 2%")));
    assert!(said.contains("in hours with no direct sun ("), "{said}");
    let archive = Archive::open(&folder.path("site.helio")).expect("an archive");
    let stated = archive.manifest().accuracy.clone().expect("an estimate");
    let shaded = stated.hours.iter().find(|hours| hours.hours == "no direct sun").expect("hours without sun");
    assert!(shaded.share_percent > 10.0 && shaded.mean_w_m2 < stated.mean_w_m2 && shaded.receivers > 20, "{stated:?}");
    // Reflected light is off by no more than the total may be.
    assert!(shaded.reflected_w_m2 <= 0.02 * stated.mean_w_m2 && shaded.rmse_w_m2 > 0.0, "{stated:?}");
    let audit = folder.run(&format!("archive audit site.helio {inputs} --samples 40 --paths 4096 --seed 5"));
    let said = stdout(&audit);
    assert_eq!(audit.status.code(), Some(0), "{said}");
    let row = said.lines().find(|line| line.starts_with("no direct sun")).expect("a row");
    let numbers: Vec<f64> = row.split_whitespace().rev().take(2).map(|word| word.parse().expect("a number")).collect();
    let factor = numbers[1] / numbers[0];
    assert!((0.8..1.25).contains(&(numbers[0] / shaded.rmse_percent())), "{row} {shaded:?}");
    assert!((1.0 / 1.5..1.5).contains(&factor), "{row}");
    let total = after(&said, "RMSE of totals: ") / after(&said, "mean total ") * 100.0;
    assert!((1.0 / 1.5..1.5).contains(&(total / after(&said, "stated: "))), "{said}");
    let info = stdout(&folder.run("info site.helio"));
    assert!(info.contains(&format!("({:.2} of {} W/m2)", stated.rmse_w_m2(), stated.mean_w_m2)), "{info}");
    assert!(info.contains("in hours with no direct sun ("), "{info}");
}

/// In a report of 8 rungs, errors fall from draft to standard to fine to reference. The mean
/// absolute error of the sky texture falls by 16 or more from 128 to 2048 texels a side, that of
/// cells by 4 or more from 16 footprints to 1, beside a hemisphere for every hit. The page holds 3
/// pictures and loads no other file.
#[test]
fn finer_quality_has_smaller_errors() {
    let folder = site();
    let output = folder.run("tradeoff scene.obj -m materials.toml -r receivers.csv -o report --sample 10 --sources");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| fs::read_to_string(folder.path("report").join(name)).expect(name);
    let rows = |text: String| -> Vec<Vec<String>> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        reader.records().map(|row| row.expect("a row").iter().map(String::from).collect()).collect()
    };
    let ladder = rows(read("tradeoff.csv"));
    assert_eq!(ladder.len(), 8);
    let error = |name: &str| -> f64 {
        let row = ladder.iter().find(|row| row[0] == name).expect(name);
        row[13].parse().expect("a number")
    };
    let [draft, standard, fine, reference] = ["draft", "standard", "fine", "reference"].map(error);
    assert!(draft > standard && standard > fine && fine > reference && reference > 0.0, "{ladder:?}");
    let sources = rows(read("sources.csv"));
    let absolute = |setting: &str, value: &str| -> f64 {
        let row = sources.iter().find(|row| row[0] == setting && row[1] == value).expect(setting);
        row[4].parse().expect("a number")
    };
    assert!(absolute("sky_fine", "128") > 16.0 * absolute("sky_fine", "2048"), "{sources:?}");
    assert!(absolute("cell_factor", "16") > 4.0 * absolute("cell_factor", "1"), "{sources:?}");
    assert!(absolute("patches", "145") > absolute("patches", "577"), "{sources:?}");
    let beside: serde_json::Value = serde_json::from_str(&read("tradeoff.csv-metadata.json")).expect("JSON");
    let columns = beside["tableSchema"]["columns"].as_array().expect("columns").len();
    assert_eq!(columns, read("tradeoff.csv").lines().next().unwrap_or_default().split(',').count());
    for picture in ["error_time.svg", "error_bytes.svg", "sources.svg"] {
        let svg = read(picture);
        assert!(
            svg.starts_with("<svg ")
                && svg.matches("<metadata>{\"heliotile.command\":\"heliotile tradeoff ").count() == 1
        );
    }
    let page = read("index.html");
    assert_eq!(page.matches("<svg").count(), 3);
    assert!(!page.contains("src=") && !page.contains("href="), "{page}");
    assert!(page.contains("<b>standard</b>") && page.contains("The best bargain here is"));
    assert_eq!(fs::read_dir(folder.path("report")).expect("a folder").count(), 8);
}

/// Errors that are no percentages, a target beside a quality or settings, missing weather, a report
/// in place of a file, missing receivers, and a clock without a weather file are refused: 10 of 10.
#[test]
fn wrong_accuracy_requests_are_refused() {
    let folder = Folder::new();
    let build = "build scene.obj -m materials.toml -r receivers.csv -o x.helio";
    folder.fails(&format!("{build} --error 0%"), "argument unreadable --error 0%");
    folder.fails(&format!("{build} --error two"), "argument unreadable --error two");
    folder.fails(&format!("{build} --error 2% --quality fine"), "argument excludes --error --quality");
    folder.fails(&format!("{build} --error 2% --set hit=16"), "argument excludes --error --set");
    folder.fails(&format!("{build} --error 2% --error-weather no.epw"), "missing-file no.epw");
    folder.fails("tradeoff scene.obj -m materials.toml -r receivers.csv -o scene.obj", "input ending scene.obj");
    folder.fails("tradeoff scene.obj -m materials.toml -r no.csv -o report", "missing-file no.csv");
    folder.fails(&format!("{build} --shift 30min"), "argument missing --weather");
    folder.fails(
        "build --dry-run scene.obj -r receivers.csv --error 2% --time-zone +01:00",
        "argument missing --weather",
    );
    folder.fails("tradeoff scene.obj -r receivers.csv -o report --weather-stamp end", "argument missing --weather");
    assert!(!folder.path("x.helio").exists() && !folder.path("report").exists());
}
