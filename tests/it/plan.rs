//! Effects that a build leaves out, and the light that this costs: `plan`, `--effects`, and the
//! bounds that they print.

use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

use heliotile_builder::accuracy::conditions::{ErrorConditions, is_lit};
use heliotile_builder::pipeline::{Build, BuildReport, Forecast, NEGLIGIBLE_W_M2, PreparedScene, SKY_W_M2, SUN_W_M2};
use heliotile_builder::planning::losses::YearLosses;
use heliotile_builder::settings::EffectChoice;
use heliotile_builder::settings::{BuildSettings, Effect, Effects};
use heliotile_core::archive::{Archive, format};
use heliotile_core::hemisphere::{direction_of, jitter, mix, unit};
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::observer::Silent;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component::Total;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::material::{Class, Glass, Material};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::time::bins::Bins;
use heliotile_files::input::weather::read_weather;
use heliotile_scene::Scene;

use crate::cli::failure;
use crate::scenes::*;

/// Returns coarse textures, the same on both sides of a comparison.
fn coarse() -> BuildSettings {
    let mut settings = BuildSettings::default();
    for text in ["sky_base=64", "sky_fine=256", "hit=16", "probe=16", "bounce_sky=8"] {
        settings.set(text).expect(text);
    }
    settings
}

fn forecast(scene: &Scene, receivers: &[Receiver], wanted: EffectChoice) -> Forecast {
    let folder = tempfile::tempdir().expect("a folder");
    let (prepared, workspace) = (PreparedScene::new(scene).expect("a tree"), workspace(folder.path(), 1 << 30));
    let mut receivers = tiles(receivers, scene);
    let mut build = Build { scene: &prepared, receivers: &mut receivers, workspace: &workspace, observer: &Silent };
    build.forecast(&coarse(), wanted, None).expect("a forecast")
}

fn losses(scene: &Scene, receivers: &[Receiver], climate: &ErrorConditions) -> YearLosses {
    let folder = tempfile::tempdir().expect("a folder");
    let (prepared, workspace) = (PreparedScene::new(scene).expect("a tree"), workspace(folder.path(), 1 << 30));
    let mut receivers = tiles(receivers, scene);
    let mut build = Build { scene: &prepared, receivers: &mut receivers, workspace: &workspace, observer: &Silent };
    YearLosses::new(&mut build, climate).expect("losses")
}

fn built(scene: &Scene, receivers: &[Receiver], left_out: Effects) -> (tempfile::TempDir, Archive, BuildReport) {
    built_with(&coarse(), scene, receivers, left_out)
}

fn built_with(
    settings: &BuildSettings,
    scene: &Scene,
    receivers: &[Receiver],
    left_out: Effects,
) -> (tempfile::TempDir, Archive, BuildReport) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("site.helio");
    let settings = BuildSettings { left_out, ..*settings };
    let report = build(scene, &mut tiles(receivers, scene), &plan(&settings, &path)).expect("a build");
    let archive = Archive::open(&path).expect("an archive");
    (folder, archive, report)
}

/// Returns the totals of all receivers and conditions, under the light that bounds are stated for,
/// with responses derived again: the coding of stored ones is no effect.
fn totals(archive: &Archive, suns: &[Condition]) -> Vec<f64> {
    let paths = MaxBounces::Count(100).into();
    let settings = ReplaySettings { sky: SkyModel::Uniform, patches: 145, paths, ..ReplaySettings::default() };
    let replay = Replay::new(&OpenSite::open(archive).expect("a site"), suns, settings).expect("a replay");
    let mut found = Vec::new();
    for tile in replay.results(0..replay.tiles()) {
        let (ids, values) = tile.expect("a tile");
        (0..ids.len()).for_each(|i| found.extend(values.row(Total, i).iter().map(|&v| f64::from(v))));
    }
    found
}

/// Returns three to eight blocks on a ground, some of them with a wall of weak mirror, and twelve
/// receivers among them.
fn generated(seed: u64) -> (Scene, Vec<Receiver>) {
    let draw = |i: u64| unit(mix(seed, i));
    // The scale is dark enough that something is negligible: all diffuse light, or the second
    // reflection.
    let scale = if seed.is_multiple_of(2) { 0.0008 } else { 0.014 };
    let blocks = 3 + seed % 6;
    let mut triangles = ground(60.0, 0.0, 0);
    for b in 0..blocks {
        let (x, y) = (draw(10 * b) * 60.0 - 30.0, draw(10 * b + 1) * 60.0 - 30.0);
        let size = v(4.0 + 10.0 * draw(10 * b + 2), 4.0 + 10.0 * draw(10 * b + 3), 3.0 + 20.0 * draw(10 * b + 4));
        let low = v(x, y, 0.0);
        triangles.extend(block(low, low + size, 1 + (b % 2) as u16));
    }
    let mirror = if seed % 5 == 4 { 0.00008 } else { 0.0 };
    let materials = vec![
        Material::matt("ground", scale * (0.5 + draw(901)), Class::Ground),
        Material::matt("wall", scale * (0.5 + draw(902)), Class::Obstruction),
        Material { specular: mirror, ..Material::matt("facade", scale * (0.5 + draw(903)), Class::Obstruction) },
    ];
    let scene = Scene::from_triangles(&triangles, materials).expect("a scene");
    let receivers = (0..12)
        .map(|i| {
            let at = v(draw(500 + i) * 60.0 - 30.0, draw(600 + i) * 60.0 - 30.0, 0.5 + 24.0 * draw(700 + i));
            receiver(&format!("r{i}"), at, tilted(90.0 * draw(800 + i), 360.0 * draw(850 + i)))
        })
        .collect();
    (scene, receivers)
}

/// On 20 generated scenes, each under 60 suns of 1,000 W/m2 and a uniform sky of 100 W/m2, the
/// effects that `auto` leaves out cost no receiver more than the printed bound, which is at most 1
/// W/m2 for each effect. The mean bound is at most 10 times the mean loss, and so is the geometric
/// mean of the 20 ratios.
#[test]
fn losses_are_bounded() {
    let suns: Vec<Condition> = (0..60)
        .map(|i| {
            let sun = direction_of(jitter(11, i));
            Condition::new(format!("{i}"), &[sun], sun, SUN_W_M2, SKY_W_M2)
        })
        .collect();
    let (mut ratios, mut sums, mut left_out) = (Vec::new(), (0.0, 0.0), [0; 3]);
    for seed in 0..20 {
        let (scene, receivers) = generated(seed);
        let forecast = forecast(&scene, &receivers, EffectChoice::Auto);
        let all = built(&scene, &receivers, Effects::NONE);
        let auto = built(&scene, &receivers, forecast.left_out);
        let (all, auto) = (totals(&all.1, &suns), totals(&auto.1, &suns));
        let loss = all.iter().zip(&auto).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let bound = forecast.loss_w_m2();
        println!("scene {seed}: without {:?}, loss {loss:.4} W/m2, bound {bound:.4}", forecast.left_out.names());
        assert!(loss <= bound && bound <= 3.0 * NEGLIGIBLE_W_M2, "{seed}: {loss} {bound}");
        for (count, effect) in left_out.iter_mut().zip(Effect::ALL) {
            *count += usize::from(forecast.left_out.contains(effect));
        }
        assert_ne!(forecast.left_out, Effects::NONE, "{forecast:?}");
        sums = (sums.0 + bound, sums.1 + loss);
        ratios.push(bound / loss);
    }
    ratios.sort_by(f64::total_cmp);
    let geometric = (ratios.iter().map(|r| r.ln()).sum::<f64>() / ratios.len() as f64).exp();
    let of_means = sums.0 / sums.1;
    println!(
        "left out {left_out:?} times; bound over loss: of the means {of_means:.2}, geometric mean {geometric:.2}, {ratios:.1?}"
    );
    assert!(of_means < 10.0 && geometric < 10.0 && left_out.iter().all(|&count| count > 0), "{left_out:?}");
}

/// Returns the sums of the totals over all conditions by receiver, kWh/m2.
fn year_sums(archive: &Archive, year: &[Condition]) -> BTreeMap<String, f64> {
    let bins = Bins { count: 1, of_condition: vec![(0, 1e-3); year.len()] };
    let site = OpenSite::open(archive).expect("a site");
    let settings = ReplaySettings { patches: 145, ..ReplaySettings::default() };
    let replay = Replay::builder(&site, year, settings).summed(&bins).build().expect("a replay");
    let tiles = replay.results(0..replay.tiles()).map(|tile| tile.expect("a tile"));
    let sums = tiles.flat_map(|(ids, values)| {
        let sum = move |(i, id)| (id, f64::from(values.row(Total, i)[0]));
        ids.into_iter().enumerate().map(sum).collect::<Vec<_>>()
    });
    sums.collect()
}

/// Returns the generated blocks in usual colours: some with walls of mirror or glass, some behind
/// leaves.
fn coloured(seed: u64) -> (Scene, Vec<Receiver>) {
    let (plain, receivers) = generated(seed);
    let draw = |i: u64| unit(mix(seed, i));
    let scale = if seed.is_multiple_of(3) { 0.1 } else { 0.7 };
    let facade = match seed % 4 {
        1 => Material { specular: 0.3 * draw(910), ..Material::matt("facade", 0.1, Class::Obstruction) },
        2 => Material { glass: Some(Glass::Double), ..Material::matt("facade", 0.05, Class::Obstruction) },
        _ => Material::matt("facade", scale * draw(903), Class::Obstruction),
    };
    let leaves = Material { transmittance: Some(draw(911)), ..Material::matt("leaves", 0.0, Class::Obstruction) };
    let materials = vec![
        Material::matt("ground", scale * draw(901), Class::Ground),
        Material::matt("wall", scale * draw(902), Class::Obstruction),
        facade,
        leaves,
    ];
    let mesh = &plain.mesh;
    let points = |i: usize| mesh.triangle_points(i).map(|corner| corner + mesh.origin);
    let mut triangles: Triangles = (0..mesh.triangles.len()).map(|i| (points(i), mesh.triangle_material[i])).collect();
    if seed % 4 == 3 {
        triangles.extend(quad(v(-30.0, 5.0, 0.5), v(60.0, 0.0, 0.0), v(0.0, 0.0, 12.0), 3));
    }
    (Scene::from_triangles(&triangles, materials).expect("a scene"), receivers)
}

/// On 10 generated scenes with mirrors, glass and leaves, under a clear, dry climate, an overcast
/// one and suns from all sides, the loss from leaving an effect out never exceeds its bound by more
/// than 0.05 % of the sum, the error of archives, for all receivers and for one alone (70
/// comparisons or more). The median bound is at most 2 times the loss.
#[test]
fn losses_of_a_year_are_bounded() {
    let golden = data("../weather/golden_tmy3.epw");
    let clear = read_weather(&golden).expect("weather");
    let mut dull = clear.clone();
    for row in &mut dull.rows {
        (row.dhi_w_m2, row.dni_w_m2) = (row.dhi_w_m2.max(0.6 * row.ghi_w_m2.unwrap_or(0.0)), 0.02 * row.dni_w_m2);
    }
    let climates = [
        ErrorConditions::of_weather(&golden, clear).expect("light"),
        ErrorConditions::of_weather(&golden, dull).expect("light"),
        ErrorConditions::Spread,
    ];
    let (mut ratios, mut alone) = (Vec::new(), 0);
    for seed in 0..10 {
        let (scene, receivers) = coloured(seed);
        let one = std::slice::from_ref(&receivers[seed as usize % receivers.len()]);
        let build = |left_out| built_with(&BuildSettings::default(), &scene, &receivers, left_out);
        let all = build(Effects::NONE);
        let archives = Effect::ALL.map(|effect| build(Effects::of_names(&[effect.name().to_string()])));
        for (number, climate) in climates.iter().enumerate() {
            // Both sides have equal suns and patches, so two suns an hour show what is lost.
            let mut year = climate.year(2);
            year.retain(is_lit);
            let sums = year_sums(&all.1, &year);
            let sums_without = archives.each_ref().map(|archive| year_sums(&archive.1, &year));
            let groups = [&receivers[..], one];
            for group in &groups[..1 + usize::from(number == seed as usize % 3)] {
                let mean = |sums: &BTreeMap<String, f64>| {
                    group.iter().map(|receiver| sums[&receiver.id]).sum::<f64>() / group.len() as f64
                };
                let (losses, whole) = (losses(&scene, group, climate), mean(&sums));
                // Hours of the year are drawn by chance.
                let chance = 0.1 / (group.len() as f64).sqrt();
                assert!((losses.groups[0].total_kwh_m2 / whole - 1.0).abs() < chance, "{seed}: {whole} {losses:?}");
                for (effect, without) in Effect::ALL.into_iter().zip(&sums_without) {
                    let loss = (whole - mean(without)).abs();
                    let bound = losses.groups[0].losses[effect as usize].bound_kwh_m2;
                    // Archives with and without the effect are off by this much in a year.
                    assert!(loss <= bound + 5e-4 * whole, "{seed} {effect:?}: {loss} of {whole}, at most {bound}");
                    if loss > 1e-3 * whole {
                        ratios.push(bound / loss);
                        alone += usize::from(group.len() == 1);
                    }
                }
            }
        }
    }
    ratios.sort_by(f64::total_cmp);
    let (median, largest) = (ratios[ratios.len() / 2], ratios[ratios.len() - 1]);
    println!(
        "{} comparisons, {alone} of one receiver: bound over loss {median:.2}, at most {largest:.2}",
        ratios.len()
    );
    assert!(ratios.len() >= 70 && median < 2.0, "{} {median}", ratios.len());
}

/// Effects that are left out are not traced, not stored and not decoded: without diffuse light 0
/// probe rays, 0 probes, 0 bounce cells, and hits and responses of under 1 % of their bytes;
/// without bounces 0 bounce rays and cells; without mirrors 0 mirror rays and blocks.
#[test]
fn nothing_is_traced_for_what_is_left_out() {
    let materials = vec![
        Material::matt("ground", 0.3, Class::Ground),
        Material { specular: 0.5, ..Material::matt("wall", 0.3, Class::Obstruction) },
    ];
    let scene = Scene::from_triangles(&town(), materials).expect("a scene");
    let receivers = &many()[..64];
    let (_folder, whole, all) = built(&scene, receivers, Effects::NONE);
    let bytes = |archive: &Archive, kind| archive.entries_of(kind).iter().map(|e| u64::from(e.stored)).sum::<u64>();
    assert!(all.rays.probe > 0 && all.rays.bounce > 0 && all.rays.mirror > 0 && bytes(&whole, format::MIRROR) > 0);
    let none = built(&scene, receivers, Effects::ALL);
    assert_eq!((none.2.rays.probe, none.2.rays.bounce, none.2.rays.mirror), (0, 0, 0));
    assert_eq!((none.2.counts.probes, none.2.counts.bounce_cells), (0, 0));
    for kind in [format::PROBES, format::BOUNCE, format::MIRROR, format::MIRRORS, format::PROBE_MIRROR] {
        assert_eq!(bytes(&none.1, kind), 0, "{kind:?}");
    }
    for kind in [format::HIT, format::RESPONSE] {
        assert!(bytes(&none.1, kind) * 100 < bytes(&whole, kind), "{kind:?}: {}", bytes(&none.1, kind));
    }
    assert_eq!(bytes(&none.1, format::SKY), bytes(&whole, format::SKY));
    let bounces = built(&scene, receivers, Effects::NONE.with(Effect::Bounces));
    assert!(bounces.2.rays.probe == 0 && bounces.2.rays.mirror > 0);
    let only_bounces = Effects::of_names(&["bounces".into()]);
    let first = built(&scene, receivers, only_bounces);
    assert!(first.2.rays.probe > 0 && (first.2.rays.bounce, first.2.counts.bounce_cells) == (0, 0));
    let mirrors = built(&scene, receivers, Effects::of_names(&["mirrors".into()]));
    assert!(mirrors.2.rays.mirror == 0 && bytes(&mirrors.1, format::MIRROR) == 0 && mirrors.2.rays.bounce > 0);
}

/// `plan` prints a table of effects with their sum and writes no file. `build -v --effects none`
/// prints the same head, its archive states the effects left out, gives no reflected light and
/// refuses `--reflectance`. An unknown effect is refused (exit 2). Under three days of weather 5 %
/// leave out bounces; the archive states it, and replay under another file warns (1 of 2).
#[test]
fn plan_prints_the_effects_that_build_leaves_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    fs::write(path("s.obj"), "v -20 -20 0\nv 20 -20 0\nv 20 20 0\nv -20 20 0\nv -20 5 0\nv 20 5 0\nv 20 5 9\nv -20 5 9\nusemtl ground\nf 1 2 3 4\nusemtl wall\nf 5 6 7 8\n").expect("written");
    fs::write(path("m.toml"), "[ground]\ndiffuse = 0.2\n[wall]\ndiffuse = 0.4\nspecular = 0.3\n").expect("written");
    fs::write(path("r.csv"), "receiver,x,y,z,nx,ny,nz\na,0,0,0.1,0,0,1\nb,1,-3,2,0,1,0\n").expect("written");
    fs::write(path("c.csv"), "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nx,180,40,800,100\n")
        .expect("written");
    let command = |args: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_heliotile"));
        command.current_dir(folder.path()).args(args);
        command
    };
    let run = |args: &[&str]| {
        let output = command(args).output().expect("the program");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let inputs = ["s.obj", "-m", "m.toml", "-r", "r.csv"];
    let (code, table, _) = run(&[&["build", "--dry-run"][..], &inputs[..]].concat());
    let on = |table: &str| table.lines().filter(|line| line.contains(" on ")).count();
    assert_eq!((code, on(&table), table.lines().count()), (Some(0), 5, 10), "{table}");
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 4);
    let (code, head, _) = run(&[&["build", "-v"], &inputs[..], &["--effects", "none", "-o", "n.helio"]].concat());
    assert_eq!((code, on(&head)), (Some(0), 2), "{head}");
    let (_, info, _) = run(&["info", "n.helio"]);
    assert!(info.contains("left out    diffuse, bounces, mirrors"), "{info}");
    let query = ["replay", "n.helio", "--conditions", "c.csv"];
    let (code, rows, _) = run(&query);
    assert_eq!(code, Some(0));
    for row in rows.lines().skip(1) {
        let values: Vec<f64> = row.split(',').skip(2).map(|v| v.parse().expect("a number")).collect();
        assert!(values[2..6].iter().all(|&v| v == 0.0) && values[6] > 0.0, "{row}");
    }
    let (code, _, message) = run(&[&query[..], &["--reflectance", "wall=0.1"]].concat());
    assert!(code == Some(2) && message.contains("without diffuse reflections"), "{message}");
    // With weather the table states contributions, the effects left out and why; a replay warns
    // where that no longer holds.
    fs::copy(data("../weather/golden_3_days.epw"), path("w.epw")).expect("a copy");
    let under = ["-w", "w.epw"];
    let (code, table, _) = run(&[&["build", "--dry-run"][..], &inputs[..], &under[..]].concat());
    assert!(code == Some(0) && table.contains("sums over w.epw of 2 receivers") && on(&table) == 5, "{table}");
    let allowed = ["--negligible", "5%", "-o", "w.helio"];
    let (code, head, _) = run(&[&["build", "-v"], &inputs[..], &under[..], &allowed[..]].concat());
    assert_eq!((code, on(&head)), (Some(0), 4), "{head}");
    let (_, info, _) = run(&["info", "w.helio"]);
    assert!(info.contains("left out    bounces; negligible: bounces (at most "), "{info}");
    fs::copy(path("w.epw"), path("other.epw")).expect("a copy");
    for (weather, warned) in [("w.epw", false), ("other.epw", true)] {
        let (code, _, said) =
            run(&["replay", "w.helio", "-w", weather, "--every", "total", "-o", &format!("{weather}.csv")]);
        assert_eq!((code, said.contains("w.helio leaves out bounces (at most ")), (Some(0), warned), "{said}");
    }
    for (more, expected) in [
        (["--negligible", "2%", "-o", "v.helio"], "argument missing --weather"),
        (["--effects", "glare", "-o", "g.helio"], "argument unreadable --effects glare"),
    ] {
        assert_eq!(failure(&mut command(&[&["build"], &inputs[..], &more].concat())), expected);
    }
}
