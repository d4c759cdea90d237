//! Who takes the sun: direct light that objects take from receivers, and light that they give.

use std::collections::BTreeMap;
use std::fs;

use glam::DVec3;
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::Archive;
use heliotile_core::light::states::Schedule;
use heliotile_core::opened::{OpenSite, SceneObjects, SurfaceOf};
use heliotile_core::replay::by_object::{DIRECT, GIVEN, LightByObject};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::material::{Class, Material};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::time::bins::Bins;
use heliotile_scene::Scene;

use crate::cli::{Folder, golden, stderr, stdout};
use crate::scenes::*;

fn coarse() -> BuildSettings {
    BuildSettings { sky_base: 32, sky_fine: 128, hit: 16, probe: 16, ..BuildSettings::default() }
}

/// Returns the mirror town with a hedge and a row of leaves that scatter light.
fn leafy_town() -> Scene {
    let mut triangles = mirror_triangles();
    triangles.extend(quad(v(-40.0, -14.0, 0.0), v(70.0, 0.0, 0.0), v(0.0, 0.0, 9.0), 4));
    triangles.extend(quad(v(-40.0, 6.0, 30.0), v(70.0, 0.0, 0.0), v(0.0, 9.0, 2.0), 5));
    let leaves = |name, diffuse, transmittance| Material {
        transmittance: Some(transmittance),
        ..Material::matt(name, diffuse, Class::Obstruction)
    };
    let materials = [mirror_materials(), vec![leaves("hedge", 0.2, 0.4), leaves("leaf", 0.3, 0.6)]].concat();
    Scene::from_triangles(&triangles, materials).expect("a scene")
}

/// Returns the light of all receivers of an archive by object, in the order of the archive, and the
/// names of the objects.
fn by_object(
    archive: &Archive,
    conditions: &[Condition],
    bins: &Bins,
    sky: SkyModel,
) -> (Vec<LightByObject>, Vec<String>) {
    let site = OpenSite::open(archive).expect("a site");
    let settings = ReplaySettings { sky, ..ReplaySettings::default() };
    let replay = Replay::builder(&site, conditions, settings).summed(bins).build_by_object().expect("a replay");
    let objects = SceneObjects::new(&site, archive.manifest().scene.origin_m.into()).expect("objects");
    let tiles = (0..archive.tiles()).flat_map(|tile| replay.tile(tile, &objects, |_| true).expect("a tile"));
    (tiles.collect(), objects.objects().iter().map(|object| object.name.clone()).collect())
}

/// In a town with mirrors, glass, a hedge and leaves, for 64 receivers and each of 24 hours: light
/// that arrives is that of a replay, and with what all objects take it is that under a free sky, to
/// 1e-5 of DNI and DHI. A free sun gives DNI x cosine, and a free uniform sky DHI (1 + cos tilt) /
/// 2 within 0.3 % of DHI. Light that objects give adds up to the four columns of a replay whose
/// responses are derived, to 1e-5 of the largest.
#[test]
fn taken_and_received_light_add_up_hour_by_hour() {
    let site = site(&leafy_town(), &many()[..64], &coarse());
    let archive = Archive::open(&site.path).expect("an archive");
    let conditions: Vec<Condition> = (0..24)
        .map(f64::from)
        .map(|i| sun(i * 97.0, 5.0 + 60.0 * (i * 0.618).fract(), 300.0 + 500.0 * (i * 0.37).fract(), 150.0))
        .collect();
    let opened = OpenSite::open(&archive).expect("a site");
    // A schedule of the stored reflectance makes the replay derive responses, too.
    let ground = Schedule { materials: opened.grounds(), values: vec![0.2; 24] };
    for sky in [SkyModel::Uniform, SkyModel::Perez1990] {
        let bins = Bins::each(24);
        let (found, _) = by_object(&archive, &conditions, &bins, sky);
        let settings = ReplaySettings { sky, ..ReplaySettings::default() };
        let schedules = [ground.clone()];
        let builder = Replay::builder(&opened, &conditions, settings).summed(&bins).scheduled(&schedules);
        let replay = builder.build().expect("a replay");
        let mut receivers = found.iter();
        let is_leafy = |number: u16| opened.materials()[usize::from(number)].transmittance.is_some();
        let (mut taken_by_leaves, mut worst, mut largest) = (0.0, [0.0_f64; 4], [0.0_f64; 4]);
        for (tile, (ids, values)) in (0..).zip(replay.run(0..replay.tiles()).expect("tiles")) {
            let table = opened.tile_receivers(tile).expect("receivers");
            for row in 0..ids.len() {
                let (light, normal) = (receivers.next().expect("a receiver"), DVec3::from(table.normal[row]));
                for (hour, condition) in conditions.iter().enumerate() {
                    // Circumsolar light of a low sun is more than DHI on a plane that faces it.
                    let sources = [condition.dni_w_m2, condition.dhi_w_m2.max(light.free[1][hour])];
                    for (column, (component, source)) in DIRECT.into_iter().zip(sources).enumerate() {
                        let received = light.received[column][hour];
                        let taken: f64 = light.objects.values().map(|object| object.taken[column][hour]).sum();
                        let free = light.free[column][hour];
                        assert!((received - f64::from(values.row(component, row)[hour])).abs() <= 1e-5 * source);
                        assert!((received + taken - free).abs() <= 1e-5 * source, "{received} + {taken}, {free}");
                    }
                    let beam = condition.dni_w_m2 * normal.dot(condition.sky_sun).max(0.0);
                    assert!((light.free[0][hour] - beam).abs() <= 1e-5 * condition.dni_w_m2);
                    if sky == SkyModel::Uniform {
                        let sky = condition.dhi_w_m2 * (1.0 + normal.z) / 2.0;
                        assert!((light.free[1][hour] - sky).abs() <= 3e-3 * condition.dhi_w_m2);
                    }
                    for (column, component) in GIVEN.into_iter().enumerate() {
                        let given: f64 = light.objects.values().map(|object| object.given[column][hour]).sum();
                        let right = f64::from(values.row(component, row)[hour]);
                        // A replay holds no values below 0, as mirrors may give of a dark horizon.
                        worst[column] = worst[column].max((given.max(0.0) - right).abs());
                        largest[column] = largest[column].max(right);
                    }
                }
                let is_leaf = |of| matches!(of, SurfaceOf::Material(number) if is_leafy(number));
                let leaves = light.objects.iter().filter(|(seen, _)| is_leaf(seen.of));
                taken_by_leaves += leaves.flat_map(|(_, light)| light.taken.iter().flatten()).sum::<f64>();
            }
        }
        assert!(receivers.next().is_none() && taken_by_leaves > 1000.0, "{taken_by_leaves}");
        let is_near = worst.iter().zip(largest).all(|(worst, largest)| largest > 1.0 && *worst <= 1e-5 * largest);
        assert!(is_near, "{worst:?} of {largest:?}");
    }
}

/// Returns the text of a box of an OBJ file whose vertices begin behind `before` others.
fn obj_box(name: &str, low: DVec3, high: DVec3, before: usize) -> String {
    let corner = |i: usize| {
        let at = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
        format!("v {} {} {}\n", at(0), at(1), at(2))
    };
    let faces = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];
    let face = |face: [usize; 4]| format!("f {}\n", face.map(|i| (i + before).to_string()).join(" "));
    format!("o {name}\nusemtl {name}\n{}{}", (0..8).map(corner).collect::<String>(), faces.map(face).concat())
}

/// Returns the light of one receiver that looks up among boxes of an OBJ file, in one sum over
/// conditions, by the name of each object.
fn among(boxes: &[(&str, DVec3, DVec3)], conditions: &[Condition]) -> (LightByObject, BTreeMap<String, [f64; 3]>) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let text: String =
        boxes.iter().enumerate().map(|(i, (name, low, high))| obj_box(name, *low, *high, 8 * i)).collect();
    let diffuse = |(i, (name, ..)): (usize, &(&str, DVec3, DVec3))| format!("[{name}]\ndiffuse = {}\n", 0.3 * i as f64);
    fs::write(path("b.obj"), text).expect("written");
    fs::write(path("b.toml"), boxes.iter().enumerate().map(diffuse).collect::<String>()).expect("written");
    let scene = Scene::load(&path("b.obj"), Some(&path("b.toml"))).expect("a scene");
    let site = site(&scene, &[Receiver::new("r".into(), v(0.0, 0.0, 0.05), DVec3::Z)], &BuildSettings::default());
    let archive = Archive::open(&site.path).expect("an archive");
    let bins = Bins { count: 1, of_condition: vec![(0, 1.0); conditions.len()] };
    let (found, names) = by_object(&archive, conditions, &bins, SkyModel::Uniform);
    let named = found[0].objects.iter().filter_map(|(seen, light)| match seen.of {
        SurfaceOf::Object(number) => {
            let given = light.given.iter().flatten().sum();
            Some((names[number as usize].clone(), [light.taken[0][0], light.taken[1][0], given]))
        }
        _ => None,
    });
    (found[0].clone(), named.collect())
}

/// Long walls of one material of 10 m, 10 m to the south and 20 m to the north of a receiver that
/// looks up, each take (1 - cos e) / 2 of a uniform sky (Hamilton and Morgan 1952, e the elevation
/// of their top), within 1 % of it. Both name themselves, and nothing else takes any.
#[test]
fn long_walls_take_their_view_factor_of_the_sky() {
    let walls = [
        ("south", v(-4000.0, -11.0, 0.0), v(4000.0, -10.0, 10.0)),
        ("north", v(-4000.0, 20.0, 0.0), v(4000.0, 21.0, 10.0)),
    ];
    let (light, found) = among(&walls, &[sky_only()]);
    for (name, distance_m) in [("south", 10.0_f64), ("north", 20.0)] {
        let elevation_rad = (9.95 / distance_m).atan();
        let right = 100.0 * (1.0 - elevation_rad.cos()) / 2.0;
        assert!((found[name][1] / right - 1.0).abs() < 0.01, "{name}: {:?}, {right}", found[name]);
    }
    assert_eq!((light.objects.len(), found.len()), (2, 2));
}

/// Returns the distance at which a line from a place meets a box.
fn meets(from: DVec3, toward: DVec3, low: DVec3, high: DVec3) -> Option<f64> {
    let (a, b) = ((low - from) / toward, (high - from) / toward);
    let (first, last) = (a.min(b).max_element(), a.max(b).min_element());
    (first > 0.0 && first < last).then_some(first)
}

/// A tower and a hall behind it each take, of 3,000 suns, those that the slab test gives the nearer
/// of the two, within 1 % of the beam that both take. A black hall gives nothing, the tower does.
#[test]
fn boxes_take_the_suns_that_they_hide() {
    let boxes = [
        ("hall", v(-40.0, -60.0, 0.0), v(40.0, -45.0, 25.0)),
        ("tower", v(-5.0, -30.0, 0.0), v(9.0, -18.0, 20.0)),
        ("court", v(-90.0, -90.0, -1.0), v(90.0, 90.0, 0.0)),
    ];
    let golden = |i: f64, factor: f64| (i * factor).fract();
    let suns: Vec<Condition> = (0..3000)
        .map(f64::from)
        .map(|i| sun(100.0 + 160.0 * golden(i, 0.754_877_666), 3.0 + 50.0 * golden(i, 0.569_840_291), 1.0, 0.0))
        .collect();
    let (light, found) = among(&boxes, &suns);
    let mut right = BTreeMap::from([("hall", 0.0), ("tower", 0.0)]);
    for condition in &suns {
        let at = v(0.0, 0.0, 0.05);
        let hits = boxes
            .iter()
            .take(2)
            .filter_map(|(name, low, high)| Some((*name, meets(at, condition.sky_sun, *low, *high)?)));
        if let Some((name, _)) = hits.min_by(|a, b| a.1.total_cmp(&b.1)) {
            *right.entry(name).or_default() += condition.sky_sun.z;
        }
    }
    let both: f64 = right.values().sum();
    for (name, right) in &right {
        assert!((found[*name][0] - right).abs() < 0.01 * both, "{name}: {:?}, {right}", found[*name]);
    }
    let free: f64 = suns.iter().map(|condition| condition.sky_sun.z).sum();
    assert!(both > 0.1 * free && (light.free[0][0] - free).abs() < 1e-5 * free);
    assert!(found["hall"][2] == 0.0 && found["tower"][2] > 0.0, "{found:?}");
}

/// Rows of a table, keyed by column.
fn rows(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let names = lines.next().expect("a header");
    lines.map(|cells| names.iter().cloned().zip(cells).collect()).collect()
}

/// `shading` writes a row for each receiver, taker and month. What the takers of a receiver give
/// adds up to the reflected columns of `replay` within the coding of stored responses, and a table
/// in Parquet is written too. An archive for replay only, one without hits, is refused by its lack,
/// and so are a table of an unknown ending and a chart of 8760 bars.
#[test]
fn tables_of_takers_agree_with_replays() {
    let folder = Folder::new();
    folder.build();
    let weather = format!("--weather {} --every month", golden().display());
    let run = |arguments: &str| {
        let output = folder.run(&format!("{arguments} {weather}"));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        rows(&stdout(&output))
    };
    let (takers, light) = (run("shading site.helio"), run("replay site.helio"));
    let number = |row: &BTreeMap<String, String>, name: &str| row[name].parse::<f64>().expect(name);
    for row in &light {
        let own = || takers.iter().filter(|taker| taker["receiver"] == row["receiver"] && taker["time"] == row["time"]);
        let sum = |name: &str| own().map(|taker| number(taker, name)).sum::<f64>();
        for name in ["sun_reflected_kwh_m2", "sky_reflected_kwh_m2"] {
            assert!((sum(name) - number(row, name)).abs() < 0.01 * sum(name).max(0.01), "{name} {row:?}");
        }
        let percent: f64 = own().map(|taker| number(taker, "sun_taken_percent")).sum();
        let (taken, arrives) = (sum("sun_taken_kwh_m2"), number(row, "sun_direct_kwh_m2"));
        assert!((taken - (taken + arrives) * percent / 100.0).abs() < 2e-4 * (taken + arrives), "{row:?}");
    }
    assert!(takers.iter().any(|row| row["taker"] == "grass" && row["class"] == "ground"), "{takers:?}");
    let parquet = folder.run(&format!("shading site.helio -o t.parquet --takers object {weather}"));
    assert!(parquet.status.success() && folder.path("t.parquet").exists(), "{}", stderr(&parquet));
    folder.run("archive extract site.helio -o r.helio --replay-only");
    folder.fails(&format!("shading r.helio {weather}"), "input lacks r.helio hits and cells");
    folder.fails(&format!("shading site.helio -o t.xlsx {weather}"), "unsupported `t.xlsx`");
    let hours = format!("--weather {} --every hour", crate::pictures::year().display());
    folder.fails(&format!("shading site.helio {hours} --plot hours.svg"), "limit 8760");
    assert!(!folder.path("hours.svg").exists());
}
