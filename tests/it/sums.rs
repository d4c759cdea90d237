//! Sums over many suns against the sums of their hours.

use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::Archive;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::material::{Class, Material};
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::time::bins::Bins;
use heliotile_scene::Scene;

use crate::scenes::*;

/// Returns suns of 700 hours at all heights, five positions an hour, half a degree and more apart.
fn hours() -> Vec<Condition> {
    let hour = |i: i32| {
        let i = f64::from(i);
        let (azimuth, altitude) = (i * 137.5, 0.2 + 75.0 * (i * 0.618).fract());
        let at = |k: i32| sun(azimuth + 1.3 * f64::from(k), altitude + 0.4 * f64::from(k), 0.0, 0.0).suns[0].sun;
        let suns: Vec<_> = (0..5).map(at).collect();
        Condition::new("h".into(), &suns, suns[0], 200.0 + 700.0 * (i * 0.37).fract(), 100.0)
    };
    (0..700).map(hour).collect()
}

/// Returns the largest difference between a component's sums and the sums of its means, as a share
/// of the largest sum, and that sum, kWh/m2.
fn off(site: &Site, component: Component, sky: SkyModel) -> (f64, f64) {
    let archive = Archive::open(&site.path).expect("an archive");
    let opened = OpenSite::open(&archive).expect("a site");
    let (hours, settings) = (hours(), ReplaySettings { sky, ..ReplaySettings::default() });
    let each = Replay::new(&opened, &hours, settings).expect("a replay");
    let of_condition: Vec<(usize, f64)> = (0..hours.len()).map(|i| (i % 3, 1e-3 + 1e-6 * i as f64)).collect();
    let bins = Bins { count: 3, of_condition };
    let summed = Replay::builder(&opened, &hours, settings).summed(&bins).build().expect("a replay");
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for (means, sums) in each.results(0..each.tiles()).zip(summed.results(0..summed.tiles())) {
        let (means, sums) = (means.expect("a tile").1, sums.expect("a tile").1);
        for receiver in 0..sums.receivers() {
            let mut expected = [0.0_f64; 3];
            for (mean, (bin, weight)) in means.row(component, receiver).iter().zip(&bins.of_condition) {
                expected[*bin] += f64::from(*mean) * weight;
            }
            for (sum, expected) in sums.row(component, receiver).iter().zip(expected) {
                worst = worst.max((f64::from(*sum) - expected).abs());
                largest = largest.max(expected);
            }
        }
    }
    (worst / largest, largest)
}

/// Sums of 3,500 suns in three bins are the sums of their 700 hours, within 1e-5 of the largest
/// sum: direct, in mirrors and in double glass, on receivers of four tilts that suns graze, and
/// through leaves. Light of the sky with its circumsolar part is within 2e-3.
#[test]
fn sums_of_suns_are_sums_of_their_hours() {
    let settings = BuildSettings { sky_base: 64, sky_fine: 512, hit: 8, probe: 8, ..BuildSettings::default() };
    let town = site(&mirror_town(), &many()[..64], &settings);
    for (component, sky, bound) in [
        (Component::SunDirect, SkyModel::Uniform, 1e-5),
        (Component::SunMirrored, SkyModel::Uniform, 1e-5),
        // Hours of dark horizons are clipped at 0, sums as a whole.
        (Component::SkyDirect, SkyModel::Perez1990, 2e-3),
    ] {
        let (worst, largest) = off(&town, component, sky);
        println!("{component:?}: {worst:.1e} of {largest:.1} kWh/m2");
        assert!(worst < bound && largest > 1.0, "{component:?}: {worst:.1e} of {largest}");
    }
    let leaf = Material { transmittance: Some(0.4), ..Material::matt("leaf", 0.0, Class::Obstruction) };
    let triangles = [town_of_leaves(), ground(200.0, 0.0, 0)].concat();
    let scene = Scene::from_triangles(&triangles, vec![Material::matt("ground", 0.2, Class::Ground), leaf]);
    let leaves = site(&scene.expect("a scene"), &many()[..64], &settings);
    let (worst, largest) = off(&leaves, Component::SunDirect, SkyModel::Uniform);
    println!("through leaves: {worst:.1e} of {largest:.1} kWh/m2");
    assert!(worst < 1e-5 && largest > 1.0, "{worst:.1e} of {largest}");
}

/// Returns six crowns of leaves.
fn town_of_leaves() -> Triangles {
    let crown = |i: i32| {
        let (x, y) = (f64::from(i % 3) * 30.0 - 40.0, f64::from(i / 3) * 40.0 - 30.0);
        block(v(x, y, 25.0), v(x + 12.0, y + 12.0, 40.0), 1)
    };
    (0..6).flat_map(crown).collect()
}
