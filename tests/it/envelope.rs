//! Solar envelopes: heights in closed form, and hours of sun of what they allow.

use std::fmt::Write;
use std::fs;

use crate::cli::{Folder, stderr};

/// Place of the tests.
const LATITUDE_DEG: f64 = 52.08;

/// Declination of the sun on 21 June 2017, degrees; it changes by 0.003 over the day.
const DECLINATION_DEG: f64 = 23.434;

/// Returns rows of numbers of a table, from its second column on.
fn rows(folder: &Folder, name: &str) -> Vec<Vec<f64>> {
    let table = fs::read_to_string(folder.path(name)).expect("a table");
    let number = |cell: &str| cell.parse().unwrap_or(f64::NAN);
    table.lines().skip(1).map(|line| line.split(',').skip(1).map(number).collect()).collect()
}

/// Adds a block with walls and a roof to an OBJ file whose vertices so far are counted.
fn block(text: &mut String, name: &str, [x, y, to_x, to_y]: [f64; 4], height: f64) {
    let first = text.matches("\nv ").count() + 1;
    let _ = writeln!(text, "o {name}");
    for z in [0.0, height] {
        for [x, y] in [[x, y], [to_x, y], [to_x, to_y], [x, to_y]] {
            let _ = writeln!(text, "v {x} {y} {z}");
        }
    }
    for face in [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]] {
        let _ = writeln!(text, "f {}", face.map(|corner| (first + corner).to_string()).join(" "));
    }
}

/// Returns the tangent of the altitude of a sun of a declination in a direction, from the equation
/// sin(declination) = sin(latitude) sin(altitude) + cos(latitude) cos(altitude) cos(azimuth).
fn tangent(azimuth_rad: f64) -> f64 {
    let (up, level) = (LATITUDE_DEG.to_radians().sin(), LATITUDE_DEG.to_radians().cos() * azimuth_rad.cos());
    let right = DECLINATION_DEG.to_radians().sin();
    // up tan + level = right sqrt(1 + tan^2), squared; the larger root.
    let (a, b, c) = (up * up - right * right, 2.0 * up * level, level * level - right * right);
    (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
}

/// A window 1.5 m above the ground, which faces south over a plot that begins 5 m before it, keeps
/// all of its sun of 21 June: the height of each of 3321 nodes is the distance times the tangent of
/// the sun's altitude in its direction, less 1 cm that it keeps clear and at most 1 cm more. On a
/// grid of 1 m the heights are at most 12 cm lower, and nowhere higher. The volume is that of these
/// heights.
#[test]
fn heights_before_a_window_are_those_of_the_sun() {
    let folder = Folder::new();
    let mut scene = String::from("# wall\n");
    block(&mut scene, "house", [-10.0, 20.0, 30.0, 28.0], 9.0);
    folder.write("house.obj", &scene);
    folder.write("receivers.csv", "receiver,x,y,z,nx,ny,nz\nwindow,10,19.98,1.5,0,-1,0\n");
    let place = format!("--latitude {LATITUDE_DEG} --longitude 4.3");
    folder.run(&format!("build house.obj --receivers receivers.csv {place} --quality draft -o site.helio"));
    for (spacing, count, low_m) in [("25cm", 81 * 41, 0.01), ("1m", 21 * 11, 0.12)] {
        let asked = "envelope site.helio --within 0,5,20,15 --hours 24 --dates 06-21 --height-limit 200m --spacing";
        let said = stderr(&folder.run(&format!("{asked} {spacing} -o heights.csv --mesh plot.obj")));
        assert!(said.contains("1 place: 1 limit it, 1 have less sun"), "{said}");
        let nodes = rows(&folder, "heights.csv");
        assert_eq!(nodes.len(), count);
        for node in &nodes {
            let (east, north) = (node[0] - 10.0, node[1] - 19.98);
            let right = 1.5 + east.hypot(north) * tangent(east.atan2(north));
            let above_m = node[2] + node[3] - right;
            assert!(node[2].abs() < 0.05, "the ground is at {}", node[2]);
            assert!((-0.01 - low_m..0.0).contains(&above_m), "{spacing}: {above_m} at {east} {north}");
        }
        let volume: f64 = said.split(" m3").next().and_then(|text| text.trim().parse().ok()).expect("a volume");
        let right: f64 = nodes.iter().map(|node| node[3] * node[4]).sum();
        assert!((volume / right - 1.0).abs() < 0.002, "{volume} {right}");
    }
}

/// Houses around a plot keep two hours on 21 March beside the building that the envelope allows:
/// no window that has them today falls below, and one with less keeps its minutes. Raised by half
/// a metre, the building takes them from some. Rays decide the ends of spells. A mesh far from the
/// origin is added without a warning that it lies far from the scene.
#[test]
fn a_building_in_the_envelope_leaves_each_window_its_hours() {
    let folder = Folder::new();
    let mut scene = String::from("# houses\n");
    let at = |[x, y, to_x, to_y]: [f64; 4]| [x + 80_000.0, y + 455_000.0, to_x + 80_000.0, to_y + 455_000.0];
    block(&mut scene, "north", at([-4.0, 22.0, 24.0, 30.0]), 8.0);
    block(&mut scene, "west", at([-18.0, -6.0, -9.0, 18.0]), 7.0);
    block(&mut scene, "east", at([28.0, -2.0, 36.0, 16.0]), 10.0);
    folder.write("houses.obj", &scene);
    folder.run(&format!(
        "receivers houses.obj --on wall --spacing 2m -o receivers.csv --latitude {LATITUDE_DEG} --longitude 4.3"
    ));
    let place = format!("--latitude {LATITUDE_DEG} --longitude 4.3");
    folder.run(&format!("build houses.obj --receivers receivers.csv {place} --quality draft -o before.helio"));
    let envelope = "envelope before.helio --within 80000,455000,80020,455014 --hours 2 --dates 03-21 --exact -o heights.csv --mesh plot.obj";
    let said = stderr(&folder.run(envelope));
    let minutes = |archive: &str| -> Vec<f64> {
        folder.run(&format!("sunlight {archive} -r receivers.csv --dates 03-21 --exact -o sun.csv"));
        let table = fs::read_to_string(folder.path("sun.csv")).expect("a table");
        let column = table.lines().next().and_then(|names| names.split(',').position(|name| name == "sun_minutes"));
        let column = column.expect("minutes");
        table.lines().skip(1).filter_map(|line| line.split(',').nth(column)?.parse().ok()).collect()
    };
    let before = minutes("before.helio");
    let beside = |mesh: &str| {
        let said = stderr(&folder.run(&format!("update before.helio --add {mesh} -o after.helio")));
        assert!(!said.contains(" lies "), "{said}");
        minutes("after.helio")
    };
    let lost =
        |after: &[f64]| before.iter().zip(after).filter(|(before, after)| **after < before.min(120.0) - 0.1).count();
    let allowed = beside("plot.obj");
    assert_eq!((before.len(), lost(&allowed)), (allowed.len(), 0), "{said}");
    assert!(before.iter().zip(&allowed).any(|(before, after)| *after < before - 30.0), "the building takes no sun");
    let raised = |line: &str| {
        let numbers: Option<Vec<f64>> = line.strip_prefix("v ")?.split(' ').map(|text| text.parse().ok()).collect();
        numbers.filter(|at| at[2] > 0.1).map(|at| format!("v {} {} {}", at[0], at[1], at[2] + 0.5))
    };
    let mesh = fs::read_to_string(folder.path("plot.obj")).expect("a mesh");
    let mesh: Vec<String> = mesh.lines().map(|line| raised(line).unwrap_or_else(|| line.to_owned())).collect();
    folder.write("raised.obj", &format!("{}\n", mesh.join("\n")));
    assert!(lost(&beside("raised.obj")) > 0, "{said}");
}

/// Without hours or a rule, with both, without dates or a plot, with a rule about glare, a mesh of
/// another format, a plot beside the scene, a table of no format or 25 hours, the command is
/// refused: 9 of 9.
#[test]
fn requests_without_an_answer_are_refused() {
    let folder = Folder::new();
    folder.run(
        "build scene.obj --materials materials.toml --receivers receivers.csv --latitude 52 --longitude 4 -o site.helio",
    );
    let plot = "envelope site.helio --within 0,0,20,14";
    for (arguments, expected) in [
        (format!("{plot} --dates 03-21"), "argument missing --hours"),
        (format!("{plot} --hours 2 --rule tno-light --dates 03-21"), "argument excludes --hours --rule"),
        (format!("{plot} --hours 2"), "argument missing --dates"),
        ("envelope site.helio --hours 2 --dates 03-21".to_owned(), "argument missing --within"),
        (format!("{plot} --rule lai"), "argument other --rule"),
        (format!("{plot} --hours 2 --dates 03-21 --mesh plot.stl"), "argument ending --mesh"),
        (
            "envelope site.helio --within 900000,0,900020,14 --hours 2 --dates 03-21".to_owned(),
            "argument misplaced --within",
        ),
        (format!("{plot} --hours 2 --dates 03-21 -o heights.txt"), "unsupported `heights.txt`"),
        (format!("{plot} --hours 25 --dates 03-21"), "argument out-of-range --hours 25.0"),
    ] {
        folder.fails(&arguments, expected);
    }
}
