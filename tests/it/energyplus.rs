//! EnergyPlus models with reflected sun: the objects that are written, refusals, and results of
//! EnergyPlus itself.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::cli::{Folder, golden, stderr, stdout};

const BOX: &str = include_str!("../data/energyplus/box.idf");
const DRAFT: &str = "--physics energyplus --quality draft -o out";

fn model(name: &str) -> std::path::PathBuf {
    Path::new(crate::ROOT).join("tests/data/energyplus").join(name)
}

/// Writes `box.idf` with some words replaced.
fn boxed(changes: &[(&str, &str)]) -> Folder {
    let folder = Folder::new();
    let text = changes.iter().fold(BOX.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    folder.write("box.idf", &text);
    folder
}

/// Writes `out` from `box.idf`; returns the notes and warnings.
fn injected(folder: &Folder, arguments: &str) -> String {
    let output = folder.run(&format!("energyplus box.idf {arguments}"));
    assert_eq!(output.status.code(), Some(0), "{arguments}: {}", stderr(&output));
    stdout(&output) + &stderr(&output)
}

fn text(folder: &Folder, name: &str) -> String {
    fs::read_to_string(folder.path(name)).expect(name)
}

/// Parses objects of an IDF text as lists of fields, the class first.
fn objects(text: &str) -> Vec<Vec<String>> {
    let plain: String = text.lines().map(|line| line.split('!').next().unwrap_or_default().to_owned() + "\n").collect();
    let object = |part: &str| part.split(',').map(|field| field.trim().to_owned()).collect::<Vec<_>>();
    plain.split(';').filter(|part| !part.trim().is_empty()).map(object).collect()
}

fn of<'o>(objects: &'o [Vec<String>], class: &str) -> Vec<&'o Vec<String>> {
    objects.iter().filter(|object| object[0] == class).collect()
}

/// Returns the values of a table of a surface, `[azimuth][altitude]`: `P` fixed, `Q` by the ground,
/// found by its actuator; zeros if there is no table.
fn table(objects: &[Vec<String>], surface: &str, letter: &str) -> Vec<f64> {
    let actuator = of(objects, "EnergyManagementSystem:Actuator").into_iter().find(|a| a[2] == surface).expect(surface);
    let number = actuator[1].trim_start_matches("HT1_A");
    let name = format!("HT1_Table_{letter}{number}");
    let lookup = of(objects, "Table:Lookup").into_iter().find(|table| table[1] == name);
    let values = |table: &Vec<String>| table[11..].iter().map(|value| value.parse().expect("a number")).collect();
    lookup.map_or(vec![0.0; 703], values)
}

/// All bytes of an IDF model stay but for the solar distribution, with comments and LF or CR LF.
/// Behind them stand an actuator for each of 17 surfaces outdoors, the one that lies on the ground
/// too, 2 programs and 5 sensors.
#[test]
fn an_idf_keeps_its_text() {
    for text_of in [BOX.to_owned(), BOX.replace('\n', "\r\n")] {
        let folder = Folder::new();
        folder.write("box.idf", &text_of);
        injected(&folder, DRAFT);
        let written = text(&folder, "out/model.idf");
        let kept = text_of.replace("WithReflections", "");
        assert!(written.starts_with(&kept), "{}", &written[..kept.len().min(written.len())]);
        let added = &written[kept.len()..];
        assert_eq!(added.contains("\r\n"), text_of.contains("\r\n"));
        let added = objects(added);
        let count = |class: &str| of(&added, class).len();
        assert_eq!(count("EnergyManagementSystem:Actuator"), 17);
        assert_eq!(count("EnergyManagementSystem:Sensor"), 5);
        assert_eq!(count("EnergyManagementSystem:Program"), 2);
        assert_eq!(count("EnergyManagementSystem:CurveOrTableIndexVariable"), count("Table:Lookup"));
        let suns = |table: &Vec<String>| if table[1].contains("_S") { 73 * 37 } else { 37 * 19 };
        assert!(of(&added, "Table:Lookup").iter().all(|table| table.len() == 11 + suns(table)));
    }
}

/// An epJSON model keeps the order and digits of its contents: without the added classes and with
/// its own distribution it is the same text, and its 17 actuators name the surfaces as the model
/// does.
#[test]
fn an_epjson_keeps_its_text() {
    let folder = Folder::new();
    let before = fs::read_to_string(model("box.epJSON")).expect("a model");
    folder.write("box.epJSON", &before);
    let output = folder.run(&format!("energyplus box.epJSON {DRAFT}"));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let written = text(&folder, "out/model.epJSON");
    let end = before.trim_end().strip_suffix('}').expect("an object").trim_end();
    let kept = end.replace("FullExteriorWithReflections", "FullExterior");
    assert!(written.starts_with(&kept));
    let all: Value = serde_json::from_str(&written).expect("JSON");
    let actuators = all["EnergyManagementSystem:Actuator"].as_object().expect("actuators");
    assert_eq!(actuators.len(), 17);
    assert!(actuators.values().any(|actuator| actuator["actuated_component_unique_name"] == "South window"));
}

/// Under suns of the grid, P + 0.2 Q is the result of `query` with one reflection and a ground of
/// 0.2: 3 suns, 16 surfaces, within 0.01 W/m2 of up to 100. (A mirror makes two of the surfaces
/// brighter; its light has a table of its own.)
#[test]
fn tables_hold_what_a_query_gives() {
    let folder = boxed(&[]);
    injected(&folder, DRAFT);
    let suns: [(usize, usize); 3] = [(120, 45), (200, 60), (300, 20)];
    let rows = suns.map(|(azimuth, altitude)| format!("a{azimuth},{azimuth},{altitude},1000,0\n")).concat();
    folder.write("suns.csv", &format!("condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\n{rows}"));
    let query = "replay out/site.helio --conditions suns.csv --paths none --by surface --reflectance ground=0.2 --columns sun_reflected";
    let output = folder.run(query);
    let lines = stdout(&output);
    let objects = objects(&text(&folder, "out/model.idf"));
    let mut compared = 0;
    for line in lines.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let (azimuth, altitude) = suns[suns.iter().position(|sun| cells[0] == format!("a{}", sun.0)).expect("a sun")];
        let at = azimuth / 10 * 19 + altitude / 5;
        let [fixed, by_ground] = ["P", "Q"].map(|letter| table(&objects, cells[1], letter)[at]);
        let value: f64 = cells[2].parse().expect("a number");
        assert!((fixed + 0.2 * by_ground - value).abs() < 0.01, "{line}: {fixed} {by_ground}");
        compared += 1;
    }
    assert_eq!(compared, 3 * 16, "{lines}");
}

/// 8 models that cannot get injected light are refused with exit code 2; no model is written.
#[test]
fn models_that_cannot_get_light_are_refused() {
    let outdoors = |folder: &Folder| {
        let none: String = BOX
            .lines()
            .filter(|line| {
                ["Wall:", "Roof,", "Window,", "Door,", "GlazedDoor,", "Fenestration", "Shading:Overhang", "Shading:Fin"]
                    .iter()
                    .all(|class| !line.starts_with(class))
            })
            .map(|line| line.replace("Outdoors, , SunExposed", "Adiabatic, , NoSun") + "\n")
            .collect();
        folder.write("box.idf", &none);
    };
    type Changes = &'static [(&'static str, &'static str)];
    let cases: [(Changes, &str); 5] = [
        (&[("Version, 25.2;", "Version, 9.6;")], "input other-version box.idf:3 9.6"),
        (&[("Version, 25.2;", "Version, 26.1;")], "input other-version box.idf:3 26.1"),
        (&[("Window, Skylight,", "Window, SOUTH window,")], "input duplicate box.idf:25 SOUTH window"),
        (
            &[(
                "Output:Surfaces:List, D",
                "EnergyManagementSystem:Actuator, a, East, Surface, View Factor To Ground;\nOutput:Surfaces:List, D",
            )],
            "input duplicate box.idf:46 East",
        ),
        (&[("Version, 25.2;", "##include x.idf")], "unsupported the macro `##include x.idf`"),
    ];
    for (changes, expected) in cases {
        let folder = boxed(changes);
        folder.fails(&format!("energyplus box.idf {DRAFT}"), expected);
        assert!(!folder.path("out/model.idf").exists(), "{expected}");
    }
    let folder = Folder::new();
    outdoors(&folder);
    folder.fails(&format!("energyplus box.idf {DRAFT}"), "input empty box.idf");
    folder.fails(&format!("energyplus scene.obj {DRAFT}"), "input ending scene.obj");
    folder.fails(&format!("energyplus box.idf {DRAFT} --run"), "argument missing --weather");
}

/// Models of 24.1, 24.2 and 25.1 are accepted with one warning, and models of 9.6 and 26.1 if 25.2
/// is assumed: 5 models. An epJSON model of 23.1 is refused with the tool that converts it.
#[test]
fn other_versions_get_a_warning_or_are_refused() {
    for (version, more, said) in [
        ("24.1", "", "the model was written for EnergyPlus 24.1: EnergyPlus 25.2 runs it with a warning"),
        ("24.2.0", "", "the model was written for EnergyPlus 24.2.0"),
        ("25.1", "", "the model was written for EnergyPlus 25.1"),
        ("9.6", "--assume-version 25.2", "states EnergyPlus 9.6 but is read as 25.2"),
        ("26.1", "--assume-version 25.2", "states EnergyPlus 26.1 but is read as 25.2"),
    ] {
        let folder = boxed(&[("Version, 25.2;", &format!("Version, {version};"))]);
        let printed = injected(&folder, &format!("{DRAFT} {more}"));
        assert_eq!(printed.matches(said).count(), 1, "{version}: {printed}");
        assert!(text(&folder, "out/report.md").contains(said));
    }
    let folder = Folder::new();
    let json = fs::read_to_string(model("box.epJSON")).expect("a model");
    folder.write("box.epJSON", &json.replace("\"25.2\"", "\"24.2\"").replace("\"24.2\"", "\"23.1\""));
    folder.fails(&format!("energyplus box.epJSON {DRAFT}"), "input other-version box.epJSON 23.1");
}

/// A schedule's file beside a model in another folder gets its absolute name in the new model, and
/// a missing file is warned of: 1 and 1.
#[test]
fn files_of_the_model_get_absolute_names() {
    let schedules = "Schedule:File, Half, , half.csv, 1, 0;\nSchedule:File, Lost, , lost.csv, 1, 0;\nZone, Hall";
    let folder = Folder::new();
    fs::create_dir(folder.path("models")).expect("made");
    folder.write("models/box.idf", &BOX.replacen("Zone, Hall", schedules, 1));
    folder.write("models/half.csv", "1\n");
    let output = folder.run(&format!("energyplus models/box.idf {DRAFT}"));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = stdout(&output) + &stderr(&output);
    assert!(said.contains("EnergyPlus looks for these files beside the new model: copy them there (1)"), "{said}");
    let objects = objects(&text(&folder, "out/model.idf"));
    let names: Vec<&str> = of(&objects, "Schedule:File").iter().map(|object| object[3].as_str()).collect();
    assert_eq!(names[1], "lost.csv");
    assert!(Path::new(names[0]).is_absolute() && Path::new(names[0]).is_file(), "{names:?}");
    let report = text(&folder, "out/report.md");
    assert!(report.contains("half.csv") && report.contains("`lost.csv` of Schedule:File `Lost`"), "{report}");
}

/// A neighbour against the lower half of a wall hides part of its area: the report says how much of
/// 1 wall gets light, less than 90 %, and a warning counts the surfaces.
#[test]
fn the_report_states_the_lit_share_of_a_wall() {
    let folder = boxed(&[]);
    let at = |z: f64| {
        [(-1.0, -5.0), (9.0, -5.0), (9.0, 0.02), (-1.0, 0.02)].map(|(x, y)| format!("v {x} {y} {z}\n")).concat()
    };
    let faces = "usemtl white\nf 4 3 2 1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 5 6 7 8\n";
    folder.write("block.obj", &(at(-0.5) + &at(1.0) + faces));
    let said = injected(&folder, &format!("{DRAFT} --scene block.obj"));
    assert!(said.contains("partly hidden by a neighbour or the ground"), "{said}");
    let report = text(&folder, "out/report.md");
    let line = report.lines().find(|line| line.contains("m2 get light, the rest is hidden")).expect("a line");
    let numbers: Vec<f64> = line.split(' ').filter_map(|word| word.parse().ok()).collect();
    assert!(numbers.len() == 2 && 0.0 < numbers[0] && numbers[0] < 0.9 * numbers[1], "{line}");
}

/// A model that heliotile has written is refused. So is other spacing in a folder with results,
/// which `--replace` replaces. Equal inputs trace nothing again: 2 refusals.
#[test]
fn existing_results_are_kept() {
    let folder = boxed(&[]);
    injected(&folder, DRAFT);
    folder.fails("energyplus out/model.idf -o other", "input duplicate out/model.idf:2647 East");
    let first = text(&folder, "out/model.idf");
    let said = injected(&folder, DRAFT);
    assert!(said.contains("nothing is traced again") && text(&folder, "out/model.idf") == first, "{said}");
    let wider = format!("{DRAFT} --spacing 2m");
    folder.fails(&format!("energyplus box.idf {wider}"), "input other-inputs out");
    injected(&folder, &format!("{wider} --replace"));
    assert_ne!(text(&folder, "out/model.idf"), first);
}

/// If the ground reflects nothing in January, 0.01 is written and the program subtracts its light
/// in month 1; other months keep their 0.3. A distribution with interior light keeps that.
#[test]
fn black_ground_in_january_is_written_as_0_01() {
    let months = "Site:GroundReflectance, 0, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3;\nZone, Hall";
    let folder = boxed(&[("Zone, Hall", months), ("FullExteriorWith", "FullInteriorAndExteriorWith")]);
    let said = injected(&folder, DRAFT);
    assert!(said.contains("reflects nothing in 1 of 12 months"), "{said}");
    let objects = objects(&text(&folder, "out/model.idf"));
    let ground = of(&objects, "Site:GroundReflectance");
    assert_eq!((ground[0][1].as_str(), ground[0][2].as_str()), ("0.01", "0.3"));
    assert_eq!(of(&objects, "Building")[0][6], "FullInteriorAndExterior");
    let program = of(&objects, "EnergyManagementSystem:Program")[0].join("\n");
    assert_eq!(program.matches("IF Month == 1").count(), 1, "{program}");
}

/// Names with commas and quotes work in epJSON: the actuator of 1 window bears such a name, and the
/// report shows it.
#[test]
fn names_with_commas_work_in_epjson() {
    let folder = Folder::new();
    let before = fs::read_to_string(model("box.epJSON")).expect("a model");
    folder.write("box.epJSON", &before.replace("\"South window\"", "\"South, \\\"big\\\" | window\""));
    let output = folder.run(&format!("energyplus box.epJSON {DRAFT}"));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let all: Value = serde_json::from_str(&text(&folder, "out/model.epJSON")).expect("JSON");
    let actuators = all["EnergyManagementSystem:Actuator"].as_object().expect("actuators").values();
    let named = actuators.filter(|a| a["actuated_component_unique_name"] == "South, \"big\" | window");
    assert_eq!(named.count(), 1);
    assert!(text(&folder, "out/report.md").contains("| South, \"big\" \\| window | window |"));
}

/// 4 uses of the model that ignore injected light are warned of, and a window over the edge of its
/// wall gets the wall's tables.
#[test]
fn uses_that_ignore_injected_light_are_warned_of() {
    let more = "WindowShadingControl, c, Hall, 1, ExteriorBlind, , OnIfHighSolarOnWindow, , 20, No, No, , , , , , South window;\n\
                Daylighting:Controls, d, Hall;\nGenerator:Photovoltaic, p, Roof, PhotovoltaicPerformance:Simple;\nZone, Hall";
    let folder = boxed(&[("Zone, Hall", more), ("South, , 1, 1, 1, 3, 1.2", "South, , 1, 6, 1, 3, 1.2")]);
    let said = injected(&folder, DRAFT);
    for part in [
        "exterior blinds and screens",
        "shading controls follow",
        "daylighting controls",
        "PV modules and solar collectors",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let report = text(&folder, "out/report.md");
    assert!(report.contains("South window: reaches over an edge of `south`"), "{report}");
    let objects = objects(&text(&folder, "out/model.idf"));
    let program: Vec<&String> = of(&objects, "EnergyManagementSystem:Program").into_iter().flatten().collect();
    let actuator =
        of(&objects, "EnergyManagementSystem:Actuator").into_iter().find(|a| a[2] == "South window").expect("one");
    let walls = of(&objects, "EnergyManagementSystem:Actuator").into_iter().find(|a| a[2] == "South").expect("one");
    let sky =
        |name: &str| program.iter().find_map(|line| line.strip_prefix(&format!("SET {name} = HT1_D"))).expect("a line");
    assert_eq!(sky(&actuator[1]), sky(&walls[1]));
}

/// A block of 20 m in front of the model becomes 5 shading surfaces of its own faces, which the
/// model alone lacks, and makes the wall that faces it brighter by reflection. Surroundings in
/// national coordinates are refused without `--at`.
#[test]
fn surroundings_become_shades_and_brighten_a_wall() {
    let folder = boxed(&[]);
    let corners = [(-30, -30, 0), (10, -30, 0), (10, -20, 0), (-30, -20, 0)];
    let at = |z: i32, e: i32| corners.map(|(x, y, _)| format!("v {} {} {z}\n", x + e, y + e)).concat();
    let faces = "usemtl white\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 5 6 7 8\n";
    folder.write("block.obj", &(at(0, 0) + &at(20, 0) + faces));
    folder.write("far.obj", &(at(0, 400_000) + &at(20, 400_000) + faces));
    folder.write("white.toml", "[white]\ndiffuse = 0.8\n");
    let base = format!("{DRAFT} --materials white.toml");
    let said = injected(&folder, &format!("{base} --scene block.obj"));
    assert!(said.contains("5 polygons as Shading:Site:Detailed"), "{said}");
    let near = objects(&text(&folder, "out/model.idf"));
    assert_eq!(of(&near, "Shading:Site:Detailed").len(), 5);
    let p = |objects: &[Vec<String>]| table(objects, "South", "P").iter().sum::<f64>() / 703.0;
    injected(&folder, &base.replace("-o out", "-o alone"));
    let alone = objects(&text(&folder, "alone/model.idf"));
    assert_eq!(of(&alone, "Shading:Site:Detailed").len(), 0);
    folder.fails(&format!("energyplus box.idf {base} --scene far.obj --replace"), "input misplaced far.obj");
    let moved = base.replace("-o out", "-o moved");
    injected(&folder, &format!("{moved} --scene far.obj --at 400000,400000"));
    let moved = objects(&text(&folder, "moved/model.idf"));
    assert_eq!(of(&moved, "Shading:Site:Detailed"), of(&near, "Shading:Site:Detailed"));
    assert!((p(&moved) / p(&near) - 1.0).abs() < 0.03, "{} {}", p(&moved), p(&near));
    assert!(p(&near) > p(&alone) + 5.0, "{} {}", p(&near), p(&alone));
}

/// Without its surroundings the box has none of 3 shades around it and all 6 shades of its zones;
/// 17 surfaces read 22 columns of a table of 35,040 steps below one line of names. At noon of 21
/// June, where a step has the hour's light and the sun of its middle, the light of 5 surfaces is
/// that of `replay` with the surroundings less that without, within 0.02 W/m2.
#[test]
fn removed_surroundings_leave_their_light_in_tables() {
    let folder = boxed(&[]);
    let weather = golden().with_file_name("golden_tmy3.epw");
    let weather = weather.to_str().expect("a path");
    let said = injected(&folder, &format!("{DRAFT} --spacing 1m --delete-surroundings --weather {weather}"));
    assert!(
        said.contains(
            "3 shading surfaces removed from the model, 16 surfaces get light from series.csv, 1 surface none (hidden)"
        ),
        "{said}"
    );
    let model = objects(&text(&folder, "out/model.idf"));
    let count = |class: &str| of(&model, class).len();
    let gone = ["Shading:Building", "Shading:Site", "Shading:Building:Detailed", "ShadingProperty:Reflectance"];
    assert_eq!(gone.map(count), [0; 4]);
    let kept = ["Shading:Overhang", "Shading:Fin:Projection", "Shading:Zone:Detailed", "Schedule:File", "Table:Lookup"];
    assert_eq!(kept.map(count), [4, 1, 1, 22, 0]);
    assert_eq!(of(&model, "ShadowCalculation")[0][2], "Timestep");
    assert!(
        of(&model, "Schedule:File")
            .iter()
            .all(|file| file[3] == "series.csv" && file[5..] == ["1", "8760", "Comma", "No", "15", "No"])
    );
    let series = text(&folder, "out/series.csv");
    let rows: Vec<&str> = series.lines().collect();
    let head: Vec<&str> = rows[0].split(',').map(|name| name.trim_matches('"')).collect();
    assert_eq!((rows.len(), head.len()), (1 + 35_040, 22));
    // 31 + 28 + 31 + 30 + 31 + 20 days lie before; the second of four steps ends at half past.
    let noon: Vec<f64> =
        rows[1 + (171 * 24 + 12) * 4 + 1].split(',').map(|cell| cell.parse().expect("a number")).collect();
    let replayed = |archive: &str, more: &str| {
        let asked = "--from 06-21 --to 06-21 --steps 1 --by surface";
        let output = folder.run(&format!("replay out/{archive} --weather {weather} {asked} {more}"));
        stdout(&output).lines().filter(|line| line.contains("T12:00")).map(str::to_owned).collect::<Vec<_>>()
    };
    let direct = "--sky perez1990 --columns sun_direct,sky_direct";
    let reflected = "--sky uniform --paths none --reflectance ground=0.2 --columns sun_reflected,sky_reflected,sun_mirrored,sky_mirrored";
    let all =
        [("site.helio", direct), ("stripped.helio", direct), ("site.helio", reflected)].map(|(a, m)| replayed(a, m));
    for surface in ["East", "North", "Roof", "South window", "West door"] {
        let cells = |lines: &[String]| -> Vec<f64> {
            let line = lines.iter().find(|line| line.contains(&format!(",{surface},"))).expect(surface);
            line.split(',').skip(2).map(|cell| cell.parse().expect("a number")).collect()
        };
        let [full, alone, more] = [&all[0], &all[1], &all[2]].map(|lines| cells(lines));
        let column = |name: String| head.iter().position(|head| *head == name).map(|at| noon[at]);
        let m = column(format!("{surface} multiplier")).unwrap_or(1.0);
        if surface.len() > 5 {
            let share = if alone[0] < 0.5 { 1.0 } else { (full[0] / alone[0]).clamp(0.001, 1.0) };
            assert!((m - share).abs() < 1e-3, "{surface}: {m} {share}");
        }
        let reflected: f64 = more[..4].iter().sum();
        let wanted = (reflected + full[0] + full[1] - m * (alone[0] + alone[1])) / m;
        let value = column(format!("{surface} W/m2")).expect(surface);
        assert!((value - wanted).abs() < 0.02, "{surface}: {value} {wanted}");
    }
    folder.fails(&format!("energyplus box.idf {DRAFT} --delete-surroundings"), "argument missing --weather");
    let days = format!("{DRAFT} --delete-surroundings --weather {}", golden().display());
    folder.fails(&format!("energyplus box.idf {days}"), "input lacks golden_3_days.epw hours");
}

/// EnergyPlus itself runs the written model: over three days of March the sun that opaque surfaces
/// absorb is within 1 % of its own reflections, and leaving reflections out changes it by more;
/// with the surroundings in the model and without. The test prints that it is skipped if
/// HELIOTILE_ENERGYPLUS names no EnergyPlus.
#[test]
fn energyplus_absorbs_the_sun_of_its_own_reflections() {
    let Some(engine) = std::env::var_os("HELIOTILE_ENERGYPLUS") else {
        eprintln!("not run: HELIOTILE_ENERGYPLUS names no folder of EnergyPlus 25.2");
        return;
    };
    let days = "RunPeriod, day, 3, 20, , 3, 22";
    let folder = boxed(&[("RunPeriod, day, 1, 1, , 1, 1", days), ("No, No, No, Yes, No", "No, No, No, No, Yes")]);
    for (out, more) in [("out", ""), ("bare", "--delete-surroundings")] {
        let mut command = folder.command(&format!(
            "energyplus box.idf --physics energyplus --quality draft --run -o {out} {more} --weather"
        ));
        let output = command
            .arg(golden().with_file_name("golden_tmy3.epw"))
            .arg("--energyplus")
            .arg(&engine)
            .output()
            .expect("the program");
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let report = text(&folder, &format!("{out}/report.md"));
        let section = report.split("## Sun absorbed by opaque surfaces").nth(1).expect("a section");
        let all = section.lines().find(|line| line.starts_with("| all |")).expect("a sum");
        let cells: Vec<f64> = all.split('|').filter_map(|cell| cell.trim().parse().ok()).collect();
        let (without, ours) = (cells[3], cells[4]);
        assert!(ours.abs() < 1.0 && without.abs() > ours.abs(), "{out}: {all}");
    }
}

/// A storey at 30 m has its ground at z = 0: on 10 June of Golden each of its four walls absorbs
/// more than 1 W/m2, within 0.5 % of the sun that EnergyPlus's own reflections give it. The test
/// prints that it is skipped if HELIOTILE_ENERGYPLUS names no EnergyPlus.
#[test]
fn a_storey_at_30_m_has_its_ground_at_zero() {
    let Some(engine) = std::env::var_os("HELIOTILE_ENERGYPLUS") else {
        eprintln!("not run: HELIOTILE_ENERGYPLUS names no folder of EnergyPlus 25.2");
        return;
    };
    let folder = Folder::new();
    folder.write("storey.idf", &fs::read_to_string(model("floor_at_30m.idf")).expect("a model"));
    let asked = "energyplus storey.idf --physics energyplus --quality draft --run -o out --weather";
    let mut command = folder.command(asked);
    let output = command.arg(golden().with_file_name("golden_tmy3.epw")).arg("--energyplus").arg(&engine).output();
    let output = output.expect("the program");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(
        stdout(&output).contains("ground: a plane at 0.00 m") || stderr(&output).contains("ground: a plane at 0.00 m")
    );
    let report = text(&folder, "out/report.md");
    let section = report.split("## Sun absorbed by opaque surfaces").nth(1).expect("a section");
    for wall in ["S", "E", "N", "W"] {
        let line = section.lines().find(|line| line.starts_with(&format!("| {wall} |"))).expect(wall);
        let cells: Vec<f64> = line.split('|').filter_map(|cell| cell.trim().parse().ok()).collect();
        assert!(cells[1] > 1.0 && cells[4].abs() < 0.5, "{line}");
    }
}

/// The strips above and below a window that is 0.2 mm narrower than its wall have receivers of
/// their own at 10, 3 and 1 m: the wall gets 372 of 1000 W/m2 of sky by the ground, within 3 %, at
/// each spacing.
#[test]
fn a_window_as_wide_as_its_wall_leaves_two_strips() {
    let folder = Folder::new();
    folder.write("ribbon.idf", &fs::read_to_string(model("ribbon_window_sliver.idf")).expect("a model"));
    for spacing in ["10m", "3m", "1m"] {
        let done =
            folder.run(&format!("energyplus ribbon.idf --physics energyplus --replace --spacing {spacing} -o out"));
        assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
        let report = text(&folder, "out/report.md");
        let line = report.lines().find(|line| line.starts_with("| N | wall |")).expect("a row");
        let cells: Vec<f64> = line.split('|').filter_map(|cell| cell.trim().parse().ok()).collect();
        let (receivers, sky) = (cells[1], cells[cells.len() - 1]);
        assert!(receivers >= 2.0 && (sky / 372.2 - 1.0).abs() < 0.03, "{spacing}: {line}");
    }
}
