//! Folders of hourly results in Honeybee's format. Honeybee's own reader opens them in
//! `tools/peers/outputs_bim`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::cli::{Folder, golden, stderr, stdout};

/// Builds receivers on two rooms of a Honeybee model, and their archive.
fn rooms() -> Folder {
    let folder = Folder::new();
    let model = Path::new(crate::ROOT).join("tests/data/honeybee/two_rooms.hbjson");
    for command in ["receivers MODEL --spacing 2 -o r.csv", "build MODEL -r r.csv --quality draft -o site.helio"] {
        let done = folder.run(&command.replace("MODEL", &model.display().to_string()));
        assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    }
    folder
}

/// Returns the shape and the values of an array of f32.
fn array(path: &Path) -> (String, Vec<f32>) {
    let bytes = fs::read(path).expect("an array");
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = String::from_utf8_lossy(&bytes[10..start]).into_owned();
    assert!(header.contains("'descr': '<f4', 'fortran_order': False"), "{header}");
    let shape = header.split("'shape': (").nth(1).and_then(|rest| rest.split(')').next()).expect("a shape").to_owned();
    let values = bytes[start..].chunks_exact(4).map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]]));
    (shape, values.collect())
}

/// Hours of three days stand in arrays of 5 grids, one for each object, `total` and `direct`, in
/// the rows that `receivers.csv` states. Each of over 9,000 values equals the table of `replay` to
/// its digits, and hours that are not listed are dark there.
#[test]
fn hours_are_those_of_the_table() {
    let folder = rooms();
    let replay = format!("replay site.helio --weather {}", golden().display());
    let written = folder.run(&format!("{replay} --honeybee hb"));
    assert_eq!(written.status.code(), Some(0), "{}", stderr(&written));
    let table = stdout(&folder.run(&format!("{replay} --columns total,sun_direct")));
    let mut hours = BTreeMap::<&str, Vec<[f64; 2]>>::new();
    for line in table.lines().skip(1) {
        let cells: Vec<&str> = line.rsplitn(3, ',').collect();
        let place = cells[2].split_once(',').expect("a receiver").1.trim_matches('"');
        hours.entry(place).or_default().push([1, 0].map(|cell: usize| cells[cell].parse().expect("a number")));
    }
    let text = |name: &str| fs::read_to_string(folder.path("hb").join(name)).expect(name);
    let grids: Value = serde_json::from_str(&text("grids_info.json")).expect("JSON");
    let study: Value = serde_json::from_str(&text("study_info.json")).expect("JSON");
    // 20, 21 and 22 March are days 79 to 81.
    let first = study["study_hours"][0].as_u64().expect("an hour") as usize;
    assert_eq!((study["timestep"].as_u64(), study["study_hours"].as_array().map(Vec::len)), (Some(1), Some(72)));
    assert_eq!(first % 24, 0);
    let lit: Vec<usize> =
        text("sun-up-hours.txt").lines().map(|hour| hour.parse::<usize>().expect("an hour") - first).collect();
    assert!((30..45).contains(&lit.len()), "{}", lit.len());
    let mut arrays = BTreeMap::new();
    for grid in grids.as_array().expect("grids") {
        let (id, count) = (grid["full_id"].as_str().expect("an id"), grid["count"].as_u64().expect("a count"));
        assert_eq!(text(&format!("grids/{id}.pts")).lines().count() as u64, count);
        let [total, direct] = ["total", "direct"].map(|name| {
            let (shape, values) = array(&folder.path(&format!("hb/__static_apertures__/default/{name}/{id}.npy")));
            assert_eq!(shape, format!("{count}, {}", lit.len()));
            values
        });
        arrays.insert(id.to_owned(), [total, direct]);
    }
    let mut compared = 0;
    for line in text("receivers.csv").lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let (grid, row) = (&arrays[cells[0]], cells[1].parse::<usize>().expect("a row"));
        for (hour, known) in hours[cells[2]].iter().enumerate() {
            let place = lit.iter().position(|lit| *lit == hour);
            for which in 0..2 {
                let found = place.map_or(0.0, |place| f64::from(grid[which][row * lit.len() + place]));
                assert!(
                    (found - known[which]).abs() <= 6e-4 + 1e-5 * known[which].abs(),
                    "{line} {hour}: {found} {known:?}"
                );
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 2 * 72 * hours.len());
    assert!(compared > 9_000 && arrays.len() == 5, "{compared} {:?}", arrays.keys());
    assert!(text("provenance.json").contains("heliotile.archive_root"));
}

/// Grids by kind are 2 or more. A folder that is not empty, sums, other columns, an output besides
/// and a sun without weather are refused, and no file is left: 5 of 5.
#[test]
fn wrong_honeybee_requests_leave_no_file() {
    let folder = rooms();
    let replay = format!("replay site.helio --weather {}", golden().display());
    let written = folder.run(&format!("{replay} --honeybee kinds --by kind --columns total"));
    assert_eq!(written.status.code(), Some(0), "{}", stderr(&written));
    let arrays = fs::read_dir(folder.path("kinds/__static_apertures__/default/total")).expect("arrays").count();
    assert!(arrays >= 2 && !folder.path("kinds/__static_apertures__/default/direct").exists(), "{arrays}");
    for (rest, expected) in [
        ("--honeybee kinds", "input exists kinds"),
        ("--honeybee new --every month", "argument excludes --every --honeybee"),
        ("--honeybee new --columns sky_direct", "argument excludes --columns --honeybee"),
        ("--honeybee new -o x.csv", "argument excludes --honeybee --output"),
    ] {
        folder.fails(&format!("{replay} {rest}"), expected);
        assert!(!folder.path("new").exists() && !folder.path("new.partial").exists(), "{rest}");
    }
    folder.fails("replay site.helio --sun 200,40 --dni 700 --honeybee new", "argument needs --honeybee --weather");
    assert!(!folder.path("new").exists() && !folder.path("new.partial").exists());
}
