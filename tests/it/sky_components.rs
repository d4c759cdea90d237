//! Sky components: the share of an overcast sky that a place sees.

use std::collections::BTreeMap;
use std::process::Command;

use glam::DVec3;
use heliotile_builder::settings::BuildSettings;
use heliotile_core::site::material::{Class, Material};
use heliotile_scene::Scene;

use crate::scenes::{quad, receiver, site, v};

/// Vertical sky components of a wall in front of an endless one at profile angles of 10 to 60
/// degrees, and of an open wall, are those of the integral of (1 + 2 sin a)/3 within 0.1 points at
/// the default settings. A receiver that looks down sees no sky.
#[test]
fn sky_components_are_those_of_the_integral() {
    let (height, distance) = (20.0_f64, 10.0);
    let wall = quad(v(-6000.0, distance, 0.0), v(12_000.0, 0.0, 0.0), v(0.0, 0.0, height), 0);
    let scene = Scene::from_triangles(&wall, vec![Material::matt("wall", 0.3, Class::Obstruction)]).expect("a scene");
    // Percent, BRE 209: 25 degrees are its 27 %.
    let known =
        [(0.0, 39.618), (10.0, 35.348), (20.0, 30.161), (25.0, 27.313), (30.0, 24.356), (40.0, 18.328), (45.0, 15.371)];
    let known = known.into_iter().chain([(60.0, 7.418)]);
    let place = |angle: f64| v(0.0, 0.0, height - distance * angle.to_radians().tan());
    let mut receivers: Vec<_> =
        known.clone().map(|(angle, _)| receiver(&format!("{angle}"), place(angle), DVec3::Y)).collect();
    receivers.push(receiver("down", v(0.0, 0.0, 5.0), -DVec3::Z));
    let site = site(&scene, &receivers, &BuildSettings::default());
    let output = Command::new(env!("CARGO_BIN_EXE_heliotile"))
        .args(["export", "--view-factors", "-o", "-"])
        .arg(&site.path)
        .output()
        .expect("the program");
    let table = String::from_utf8(output.stdout).expect("text");
    let rows: BTreeMap<&str, Vec<f64>> = table
        .lines()
        .skip(1)
        .filter_map(|line| line.split_once(','))
        .map(|(id, rest)| (id, rest.split(',').take(7).map(|cell| cell.parse().expect("a number")).collect()))
        .collect();
    for (angle, percent) in known {
        let found = rows[format!("{angle}").as_str()][5];
        eprintln!("{angle} degrees: {found} %, {percent} % by the integral");
        assert!((found - percent).abs() < 0.1, "{angle}: {found}, not {percent}");
    }
    assert_eq!(rows["down"][5..], [0.0, 1.0]);
}
