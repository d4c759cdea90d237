//! City models written with sums: additions in the right places, and no other change.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::cli::{Folder, golden, stderr, stdout};

fn model(name: &str) -> PathBuf {
    Path::new(crate::ROOT).join("tests/data/cityjson").join(name)
}

/// Builds a draft archive of receivers on a city model in a folder.
fn site(name: &str, options: &str) -> Folder {
    let folder = Folder::new();
    let model = model(name);
    let covered = folder.run(&format!("receivers {} --spacing 4 -o r.csv {options}", model.display()));
    assert_eq!(covered.status.code(), Some(0), "{}", stderr(&covered));
    let built = folder.run(&format!("build {} -r r.csv --quality draft -o site.helio", model.display()));
    assert_eq!(built.status.code(), Some(0), "{}", stderr(&built));
    folder
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

/// Removes the additions; returns their number.
fn strip(value: &mut Value) -> usize {
    let mut count = 0;
    match value {
        Value::Object(members) => {
            let before = members.len();
            members.retain(|key, _| !key.starts_with("heliotile"));
            count += before - members.len();
            if let Some(Value::Object(themes)) = members.get_mut("material") {
                themes.remove("irradiation");
            }
            if let Some(Value::Array(materials)) = members.get_mut("materials") {
                materials.retain(|m| !m["name"].as_str().is_some_and(|name| name.starts_with("irradiation ")));
            }
            count += members.values_mut().map(strip).sum::<usize>();
            // An object that held only additions was not in the input.
            for added in ["attributes", "material", "materials", "appearance", "metadata"] {
                if members.get(added).is_some_and(|inside| *inside == json("{}") || *inside == json("[]")) {
                    members.remove(added);
                }
            }
        }
        Value::Array(items) => count += items.iter_mut().map(strip).sum::<usize>(),
        _ => {}
    }
    count
}

/// Parses a table as rows of cells by column name.
fn table(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let names: Vec<String> = rows.headers().expect("names").iter().map(str::to_owned).collect();
    let row = |row: csv::StringRecord| names.iter().cloned().zip(row.iter().map(str::to_owned)).collect();
    rows.records().map(|record| row(record.expect("a row"))).collect()
}

fn number(text: &str) -> f64 {
    text.parse().expect("a number")
}

/// The block of The Hague is written equal but for the additions, its vertices to the byte, and
/// read again it has the same geometry. Months of all its objects are those of `--by object` within
/// 0.001 kWh/m2, and totals of more than 200 semantic surfaces are those of `--by receiver`.
#[test]
fn a_block_comes_back() {
    let folder = site("hague.city.json", "");
    let input = fs::read_to_string(model("hague.city.json")).expect("the model");
    let replay = format!("replay site.helio --weather {}", golden().display());
    let command = format!("{replay} --every month --model {} -o out.city.json", model("hague.city.json").display());
    let written = folder.run(&command);
    assert_eq!(written.status.code(), Some(0), "{}", stderr(&written));
    let output = fs::read_to_string(folder.path("out.city.json")).expect("the output");

    let (known, mut stripped, out) = (json(&input), json(&output), json(&output));
    assert!(strip(&mut stripped) > 2_500);
    let mut plain = known.clone();
    strip(&mut plain);
    assert_eq!(stripped, plain);
    let vertices = input.split("\"vertices\":").nth(1).expect("vertices");
    assert!(output.contains(&vertices[..vertices.find("]]").expect("an end")]));
    assert_eq!(out["metadata"]["heliotile"]["heliotile.archive"], "site.helio");
    let geometry = |file: &str| {
        let built = folder.run(&format!("build {file} -r r.csv --quality draft -o again.helio"));
        assert_eq!(built.status.code(), Some(0), "{}", stderr(&built));
        let info = stdout(&folder.run("info again.helio"));
        info.split("hash ").nth(1).and_then(|rest| rest.get(..64)).expect("a hash").to_owned()
    };
    assert_eq!(geometry("out.city.json"), geometry(&model("hague.city.json").display().to_string()));

    let objects = table(&stdout(&folder.run(&format!("{replay} --every month --by object"))));
    let parents: Vec<&str> = known["CityObjects"]
        .as_object()
        .expect("objects")
        .values()
        .flat_map(|object| object["parents"].as_array().into_iter().flatten())
        .filter_map(Value::as_str)
        .collect();
    let mut compared = 0;
    let mut totals = BTreeMap::<&str, f64>::new();
    for row in objects.iter().filter(|row| !parents.contains(&row["object"].as_str())) {
        let attributes = &out["CityObjects"][&row["object"]]["attributes"];
        let of_month =
            attributes[format!("heliotile_total_kwh_m2_{}", row["time"].replace('-', "_"))].as_f64().expect("a month");
        assert!((of_month - number(&row["total_kwh_m2"])).abs() < 1e-3, "{row:?} {of_month}");
        *totals.entry(&row["object"]).or_default() += number(&row["total_kwh_m2"]);
        let area = attributes["heliotile_area_m2"].as_f64().expect("an area");
        assert!((area - number(&row["area_m2"])).abs() < 0.01, "{row:?} {area}");
        compared += 1;
    }
    for (object, total) in &totals {
        let found = out["CityObjects"][object]["attributes"]["heliotile_total_kwh_m2"].as_f64().expect("a total");
        assert!((found - total).abs() < 2e-3, "{object}: {found} {total}");
    }
    assert!(compared >= 50 && totals.len() >= 50, "{compared}");
    assert!(surfaces(&folder, &replay, &out) > 200);
    again(&folder, &command, &output);
}

/// Compares each semantic surface with its receivers; returns the number of surfaces.
fn surfaces(folder: &Folder, replay: &str, out: &Value) -> usize {
    let sums = table(&stdout(&folder.run(&format!("{replay} --every total"))));
    let sums: BTreeMap<&str, f64> =
        sums.iter().map(|row| (row["receiver"].as_str(), number(&row["total_kwh_m2"]))).collect();
    // Area, and sum by area, of each object, geometry and semantic surface.
    let mut found = BTreeMap::<(String, usize, u64), (f64, f64)>::new();
    for row in table(&fs::read_to_string(folder.path("r.csv")).expect("receivers")) {
        let numbers: Vec<usize> =
            row["face"].split(|c: char| !c.is_ascii_digit()).filter_map(|digits| digits.parse().ok()).collect();
        let geometry = &out["CityObjects"][&row["object"]]["geometry"][numbers[0]];
        let value = numbers[1..].iter().fold(&geometry["semantics"]["values"], |values, place| &values[place]);
        let class =
            numbers[1..].iter().fold(&geometry["material"]["irradiation"]["values"], |values, place| &values[place]);
        let class = &out["appearance"]["materials"][class.as_u64().expect("a colour") as usize];
        assert!(class["name"].as_str().is_some_and(|name| name.starts_with("irradiation ")), "{class}");
        let sum = found.entry((row["object"].clone(), numbers[0], value.as_u64().expect("a surface"))).or_default();
        let area = number(&row["area_m2"]);
        sum.0 += area;
        sum.1 += area * sums[row["receiver"].as_str()];
    }
    for ((object, geometry, surface), (area, sum)) in &found {
        let written = &out["CityObjects"][object]["geometry"][geometry]["semantics"]["surfaces"][*surface as usize];
        let total = written["heliotile_total_kwh_m2"].as_f64().expect("a total");
        assert!((total - sum / area).abs() < 2e-3, "{object} {surface}: {total}");
    }
    found.len()
}

/// Checks that a model written from the output has no addition twice: the same bytes but for the
/// name of the model and its hash.
fn again(folder: &Folder, command: &str, output: &str) {
    let name = model("hague.city.json").display().to_string();
    let second = folder.run(&command.replace(&name, "out.city.json").replace("-o out", "-o second"));
    assert_eq!(second.status.code(), Some(0), "{}", stderr(&second));
    let text = fs::read_to_string(folder.path("second.city.json")).expect("the output");
    let first = output.replace(&name, "out.city.json");
    let hashes =
        |text: &str| json(text)["metadata"]["heliotile"]["heliotile.inputs"].as_str().expect("hashes").to_owned();
    let plain = |text: &str| text.replace(&hashes(text).replace('"', "\\\""), "");
    assert!(plain(&text) == plain(&first), "the second model differs in more than the hashes of its inputs");
    assert!(hashes(&text) != hashes(&first) && hashes(&text).contains("out.city.json"));
    let packed = folder.path("packed.city.json.gz");
    let mut bytes = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut bytes, &fs::read(model("hague.city.json")).expect("the model")).expect("memory");
    fs::write(packed, bytes.finish().expect("memory")).expect("a writable folder");
    let third = folder.run(&command.replace(&name, "packed.city.json.gz").replace("-o out", "-o third"));
    assert_eq!(third.status.code(), Some(0), "{}", stderr(&third));
    let text = fs::read_to_string(folder.path("third.city.json")).expect("the output");
    assert!(plain(&text) == plain(&output.replace(&name, "packed.city.json.gz")), "the model of a packed one differs");
}

/// A sequence of 3 buildings is written line by line, equal but for the additions, with materials
/// in each of its 3 features and provenance in its header alone. Geometry in other levels of detail
/// gets no theme.
#[test]
fn a_sequence_comes_back() {
    let folder = site("small.city.jsonl", "");
    let command = format!(
        "replay site.helio --weather {} --every total --columns total --model {} -o out.city.jsonl",
        golden().display(),
        model("small.city.jsonl").display()
    );
    let written = folder.run(&command);
    assert_eq!(written.status.code(), Some(0), "{}", stderr(&written));
    let input = fs::read_to_string(model("small.city.jsonl")).expect("the model");
    let output = fs::read_to_string(folder.path("out.city.jsonl")).expect("the output");
    assert_eq!((input.lines().count(), output.lines().count()), (4, 4));
    let mut themes = 0;
    for (i, (known, found)) in input.lines().zip(output.lines()).enumerate() {
        let (mut known, mut stripped) = (json(known), json(found));
        themes += found.matches("\"material\":{\"irradiation\"").count();
        assert_eq!(found.contains("heliotile.version"), i == 0);
        assert_eq!(found.contains("\"materials\":["), i > 0);
        strip(&mut stripped);
        strip(&mut known);
        assert_eq!(stripped, known, "line {i}");
    }
    assert_eq!(themes, 3);
}

/// A file that is no model of this archive is refused, and so is an output that does not fit: 11
/// of 11. For a model that holds some of the objects, a warning says so.
#[test]
fn models_of_other_archives_are_refused() {
    let folder = site("hague.city.json", "");
    let hague = model("hague.city.json").display().to_string();
    let replay = format!("replay site.helio --weather {} --every total", golden().display());
    let text = fs::read_to_string(model("hague.city.json")).expect("the model");
    let mut some = json(&text);
    let objects = some["CityObjects"].as_object_mut().expect("objects");
    let names: Vec<String> = objects.keys().cloned().collect();
    for name in &names[..10] {
        objects.remove(name);
    }
    folder.write("some.city.json", &some.to_string());
    for name in &names[10..] {
        some["CityObjects"].as_object_mut().expect("objects").remove(name);
    }
    folder.write("none.city.json", &some.to_string());
    folder.write("geo.json", "{\"type\": \"FeatureCollection\", \"features\": []}");
    folder.write("cut.city.json", &text[..text.len() / 2]);
    folder.write("own.city.json", &text);
    for (rest, expected) in [
        ("--model none.city.json -o o.city.json", "input other-site none.city.json"),
        ("--model geo.json -o o.city.json", "input other-kind geo.json not CityJSON"),
        ("--model cut.city.json -o o.city.json", "input other-kind cut.city.json not CityJSON"),
        ("--model own.city.json -o own.city.json", "input same-file own.city.json own.city.json"),
        ("--model own.city.json -o o.csv", "argument ending --output"),
        ("--model own.city.json", "argument ending --output"),
        ("--model own.city.json -o o.city.jsonl", "argument ending --output"),
        ("-o o.city.json", "argument needs --output --model"),
        ("--model own.city.json --by object -o o.city.json", "argument excludes --by --model"),
    ] {
        folder.fails(&format!("{replay} {rest}"), expected);
        assert!(!folder.path("o.city.json").exists(), "{rest}");
    }
    let hourly = replay.replace("total", "hour");
    folder.fails(&format!("{hourly} --model {hague} -o o.city.json"), "argument excludes --every --model");
    let noon = "replay site.helio --sun 200,40 --dni 700";
    folder.fails(&format!("{noon} --model {hague} -o o.city.json"), "argument needs --model --weather");
    assert!(!folder.path("o.city.json").exists());
    let written = folder.run(&format!("{replay} --model some.city.json -o o.city.json"));
    assert_eq!(written.status.code(), Some(0), "{}", stderr(&written));
    assert!(stderr(&written).contains("sums of the others are not written"), "{}", stderr(&written));
}
