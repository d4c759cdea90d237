//! The studies of the paper: their results, and the files that they write.

use std::collections::BTreeMap;
use std::fs;

use crate::cli::{Folder, stdout};

/// Returns the mean absolute error, percent, by map and number of rays, from a table.
fn mean_errors(table: &str) -> BTreeMap<(String, u32), f64> {
    let mut errors: BTreeMap<(String, u32), Vec<f64>> = BTreeMap::new();
    for line in table.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells[i].parse::<f64>().expect("a number");
        let error = number(6);
        assert!((error - 100.0 * (number(4) / number(5) - 1.0)).abs() < 0.01, "{line}");
        errors.entry((cells[0].into(), number(1) as u32)).or_default().push(error.abs());
    }
    errors.into_iter().map(|(key, all)| (key, all.iter().sum::<f64>() / all.len() as f64)).collect()
}

/// For the wall of Fig. 5 at 1 to 50 m there are 450 rows, 50 for each of 9 maps and numbers of
/// rays. In each map the mean error falls from 256 to 1024 to 4096 rays, then to below 2.5 % by
/// longitude and latitude, 5 % by solid angle and 3 % by cosine.
#[test]
fn map_errors_of_a_wall_fall_with_more_rays() {
    let folder = Folder::new();
    let output = folder.run("study wall -o made/wall");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| fs::read_to_string(folder.path("made/wall").join(name)).expect(name);
    let table = read("wall.csv");
    assert!(table.starts_with("mapping,rays,points,distance_m,form_factor,analytic,error_percent\n"));
    assert_eq!(table.lines().count(), 1 + 450);
    let errors = mean_errors(&table);
    assert_eq!(errors.len(), 9);
    for (mapping, bound_percent) in [("longitude-latitude", 2.5), ("solid-angle", 5.0), ("cosine", 3.0)] {
        let [few, some, many] = [256, 1024, 4096].map(|rays| errors[&(mapping.to_string(), rays)]);
        assert!(few > some && some > many && many < bound_percent, "{mapping}: {few} {some} {many}");
    }
    let report = stdout(&output);
    assert_eq!(report.lines().count(), 6, "{report}");
    for name in ["wall.svg", "wall_error.svg"] {
        assert!(read(name).starts_with("<svg ") && read(name).ends_with("</svg>\n"));
    }
    assert_eq!(fs::read_dir(folder.path("made/wall")).expect("a folder").count(), 3);
}

/// 25 points over the receiver bring the mean error of every map of 4096 rays below half of that of
/// one point; 3 distances of one map and number of rays are 3 rows, and two runs write equal bytes.
#[test]
fn more_points_more_than_halve_the_error() {
    let folder = Folder::new();
    let table = |rest: &str| {
        let output = folder.run(&format!("study wall -o made {rest}"));
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        ["wall.csv", "wall.svg"].map(|name| fs::read_to_string(folder.path("made").join(name)).expect(name))
    };
    let [one, many] = ["1", "25"].map(|points| mean_errors(&table(&format!("--rays 4096 --points {points}"))[0]));
    for (key, error) in &one {
        assert!(many[key] < 0.5 * error, "{key:?}: {error} by one point, {} by 25", many[key]);
    }
    let few = "--rays 100 --mapping cosine --distances 0.5,2,1000 --points 4";
    let again = table(few);
    assert_eq!(again[0].lines().count(), 1 + 3, "{}", again[0]);
    assert_eq!(again, table(few));
}

/// Wrong numbers are refused with a hint, 7 of 7, and no file is written.
#[test]
fn wrong_numbers_are_refused() {
    let folder = Folder::new();
    for (arguments, parts) in [
        ("--mapping fisheye", ["fisheye", "longitude-latitude, solid-angle, cosine"]),
        ("--rays 0", ["0 rays", "256,1024,4096"]),
        ("--rays 1000", ["961 and 1024", "squares"]),
        ("--distances -3", ["-3 m", "metres above 0"]),
        ("--distances 9..2", ["`9..2` ends before it starts", "1..50"]),
        ("--distances far", ["`far`", "1..50"]),
        ("--points 0", ["0 is not in 1..=10000", "--points"]),
    ] {
        folder.refused(&format!("study wall -o made {arguments}"), &parts);
    }
    assert!(!folder.path("made").exists());
    folder.refused("study wall -o scene.obj", &["scene.obj", "the output is a folder"]);
}
