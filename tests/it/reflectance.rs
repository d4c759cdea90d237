//! Reflectances changed at replay, against archives built with them.

use std::collections::BTreeMap;

use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::Archive;
use heliotile_core::light::states::Schedule;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::reflectances::{Changeable, Changes};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::time::bins::Bins;
use heliotile_scene::Scene;

use crate::scenes::*;

/// Returns 24 conditions of a bright year.
fn conditions() -> Vec<Condition> {
    let one = |i: i32| {
        let i = f64::from(i);
        sun(i * 97.0, 5.0 + 60.0 * (i * 0.618).fract(), 300.0 + 500.0 * (i * 0.37).fract(), 150.0)
    };
    (0..24).map(one).collect()
}

/// Returns the total of each receiver and condition under schedules.
fn totals(site: &Site, schedules: &[Schedule]) -> BTreeMap<String, Vec<f64>> {
    let archive = Archive::open(&site.path).expect("an archive");
    let (conditions, settings) =
        (conditions(), ReplaySettings { memory: MemoryBudget::new(1 << 28), ..ReplaySettings::default() });
    let bins = Bins::each(conditions.len());
    let replay = Replay::builder(&OpenSite::open(&archive).expect("a site"), &conditions, settings)
        .summed(&bins)
        .scheduled(schedules)
        .build()
        .expect("a replay");
    let tiles = replay.run(0..replay.tiles()).expect("tiles");
    let rows = tiles.into_iter().flat_map(|(ids, values)| {
        let row = |r: usize| values.row(Component::Total, r).iter().map(|v| f64::from(*v)).collect();
        ids.into_iter().enumerate().map(|(r, id)| (id, row(r))).collect::<Vec<_>>()
    });
    rows.collect()
}

/// Returns the largest difference of two sets of totals, as a share of the first one's mean.
fn largest(a: &BTreeMap<String, Vec<f64>>, b: &BTreeMap<String, Vec<f64>>) -> f64 {
    assert_eq!(a.len(), b.len());
    let all: Vec<(f64, f64)> = a.values().flatten().copied().zip(b.values().flatten().copied()).collect();
    let mean = all.iter().map(|p| p.0).sum::<f64>() / all.len() as f64;
    all.iter().map(|(x, y)| (x - y).abs() / mean).fold(0.0, f64::max)
}

/// Returns a hall of 12 x 8 x 4 m, open above, with bright walls, and nine receivers on its floor
/// and walls.
fn hall(floor: f64) -> (Scene, Vec<Receiver>) {
    let mut triangles = quad(v(0.0, 0.0, 0.0), v(12.0, 0.0, 0.0), v(0.0, 8.0, 0.0), 0);
    triangles.extend(quad(v(0.0, 0.0, 0.0), v(0.0, 0.0, 4.0), v(12.0, 0.0, 0.0), 1));
    triangles.extend(quad(v(0.0, 8.0, 0.0), v(12.0, 0.0, 0.0), v(0.0, 0.0, 4.0), 1));
    triangles.extend(quad(v(0.0, 0.0, 0.0), v(0.0, 8.0, 0.0), v(0.0, 0.0, 4.0), 1));
    triangles.extend(quad(v(12.0, 0.0, 0.0), v(0.0, 0.0, 4.0), v(0.0, 8.0, 0.0), 1));
    let of_floor = |i: i32| receiver(&format!("f{i}"), v(1.5 + 2.0 * f64::from(i), 3.0, 0.01), v(0.0, 0.0, 1.0));
    let of_wall = |i: i32| receiver(&format!("w{i}"), v(2.0 + 3.0 * f64::from(i), 0.01, 1.3), v(0.0, 1.0, 0.0));
    (scene(&triangles, &[floor, 0.9]), (0..5).map(of_floor).chain((0..4).map(of_wall)).collect())
}

/// A town whose ground is set to 0.55 in place of 0.2 at replay, and a hall whose floor is set to
/// 0.8 in place of 0.1, give the totals of archives built so: within 1e-6 of the mean if the other
/// archive's responses are derived again too, within 3e-3 with its stored ones, which are coded for
/// any one sun. The change itself moves the totals by more than 3 %.
#[test]
fn changed_equals_rebuilt() {
    let coarse = BuildSettings { sky_base: 64, sky_fine: 256, ..BuildSettings::default() };
    let of_town = |ground: f64| site(&scene(&town(), &[ground, 0.4]), &many(), &coarse);
    let of_hall = |floor: f64| {
        let (scene, receivers) = hall(floor);
        site(&scene, &receivers, &coarse)
    };
    for (name, dark, bright, value) in
        [("town", of_town(0.2), of_town(0.55), 0.55), ("hall", of_hall(0.1), of_hall(0.8), 0.8)]
    {
        let schedule = [Schedule { materials: vec![0], values: vec![value; 24] }];
        let changed = totals(&dark, &schedule);
        let (anew, stored) = (largest(&totals(&bright, &schedule), &changed), largest(&totals(&bright, &[]), &changed));
        let moved = largest(&changed, &totals(&dark, &[]));
        println!("{name}: off by {anew:.1e}, stored {stored:.1e}, moved by {moved:.2}");
        assert!(anew < 1e-6 && stored < 3e-3 && moved > 0.03, "{name}: {anew:.1e} {stored:.1e} {moved:.2}");
    }
}

/// Twenty-four albedos from 0.05 to 0.9 are interpolated between 5 or 9 states. In a town and in a
/// bright hall all totals are within 1e-4 of the mean of those with each albedo on its own (6 of
/// them).
#[test]
fn interpolated_albedos_equal_single_ones() {
    let coarse = BuildSettings { sky_base: 64, sky_fine: 256, ..BuildSettings::default() };
    let albedo = |i: usize| 0.05 + 0.85 * (i * 7 % 24) as f64 / 23.0;
    let (room, inside) = hall(0.3);
    let town = site(&scene(&town(), &[0.3, 0.4]), &many()[..40], &coarse);
    for (name, site) in [("town", town), ("hall", site(&room, &inside, &coarse))] {
        let varying = totals(&site, &[Schedule { materials: vec![0], values: (0..24).map(albedo).collect() }]);
        for i in [0, 5, 10, 13, 17, 23] {
            let alone = totals(&site, &[Schedule { materials: vec![0], values: vec![albedo(i); 24] }]);
            let only = |all: &BTreeMap<String, Vec<f64>>| -> BTreeMap<String, Vec<f64>> {
                all.iter().map(|(id, row)| (id.clone(), vec![row[i]])).collect()
            };
            let error = largest(&only(&alone), &only(&varying));
            println!("{name}, albedo {:.2}: off by {error:.1e}", albedo(i));
            assert!(error < 1e-4, "{name}, albedo {:.2}: off by {error:.1e}", albedo(i));
        }
    }
}

/// A changed diffuse reflectance leaves room for the light that a material reflects like a mirror:
/// double glass (0.2355 of light from everywhere) accepts 0.76 and refuses 0.77, a mirror of 0.5
/// accepts 0.5 and refuses 0.51, with the largest possible value: 4 of 4.
#[test]
fn mirrors_leave_less() {
    let coarse =
        BuildSettings { sky_base: 16, sky_fine: 32, hit: 8, probe: 8, cell_floor_m: 4.0, ..BuildSettings::default() };
    let site = site(&mirror_town(), &many()[..4], &coarse);
    let archive = Archive::open(&site.path).expect("an archive");
    let opened = OpenSite::open(&archive).expect("a site");
    let changeable = Changeable { site: &site.path, materials: opened.materials(), ground: None };
    for (name, value, most) in [
        ("glass", 0.76, None),
        ("glass", 0.77, Some("0.7645")),
        ("mirror", 0.5, None),
        ("mirror", 0.51, Some("0.5000")),
    ] {
        let changes = Changes { constant: vec![(name.into(), value)], ..Changes::default() };
        let refused =
            changes.undated(&changeable, 1, &|_| panic!("no file is asked for")).err().map(|error| error.to_string());
        assert_eq!(refused.is_some(), most.is_some(), "{name} {value}");
        assert!(refused.is_none_or(|said| most.is_some_and(|most| said.contains(most))), "{name} {value}");
    }
}
