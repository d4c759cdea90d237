//! Tables of buildings and roof faces: sums that another command gives too, regions that can be
//! counted by hand, and refusals.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::cli::{Folder, golden, stderr, stdout};

type Row = BTreeMap<String, String>;

fn table(text: &str) -> Vec<Row> {
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let names: Vec<String> = rows.headers().expect("names").iter().map(str::to_owned).collect();
    let row = |row: csv::StringRecord| names.iter().cloned().zip(row.iter().map(str::to_owned)).collect();
    rows.records().map(|record| row(record.expect("a row"))).collect()
}

fn number(text: &str) -> f64 {
    text.parse().expect("a number")
}

/// Builds a draft archive of receivers on the block of The Hague in a folder.
fn block() -> Folder {
    let folder = Folder::new();
    let model = Path::new(crate::ROOT).join("tests/data/cityjson/hague.city.json");
    for command in ["receivers MODEL -o r.csv", "build MODEL -r r.csv --quality draft -o site.helio"] {
        let done = folder.run(&command.replace("MODEL", &model.display().to_string()));
        assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    }
    folder
}

/// Returns rows of buildings and of faces, with a threshold in kWh/m2 over three days.
fn rows(folder: &Folder, options: &str) -> (Vec<Row>, Vec<Row>) {
    let done =
        folder.run(&format!("buildings site.helio --weather {} -o b.csv --faces f.csv {options}", golden().display()));
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    let read = |name: &str| table(&fs::read_to_string(folder.path(name)).expect(name));
    (read("b.csv"), read("f.csv"))
}

/// For 19 buildings and their 59 roof faces, areas, sums, sums by orientation and areas above a
/// threshold are the sums over the receivers of `replay --by receiver`, within 1e-4. Usable areas
/// are at most those above the threshold and, without a least area, the same.
#[test]
fn sums_are_those_of_receivers() {
    let folder = block();
    let (buildings, faces) = rows(&folder, "--threshold 10 --min-area 0");
    let replay =
        format!("replay site.helio --weather {} --every total --columns total --grid-north", golden().display());
    let sums = table(&stdout(&folder.run(&replay)));
    let sums: BTreeMap<&str, f64> =
        sums.iter().map(|row| (row["receiver"].as_str(), number(&row["total_kwh_m2"]))).collect();
    let mut known = BTreeMap::<String, f64>::new();
    for row in table(&fs::read_to_string(folder.path("r.csv")).expect("receivers")) {
        let (area, mean) = (number(&row["area_m2"]), sums[row["receiver"].as_str()]);
        let normal = ["nx", "ny", "nz"].map(|axis| number(&row[axis]));
        // Quarters of the horizon, computed in another way than the program does.
        let quarter = match (normal[0].abs() > normal[1].abs(), normal[0] > 0.0, normal[1] > 0.0) {
            _ if row["kind"] == "roof" && normal[2] > f64::cos(10_f64.to_radians()) => "flat",
            (true, east, _) => ["west", "east"][usize::from(east)],
            (false, _, north) => ["south", "north"][usize::from(north)],
        };
        let part = if row["kind"] == "roof" { "roof" } else { "facade" };
        let mut add = |key: String, amount: f64| *known.entry(key).or_default() += amount;
        for name in [row["building"].clone()].into_iter().chain((part == "roof").then(|| row["surface"].clone())) {
            add(format!("{name} {part}_area_m2"), area);
            add(format!("{name} {part}_kwh"), area * mean);
            add(format!("{name} {part}_{quarter}_kwh"), area * mean);
            if part == "roof" && mean >= 10.0 {
                add(format!("{name} above_threshold_m2"), area);
            }
        }
    }
    let close = |row: &Row, name: &str, column: &str, key: &str| {
        let (found, known) = (number(&row[column]), known.get(&format!("{name} {key}")).copied().unwrap_or_default());
        assert!((found - known).abs() <= 2e-3 + 1e-4 * known, "{name} {column}: {found} {known}");
    };
    assert_eq!((buildings.len(), faces.len()), (19, 59));
    for row in &buildings {
        for column in row.keys().filter(|name| name.ends_with("_kwh") && !name.starts_with("usable")) {
            close(row, &row["building"], column, column);
        }
        for column in ["roof_area_m2", "facade_area_m2", "above_threshold_m2"] {
            close(row, &row["building"], column, column);
        }
        assert_eq!(row["usable_area_m2"], row["above_threshold_m2"]);
    }
    for row in &faces {
        close(row, &row["face"], "area_m2", "roof_area_m2");
        close(row, &row["face"], "total_kwh", "roof_kwh");
        close(row, &row["face"], "above_threshold_m2", "above_threshold_m2");
        assert!((0.0..=1.0).contains(&number(&row["sky_view"])) && number(&row["share_of_best"]) <= 1.0);
    }
    let (larger, _) = rows(&folder, "--threshold 10 --min-area 40");
    let usable = |rows: &[Row]| rows.iter().map(|row| number(&row["usable_area_m2"])).sum::<f64>();
    assert!(usable(&larger) > 0.0 && usable(&larger) < usable(&buildings));
}

/// A house in the open has a roof of 4 x 6 squares of 1 m2, in the third row of which no square
/// reaches the threshold: regions of 8 and 12 m2 remain, and a least area of 10 m2 leaves one. The
/// best face is the one with that region, and a table in Parquet has the same 2 rows.
#[test]
fn roof_regions_below_the_least_area_do_not_count() {
    let folder = Folder::new();
    let mut text = String::from("receiver,x,y,z,nx,ny,nz,area,surface,object,building,kind,object_type,face,patch\n");
    let patch = "-500 -500 0;500 -500 0;500 500 0;-500 500 0";
    for i in 0..24 {
        let (x, y) = (0.5 + f64::from(i % 4), 0.5 + f64::from(i / 4));
        // A receiver that hardly looks up gets little light.
        let up = if i / 4 == 2 { "0,1,0.001" } else { "0,0,1" };
        text += &format!("r{i},{x},{y},10.02,{up},1,top,hall,house,roof,,,{patch}\n");
    }
    text += "low,5,-0.02,2,0,-1,0,3,front,hall,house,wall,,,\n";
    text += "shed,12,-20,0.02,0,0,1,5,lid,shed,,roof,,,\n";
    text += "lawn,15,5,0.02,0,0,1,7,lawn,garden,,ground,,,\n";
    folder.write("receivers.csv", &text);
    assert_eq!(folder.build().status.code(), Some(0));
    let (buildings, faces) = rows(&folder, "--threshold 8 --min-area 10");
    let cells = |row: &Row, names: [&str; 6]| names.map(|name| row[name].clone());
    let names = ["building", "roof_faces", "roof_area_m2", "above_threshold_m2", "usable_area_m2", "best_region_m2"];
    assert_eq!(cells(&buildings[0], names), ["house", "1", "24.000", "20.000", "12.000", "12.000"]);
    assert_eq!(cells(&buildings[1], names), ["shed", "1", "5.000", "5.000", "0.000", ""]);
    let names = ["face", "receivers", "area_m2", "regions", "largest_region_m2", "best_face"];
    let face = |row: &Row, name: &str| row.get(name).cloned().unwrap_or_default();
    assert_eq!(names.map(|name| face(&faces[0], name)), ["top", "24", "24.000", "1", "12.000", ""]);
    assert_eq!(buildings[0]["best_face"], "top");
    let roof: f64 = ["flat", "north"].iter().map(|side| number(&buildings[0][&format!("roof_{side}_kwh")])).sum();
    assert!((roof - number(&buildings[0]["roof_kwh"])).abs() < 0.01);
    let parquet =
        folder.run(&format!("buildings site.helio --weather {} -o b.parquet --threshold 8", golden().display()));
    assert_eq!(parquet.status.code(), Some(0), "{}", stderr(&parquet));
    let said = stderr(&parquet);
    assert!(said.contains("72 of the 8760 hours") && said.contains("1 roof face of site.helio"), "{said}");
    let bytes = fs::read(folder.path("b.parquet")).expect("the table");
    let reader = parquet::file::reader::SerializedFileReader::new(bytes::Bytes::from(bytes)).expect("Parquet");
    use parquet::file::reader::FileReader;
    let about = reader.metadata().file_metadata();
    assert_eq!((about.num_rows(), about.schema().get_fields().len()), (2, buildings[0].len()));
}

/// Thresholds below 0, NaN and in words, least areas below 0, an unknown extension, one name for
/// two tables, and archives without roofs, without names or without areas are refused: 9 of 9.
#[test]
fn wrong_thresholds_and_archives_are_refused() {
    let folder = Folder::new();
    let header = "receiver,x,y,z,nx,ny,nz,area,surface,object,building,kind\n";
    let buildings = |rest: &str| format!("buildings site.helio --weather {} {rest}", golden().display());
    let build = |rows: &str| {
        folder.write("receivers.csv", &format!("{header}{rows}"));
        assert_eq!(folder.build().status.code(), Some(0));
    };
    build("front,5,-0.02,2,0,-1,0,3,front,hall,house,wall\nlawn,15,5,0.02,0,0,1,7,lawn,garden,,ground\n");
    folder.fails(&buildings(""), "input lacks site.helio roofs");
    build("top,5,5,10.02,0,0,1,,top,hall,house,roof\n");
    folder.fails(&buildings(""), "input lacks site.helio area");
    build("top,5,5,10.02,0,0,1,3,top,,,roof\n");
    folder.fails(&buildings(""), "input lacks site.helio building");
    for (rest, expected) in [
        ("--threshold -1", "argument unreadable --threshold -1"),
        ("--threshold NaN", "argument unreadable --threshold NaN"),
        ("--threshold many", "argument unreadable --threshold many"),
        ("--min-area -3", "argument unreadable --min-area -3"),
        ("-o b.xlsx", "unsupported `b.xlsx`"),
        ("-o b.csv --faces b.csv", "input same-file b.csv b.csv"),
    ] {
        folder.fails(&buildings(rest), expected);
        assert!(!folder.path("b.csv").exists());
    }
}

/// The five best places of 1 x 1 m on the roofs of the block have sums between those that `replay`
/// gives to roofs, the highest first but for 0.1 %, and the fifth is above 90 % of the brightest;
/// they lie 0.2 m above the plane of their receiver; with `--object` places are of that building.
/// 1,000 places of 9 x 9 m are not found, which
/// is warned of. `pv` reads the table. 3 wrong inputs are refused.
#[test]
fn places_are_on_the_brightest_roofs() {
    let folder = block();
    let asked = format!("places site.helio --weather {} --grid-north", golden().display());
    let done = folder.run(&format!("{asked} --best 5 --module 1x1 --clearance 0.2 -o p.csv"));
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    let places = table(&fs::read_to_string(folder.path("p.csv")).expect("places"));
    let replay =
        format!("replay site.helio --weather {} --every total --columns total --grid-north", golden().display());
    let sums = table(&stdout(&folder.run(&replay)));
    let sums: BTreeMap<&str, f64> =
        sums.iter().map(|row| (row["receiver"].as_str(), number(&row["total_kwh_m2"]))).collect();
    let receivers = table(&fs::read_to_string(folder.path("r.csv")).expect("receivers"));
    let roofs: BTreeMap<&str, &Row> =
        receivers.iter().filter(|row| row["kind"] == "roof").map(|row| (row["receiver"].as_str(), row)).collect();
    assert_eq!(places.len(), 5);
    let mut before = f64::INFINITY;
    for place in &places {
        let (sum, receiver) = (number(&place["total_kwh_m2"]), roofs[place["receiver"].as_str()]);
        assert!(sum <= 1.001 * before, "{place:?}");
        let axes = [("x", "nx"), ("y", "ny"), ("z", "nz")];
        let above =
            axes.map(|(axis, along)| (number(&place[axis]) - number(&receiver[axis])) * number(&receiver[along]));
        // A plane holds receivers that are up to 5 cm off it.
        assert!((above.iter().sum::<f64>() - 0.2).abs() < 0.06, "{above:?}: {place:?}");
        before = sum;
    }
    let brightest = roofs.keys().map(|id| sums[id]).fold(0.0, f64::max);
    assert!(before > 0.9 * brightest && before <= brightest + 1e-3, "{before} of {brightest}");

    // Of one building, in both tables.
    let last = places[4]["building"].as_str();
    let own = table(&stdout(&folder.run(&format!("{asked} --best 2 --module 1x1 --object {last}"))));
    assert!(own.len() == 2 && own.iter().all(|place| place["building"] == last), "{own:?}");
    let buildings = format!("buildings site.helio --weather {} --grid-north --object {last}", golden().display());
    let own = table(&stdout(&folder.run(&buildings)));
    assert!(own.len() == 1 && own[0]["building"] == last, "{own:?}");

    let done = folder.run(&format!("{asked} --best 1000 --module 9x9"));
    assert!(stderr(&done).contains("found instead of 1000") && done.status.code() == Some(0), "{}", stderr(&done));
    let model = Path::new(crate::ROOT).join("tests/data/cityjson/hague.city.json");
    let pv =
        format!("pv {} -w {} --points p.csv --no-hourly --quality draft -o out", model.display(), golden().display());
    let done = folder.run(&pv);
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    let of_pv = table(&fs::read_to_string(folder.path("out/points.csv")).expect("points"));
    assert_eq!(of_pv.len(), 5);
    for (wrong, expected) in [
        ("--module 1", "argument unreadable --module 1"),
        ("--best 0", "argument out-of-range --best 0.0"),
        ("--on ground", "argument unknown --on ground"),
    ] {
        folder.fails(&format!("{asked} {wrong}"), expected);
    }
}

/// A roof of 12 x 5.49 m carries 30 modules of 1.1 x 1.8 m in three rows, whatever the spacing of
/// its receivers.
#[test]
fn rows_of_modules_fill_a_roof() {
    let folder = Folder::new();
    folder.write("s.obj", "v 0 0 5\nv 12 0 5\nv 12 4.5 8.15\nv 0 4.5 8.15\nusemtl roof\nf 1 2 3 4\n");
    for spacing in ["50cm", "2m"] {
        let run = |words: String| {
            let output = folder.run(&words);
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
            output
        };
        run(format!("receivers s.obj --on roof --spacing {spacing} -o r.csv"));
        run("build s.obj -r r.csv --latitude 52 --longitude 5 --quality draft --fresh -o s.helio".into());
        let done = run(format!("places s.helio --weather {} --best 99 -o -", golden().display()));
        let places = table(&stdout(&done));
        assert_eq!(places.len(), 30, "{spacing}");
        let heights: std::collections::BTreeSet<&str> = places.iter().map(|place| place["z"].as_str()).collect();
        assert_eq!(heights.len(), 3, "{heights:?}");
    }
}
