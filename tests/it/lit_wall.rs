//! A wall in the sun, whose reflected light has a closed form: the stated error holds where there
//! is no other light.

use std::f64::consts::TAU;

use glam::DVec3;

use heliotile_archives::Workspace;
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::accuracy::trial::Bench;
use heliotile_builder::accuracy::{PilotRequest, SettingsChoice, choose, sample};
use heliotile_builder::pipeline::{Build, PreparedScene};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::settings::Effects;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Silent;
use heliotile_core::site::material::{Class, Material};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::units::direction_from_degrees;
use heliotile_core::weather::conditions::Condition;
use heliotile_scene::Scene;

const REFLECTANCE: f64 = 0.5;
const DNI_W_M2: f64 = 800.0;

/// Returns a wall 10 m square in the plane y = 0 that faces south, and 33 receivers 0.05 to 60 m
/// before it that look along it, to the east.
fn wall() -> (Scene, Vec<Receiver>) {
    let corner = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let [a, b, c, d] = [corner(-5.0, 0.0), corner(5.0, 0.0), corner(5.0, 10.0), corner(-5.0, 10.0)];
    let triangles = [([a, b, c], 0), ([a, c, d], 0)];
    let scene = Scene::from_triangles(&triangles, vec![Material::matt("wall", REFLECTANCE, Class::Obstruction)]);
    let receiver = |i: usize| {
        let before_m = 0.05 * 1200.0_f64.powf(i as f64 / 32.0);
        let (x, z) = (-4.0 + 8.0 * (i as f64 * 0.618_034).fract(), 0.5 + 9.0 * (i as f64 * 0.754_878).fract());
        Receiver::new(format!("{i:02}"), DVec3::new(x, -before_m, z), DVec3::X)
    };
    (scene.expect("a scene"), (0..33).map(receiver).collect())
}

/// Returns the form factor of the wall from a receiver that looks along it (Lambert 1760: half the
/// sum over the edges of a polygon of the angle that each spans, over 2 pi, times the cosine
/// between the receiver's normal and that of the edge's triangle).
fn form_factor(receiver: &Receiver) -> f64 {
    // Only the part of the wall in front of the receiver counts.
    let west = receiver.position.x;
    let corners = [(west, 0.0), (5.0, 0.0), (5.0, 10.0), (west, 10.0)];
    let corners = corners.map(|(x, z)| (DVec3::new(x, 0.0, z) - receiver.position).normalize());
    let edge = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        a.angle_between(b) * a.cross(b).normalize().dot(receiver.normal)
    };
    (0..4).map(edge).sum::<f64>().abs() / TAU
}

/// Returns 36 suns that light the wall from behind the receivers' backs.
fn suns() -> Vec<Condition> {
    let sun = |i: usize| {
        let sun = direction_from_degrees(185.0 + 80.0 * (i as f64 * 0.618_034).fract(), 10.0 + 50.0 * i as f64 / 36.0);
        Condition::new(format!("{i}"), &[sun], sun, DNI_W_M2, 0.0)
    };
    (0..36).map(sun).collect()
}

/// Returns the settings that `choose` takes for a target, and the RMSE of the results against the
/// closed form under suns that light the wall, percent of their mean.
fn built(target_percent: f64) -> (SettingsChoice, f64) {
    let (scene, receivers) = wall();
    let folder = tempfile::tempdir().expect("a folder");
    let workspace = Workspace { folder: folder.path().into(), memory: MemoryBudget::DEFAULT };
    let mut tiles =
        ReceiverTiles::from_receivers(&receivers, scene.mesh.origin, folder.path(), 1 << 20).expect("in memory");
    let prepared = PreparedScene::new(&scene).expect("a tree");
    let mut build = Build { scene: &prepared, receivers: &mut tiles, workspace: &workspace, observer: &Silent };
    let request = PilotRequest { target_percent, suns: &ErrorConditions::Spread, left_out: Effects::NONE };
    let choice = choose(&mut build, &request).expect("settings");
    let conditions = suns();
    let bench = Bench {
        scene: &prepared,
        receivers: &receivers,
        conditions: &conditions,
        workspace: &workspace,
        observer: &Silent,
    };
    let light = bench.trial(choice.settings).expect("a build").light;
    let (mut squares, mut sum) = (0.0, 0.0);
    // Results come in the order in which an archive holds its receivers.
    let mut sorted =
        ReceiverTiles::from_receivers(&receivers, scene.mesh.origin, folder.path(), 1 << 20).expect("in memory");
    let sorted = sample(&mut sorted, receivers.len()).expect("all of them");
    for ((_, receiver), rows) in sorted.iter().zip(light.rows.chunks(conditions.len())) {
        for (row, condition) in rows.iter().zip(&conditions) {
            let on_wall = DNI_W_M2 * -condition.sky_sun.y;
            let right = REFLECTANCE * on_wall * form_factor(receiver);
            let found: f64 = row.iter().take(6).map(|part| f64::from(*part)).sum();
            squares += (found - right).powi(2);
            sum += right;
        }
    }
    let count = light.rows.len() as f64;
    (choice, (squares / count).sqrt() / (sum / count) * 100.0)
}

/// For 1 and 2 % the stated error of reflected light in hours of mostly reflected light is that
/// against the closed form within a factor of 1.5, under suns that light the wall and no sky. In
/// hours without direct sun it is no more W/m2 than the target of the total.
#[test]
fn stated_errors_hold_before_a_sunlit_wall() {
    for target in [1.0, 2.0] {
        let (choice, found) = built(target);
        let hours = choice.accuracy.hours.iter().find(|hours| hours.hours == "mostly reflected");
        let hours = hours.unwrap_or_else(|| panic!("nothing is stated of reflected light: {:?}", choice.accuracy));
        let (stated, all) = (hours.reflected_percent(), choice.accuracy.mean_w_m2);
        let factor = found / stated;
        assert!((1.0 / 1.5..1.5).contains(&factor), "{target} %: {stated} stated, {found} found");
        let shaded =
            choice.accuracy.hours.iter().find(|hours| hours.hours == "no direct sun").expect("hours without sun");
        assert!(shaded.reflected_w_m2 <= target / 100.0 * all, "{target} %: {shaded:?} of {all}");
    }
}
