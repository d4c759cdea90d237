//! Places in and around a house on a lawn.

use glam::DVec3;

use super::{Enclosed, Siting};
use crate::pipeline::PreparedScene;
use heliotile_core::site::material::{Class, Material};
use heliotile_scene::Scene;

/// Returns a scene with a ground of 200 m and a house of 10 x 10 x 6 m on it, its faces outwards or
/// inwards.
fn scene(outwards: bool) -> Scene {
    let mut triangles = Vec::new();
    let mut quad = |p: DVec3, a: DVec3, b: DVec3, material: u16| {
        let (a, b) = if outwards || material == 0 { (a, b) } else { (b, a) };
        triangles.push(([p, p + a, p + a + b], material));
        triangles.push(([p, p + a + b, p + b], material));
    };
    let (x, y, z) = (10.0 * DVec3::X, 10.0 * DVec3::Y, 6.0 * DVec3::Z);
    quad(DVec3::new(-100.0, -100.0, 0.0), 20.0 * x, 20.0 * y, 0);
    quad(DVec3::ZERO, x, z, 1);
    quad(x, y, z, 1);
    quad(x + y, -x, z, 1);
    quad(y, -y, z, 1);
    quad(z, x, y, 1);
    let materials =
        vec![Material::matt("ground", 0.2, Class::Ground), Material::matt("house", 0.3, Class::Obstruction)];
    Scene::from_triangles(&triangles, materials).expect("a scene")
}

/// From above, a house of 6 m is found by its roof, the lawn at 0 m, and nothing beyond it. Through
/// the roof the ground is found: 4 of 4.
#[test]
fn a_house_is_found_by_its_roof_from_above() {
    let scene = scene(true);
    let prepared = PreparedScene::new(&scene).expect("a tree");
    let siting = Siting::new(&prepared);
    let roof = siting.top(5.0, 5.0).expect("a roof");
    assert!((roof.z - 6.0).abs() < 1e-4 && roof.class == Class::Obstruction, "{roof:?}");
    let lawn = siting.top(20.0, 5.0).expect("a lawn");
    assert!(lawn.z.abs() < 1e-4 && lawn.class == Class::Ground, "{lawn:?}");
    assert_eq!(siting.top(500.0, 0.0), None);
    let ground = siting.ground_below(DVec3::new(5.0, 5.0, 8.0)).expect("ground");
    assert!(ground.z.abs() < 1e-4, "{ground:?}");
}

/// A point in a house is inside, whether its faces look out or in. One below the lawn is below the
/// ground, and 3 around them are in the open.
#[test]
fn points_in_houses_and_below_ground_are_found() {
    for outwards in [true, false] {
        let scene = scene(outwards);
        let prepared = PreparedScene::new(&scene).expect("a tree");
        let siting = Siting::new(&prepared);
        assert_eq!(siting.enclosed(DVec3::new(5.0, 4.0, 3.0)), Some(Enclosed::Inside("house".into())));
        assert_eq!(siting.enclosed(DVec3::new(20.0, 4.0, -0.5)), Some(Enclosed::BelowGround));
        for free in [DVec3::new(5.0, -0.1, 3.0), DVec3::new(5.0, 5.0, 6.1), DVec3::new(20.0, 5.0, 0.1)] {
            assert_eq!(siting.enclosed(free), None, "{free}");
        }
    }
}

/// At 10 m from the middle of a wall of 10 x 6 m the horizon is atan(6 cos a / 10) up to its
/// corners at 26.6 degrees off, and 0 behind, within 0.01 degrees in 360 directions. With a first
/// direction of 90 degrees the list begins there.
#[test]
fn the_horizon_of_a_wall_is_its_angle() {
    let scene = scene(true);
    let prepared = PreparedScene::new(&scene).expect("a tree");
    let siting = Siting::new(&prepared);
    let line = siting.horizon(DVec3::new(5.0, -10.0, 0.0), 360, 0.0).altitudes_deg;
    assert_eq!(line.len(), 360);
    for (azimuth, altitude) in line.iter().enumerate() {
        let off = (azimuth as f64 + 180.0).rem_euclid(360.0) - 180.0;
        let expected = if off.abs() < 26.0 { (0.6 * off.to_radians().cos()).atan().to_degrees() } else { 0.0 };
        // The edge of the wall itself is left out.
        assert!((26.0..28.0).contains(&off.abs()) || (altitude - expected).abs() < 0.01, "{off}: {altitude}");
    }
    let turned = siting.horizon(DVec3::new(5.0, -10.0, 0.0), 360, 90.0).altitudes_deg;
    assert!((turned[270] - line[0]).abs() < 1e-9 && turned[0] == 0.0, "{} {}", turned[270], turned[0]);
}
