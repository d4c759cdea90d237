//! Volumes of leaves: closed forms, two builds against one replay, and the reference path tracer.

use glam::DVec3;
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::reference::{PathTracer, ReferenceSky};
use heliotile_builder::settings::ladder::Rungs;
use heliotile_builder::settings::{Effects, Quality};
use heliotile_core::archive::Archive;
use heliotile_core::error::Problem;
use heliotile_core::hemisphere::mix;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::light::states::Schedule;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component::{SkyReflected, SunReflected, Total};
use heliotile_core::site::material::{BROADLEAF_DIFFUSE, Class, Material, left_after_metre};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::Condition;
use heliotile_results::{GapFractions, SkyComponents};
use heliotile_scene::Scene;

use crate::canopy::columns;
use crate::scenes::*;

fn of(triangles: &Triangles, materials: Vec<Material>) -> Scene {
    Scene::from_triangles(triangles, materials).expect("a scene")
}

/// Returns a closed surface of revolution about a vertical axis through `at`: `profile` has the
/// radius and height of its rings, from the lower pole to the upper one.
fn turned(at: DVec3, profile: &[(f64, f64)], material: u16) -> Triangles {
    const SIDES: usize = 96;
    let corner = |ring: usize, side: usize| {
        let (radius, height) = profile[ring];
        let turn = (side % SIDES) as f64 / SIDES as f64 * std::f64::consts::TAU;
        at + v(radius * turn.cos(), radius * turn.sin(), height)
    };
    let mut triangles = Triangles::new();
    for ring in 0..profile.len() - 1 {
        for side in 0..SIDES {
            let [a, b, c, d] =
                [corner(ring, side), corner(ring, side + 1), corner(ring + 1, side + 1), corner(ring + 1, side)];
            if profile[ring].0 > 0.0 {
                triangles.push(([a, b, c], material));
            }
            if profile[ring + 1].0 > 0.0 {
                triangles.push(([a, c, d], material));
            }
        }
    }
    triangles
}

fn sphere(at: DVec3, radius: f64, material: u16) -> Triangles {
    let ring = |i: i32| {
        let (sin, cos) = (f64::from(i) / 64.0 * std::f64::consts::PI).sin_cos();
        (if i % 64 == 0 { 0.0 } else { radius * sin }, -radius * cos)
    };
    turned(at, &(0..=64).map(ring).collect::<Vec<_>>(), material)
}

/// Exponential integral of order 3, E3(x), by Simpson's rule over 1 / mu.
fn e3(x: f64) -> f64 {
    let n = 20_000;
    let value = |i: i32| {
        let mu = f64::from(i) / f64::from(n);
        if i == 0 { 0.0 } else { mu * (-x / mu).exp() }
    };
    let inner: f64 = (1..n).map(|i| value(i) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
    (value(0) + inner + value(n)) / (3.0 * f64::from(n))
}

/// Black leaves dim direct light by exp(-D l / 2). Below an endless slab of 3 m the sun at 4
/// altitudes, and the uniform sky by 2 E3(D h / 2), for 3 densities of replay from one archive of 1
/// m2/m3; behind the middle of a sphere of 6 m, and behind a cone of 8 m; for a point in the middle
/// of the slab: within 0.2 % of the light without leaves. Two spheres that overlap count once, and
/// hulls that are wound inwards as others.
#[test]
fn light_is_dimmed_by_the_length_of_its_way() {
    let leaves = || vec![Material::of_leaves("crown", 1.0, 0.0)];
    let mut most = 0.0_f64;
    let mut check = |what: &str, found: f64, wanted: f64, open: f64| {
        let off = (found - wanted) / open;
        most = most.max(off.abs());
        assert!(off.abs() < 0.002, "{what}: {found} {wanted} {open}");
    };
    let slab = of(&block(v(-1500.0, -1500.0, 2.0), v(1500.0, 1500.0, 5.0), 0), leaves());
    let receivers = [receiver("below", v(0.2, 0.1, 0.0), DVec3::Z), receiver("inside", v(0.2, 0.1, 3.5), DVec3::Z)];
    let suns = [20.0, 35.0, 50.0, 80.0].map(|altitude| sun(40.0 + altitude, altitude, 900.0, 0.0));
    let conditions: Vec<Condition> = suns.iter().cloned().chain([sky_only()]).collect();
    let built = site(&slab, &receivers, &fine());
    for density in [0.2, 1.0, 2.5] {
        let values = vec![left_after_metre(density); conditions.len()];
        let schedule = [Schedule { materials: vec![0], values }];
        let rows = columns(&built.path, &conditions, SkyModel::Uniform, &schedule);
        for (name, thick) in [("below", 3.0), ("inside", 1.5)] {
            let total = &rows[name][Total as usize];
            for (sun, found) in suns.iter().zip(total) {
                let (sine, open) = (sun.sky_sun.z, sun.dni_w_m2 * sun.sky_sun.z);
                check("slab, sun", *found, open * (-0.5 * density * thick / sine).exp(), open);
            }
            let open = sky_only().dhi_w_m2;
            check("slab, sky", total[4], open * 2.0 * e3(0.5 * density * thick), open);
        }
    }
    // Rings of zenith angles, and the leaf area index of the slab: 3 m2/m2.
    let archive = Archive::open(&built.path).expect("an archive");
    let slab_site = OpenSite::open(&archive).expect("a site");
    let seen = SkyComponents::uniform(&slab_site).expect("a sky").tiles([0]).next().expect("a tile").expect("percent");
    check("view of the sky", seen[0] / 100.0, 2.0 * e3(1.5), 1.0);
    let gaps = GapFractions::new(&slab_site).expect("gaps");
    let gaps = gaps.tile(0, &[[0.0, 0.0, 1.0]]).expect("a tile")[0].expect("a level receiver");
    for ((middle, width), share) in
        [(7.0, 12.2), (23.0, 12.2), (38.0, 11.8), (53.0, 13.2), (68.0, 13.2)].into_iter().zip(gaps.shares)
    {
        let zenith = |i: i32| f64::to_radians(middle + width * ((f64::from(i) + 0.5) / 1000.0 - 0.5));
        let [light, all] = (0..1000).map(zenith).fold([0.0, 0.0], |[light, all], angle| {
            [light + angle.sin() * (-1.5 / angle.cos()).exp(), all + angle.sin()]
        });
        check("ring", share, light / all, 1.0);
    }
    let index = gaps.leaf_area_index.expect("leaves");
    println!("leaf area index of 3: {index:.3}");
    assert!((index / 3.0 - 1.0).abs() < 0.01, "{index}");
    // Behind the middle of a sphere, and a cone at half of its radius.
    let behind = |scene: &Scene, at: DVec3, towards: &Condition| {
        let receivers = [receiver("behind", at, towards.sky_sun)];
        let rows =
            site(scene, &receivers, &fine()).replay(std::slice::from_ref(towards), SkyModel::Uniform, MaxBounces::All);
        rows["behind"][0].total
    };
    for altitude in [15.0, 40.0, 75.0] {
        let sun = sun(200.0, altitude, 900.0, 0.0);
        let at = v(1.0, 2.0, 10.0) - sun.sky_sun * 9.0;
        let inwards: Triangles =
            sphere(v(1.0, 2.0, 10.0), 3.0, 0).iter().map(|([a, b, c], material)| ([*c, *b, *a], *material)).collect();
        for (what, triangles) in [("sphere", sphere(v(1.0, 2.0, 10.0), 3.0, 0)), ("inwards", inwards)] {
            check(what, behind(&of(&triangles, leaves()), at, &sun), 900.0 * f64::exp(-3.0), 900.0);
        }
        let two = [sphere(v(1.0, 2.0, 10.0), 3.0, 0), sphere(v(1.0, 2.0, 10.0) + sun.sky_sun * 2.0, 3.0, 0)].concat();
        check("two spheres", behind(&of(&two, leaves()), at, &sun), 900.0 * f64::exp(-4.0), 900.0);
    }
    let zenith = sun(180.0, 89.9, 900.0, 0.0);
    let cone = of(&turned(v(0.0, 0.0, 3.0), &[(0.0, 0.0), (2.0, 0.0), (0.0, 8.0)], 0), leaves());
    check("cone", behind(&cone, v(1.0, 0.0, 0.5), &zenith), 900.0 * f64::exp(-2.0), 900.0);
    println!("lengths in leaves: at most {:.3} % off", 100.0 * most);
}

/// Returns a lawn, a wall of 12 m and a crown of `density` before it, a sphere of 5 m.
fn tree(density: f64) -> Scene {
    let mut triangles = ground(60.0, 0.0, 0);
    triangles.extend(quad(v(-15.0, 4.0, 0.0), v(30.0, 0.0, 0.0), v(0.0, 0.0, 12.0), 1));
    triangles.extend(sphere(v(0.0, 0.0, 5.0), 2.5, 2));
    of(&triangles, materials(density))
}

fn materials(density: f64) -> Vec<Material> {
    vec![
        Material::matt("a lawn", 0.25, Class::Ground),
        Material::matt("brick", 0.4, Class::Obstruction),
        Material::of_leaves("crown", density, BROADLEAF_DIFFUSE),
    ]
}

/// Returns 40 places on the wall, on the lawn, beside the crown, above it and in it.
fn around() -> Vec<Receiver> {
    let on_wall = (0..5)
        .flat_map(|i| (0..3).map(move |k| (v(1.5 * f64::from(i) - 3.0, 3.99, 1.0 + 3.0 * f64::from(k)), DVec3::NEG_Y)));
    let on_lawn = (0..5)
        .flat_map(|i| (0..4).map(move |k| (v(1.5 * f64::from(i) - 3.0, 2.0 * f64::from(k) - 5.0, 0.01), DVec3::Z)));
    let others = [
        (v(4.0, 1.0, 1.1), DVec3::NEG_X),
        (v(0.0, -5.0, 1.1), DVec3::Y),
        (v(0.2, 0.1, 9.0), DVec3::NEG_Z),
        (v(0.5, 0.3, 5.0), DVec3::Z),
        (v(-0.8, 0.3, 4.0), DVec3::X),
    ];
    let all = on_wall.chain(on_lawn).chain(others).enumerate();
    all.map(|(number, (at, normal))| receiver(&format!("{number}"), at, normal)).collect()
}

/// Around a tree before a wall, an avenue of six and a wood of sixteen, under 3 suns and a sky, all
/// light of the places around them is that of the reference path tracer with volumes: at `standard`
/// in the mean within 0.2, 0.4 and 1.2 %, with an RMSE of at most 1, 1.2 and 2 %. What is left in
/// the wood is light of leaves, whose cells are as wide as 1 m and more, and the sun at edges.
#[test]
fn crowns_scatter_like_the_reference_path_tracer() {
    let conditions =
        [sun(180.0, 40.0, 800.0, 100.0), sun(250.0, 25.0, 600.0, 80.0), sun(120.0, 62.0, 850.0, 110.0), sky_only()];
    let skies = conditions.clone().map(|condition| ReferenceSky::new(&condition, SkyModel::Uniform).expect("a sky"));
    let trees = |places: &[(f64, f64)]| {
        let mut triangles = ground(60.0, 0.0, 0);
        triangles.extend(quad(v(-25.0, 4.0, 0.0), v(50.0, 0.0, 0.0), v(0.0, 0.0, 12.0), 1));
        triangles.extend(places.iter().flat_map(|(x, y)| sphere(v(*x, *y, 5.0), 2.5, 2)));
        of(&triangles, materials(1.0))
    };
    let avenue: Vec<(f64, f64)> = (-1..=1).flat_map(|i| [-6.0, 0.0].map(|y| (6.0 * f64::from(i), y))).collect();
    let wood: Vec<(f64, f64)> =
        (-2..2).flat_map(|i| (-3..1).map(move |k| (4.2 * f64::from(i) + 1.0, 4.2 * f64::from(k)))).collect();
    for (name, scene, limits) in
        [("tree", tree(1.0), [0.2, 1.0]), ("avenue", trees(&avenue), [0.4, 1.2]), ("wood", trees(&wood), [1.2, 2.0])]
    {
        let receivers = around();
        let settings = Rungs::new(Quality::Standard).settings();
        let rows = site(&scene, &receivers, &settings).replay(&conditions, SkyModel::Uniform, MaxBounces::All);
        let prepared = PreparedScene::new(&scene).expect("trees");
        let tracer = PathTracer::new(&prepared, Effects::NONE);
        let (mut off, mut all, mut reflected) = (Vec::new(), 0.0, [0.0; 2]);
        for (number, of) in receivers.iter().enumerate() {
            let reference =
                tracer.irradiance(of.position, of.normal, &skies.each_ref(), 1 << 13, mix(5, number as u64));
            for (i, reference) in reference.iter().enumerate() {
                off.push(rows[&of.id][i].total - reference.mean[Total as usize]);
                all += reference.mean[Total as usize];
                let row = &rows[&of.id][i];
                reflected[0] += row.sun_reflected + row.sky_reflected;
                reflected[1] += reference.mean[SunReflected as usize] + reference.mean[SkyReflected as usize];
            }
        }
        let count = off.len() as f64;
        let (bias, squares) = (off.iter().sum::<f64>() / count, off.iter().map(|off| off * off).sum::<f64>() / count);
        let [bias, rmse] = [bias, squares.sqrt()].map(|off| 100.0 * off / (all / count));
        let [share, above] = [reflected[1] / all, reflected[0] / reflected[1] - 1.0].map(|share| 100.0 * share);
        println!("{name}: bias {bias:.2} %, RMSE {rmse:.2} %; {share:.0} % is reflected, {above:+.1} % off");
        assert!(bias.abs() < limits[0] && rmse < limits[1], "{name} {bias} {rmse}");
    }
}

/// Half of the leaves fall: a replay with 0.5 m2/m3 for the 1 of the archive is the archive built
/// with 0.5, within 1e-5.
#[test]
fn fewer_leaves_replay_as_they_build() {
    let conditions = [sun(180.0, 40.0, 800.0, 100.0), sun(250.0, 25.0, 600.0, 80.0)];
    let totals = |density: f64, replayed: f64| -> Vec<f64> {
        let values = vec![left_after_metre(replayed); conditions.len()];
        let season = [Schedule { materials: vec![2], values }];
        let built = site(&tree(density), &around(), &fine());
        let rows = columns(&built.path, &conditions, SkyModel::Perez, &season);
        rows.into_values().flat_map(|mut row| row.swap_remove(Total as usize)).collect()
    };
    let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    let half = off(&totals(1.0, 0.5), &totals(0.5, 0.5));
    println!("half of the leaves: {half:.1e} off");
    assert!(half < 1e-5, "{half}");
}

/// Along a hedge of 120 m light passes more leaves than a length can state, 82 m: the archive is
/// built and read, and less than 1e-6 of the sun comes through.
#[test]
fn the_longest_ways_are_stored() {
    let mut triangles = ground(150.0, 0.0, 0);
    triangles.extend(block(v(0.0, -1.0, 0.2), v(120.0, 1.0, 3.0), 2));
    let receivers = [receiver("along", v(-0.5, 0.1, 1.5), DVec3::X)];
    let built = site(&of(&triangles, materials(1.0)), &receivers, &fine());
    let rows = built.replay(&[sun(90.0, 0.5, 900.0, 100.0)], SkyModel::Uniform, MaxBounces::All);
    let row = &rows["along"][0];
    assert!(row.sun_direct < 1e-3 && row.sky_reflected > 0.1, "{row:?}");
}

/// An open hull has no inside: the build refuses it and names a place on its edge.
#[test]
fn an_open_hull_is_no_volume() {
    let mut triangles = sphere(v(0.0, 0.0, 5.0), 2.5, 2);
    triangles.pop();
    let scene = of(&[ground(60.0, 0.0, 0), triangles].concat(), materials(1.0));
    let refused = PreparedScene::new(&scene).map(|_| ()).expect_err("an open hull");
    assert_eq!(refused.problem(), Some(&Problem::Lacks("closed hull")));
}
