//! Mirrors and glass against the image method: light in a mirror is what the receiver's image
//! behind it would get.

use std::collections::BTreeMap;

use glam::DVec3;
use heliotile_archives::writing::{Job, Writer};
use heliotile_builder::pipeline::ReusedArchives;
use heliotile_builder::pipeline::{BuildReport, Output, Start};
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::format::{Entry, TileNumber};
use heliotile_core::archive::{Archive, format};
use heliotile_core::hemisphere::{direction_of, jitter};
use heliotile_core::light::fresnel;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::components::Component::{SkyDirect, SkyMirrored, SunDirect, SunMirrored, SunReflected};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::material::{Class, Glass, Material};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::Condition;
use heliotile_scene::Scene;

use crate::scenes::*;

fn mirror(name: &str, diffuse: f64, specular: f64) -> Material {
    Material { specular, ..Material::matt(name, diffuse, Class::Obstruction) }
}

fn matt(name: &str, diffuse: f64) -> Material {
    Material::matt(name, diffuse, Class::Obstruction)
}

/// A site in a scratch folder, and the report of its build.
struct Built {
    _folder: tempfile::TempDir,
    archive: Archive,
    report: BuildReport,
}

fn built(triangles: &Triangles, materials: Vec<Material>, receivers: &[Receiver]) -> Built {
    let scene = Scene::from_triangles(triangles, materials).expect("a valid scene");
    let folder = tempfile::tempdir().expect("a scratch folder");
    let path = folder.path().join("site.helio");
    let report = build(&scene, &mut tiles(receivers, &scene), &plan(&fine(), &path)).expect("built");
    Built { _folder: folder, archive: Archive::open(&path).expect("an archive"), report }
}

impl Built {
    /// Returns `[condition]` of one component, by receiver.
    fn rows(&self, conditions: &[Condition], sky: SkyModel, component: Component) -> BTreeMap<String, Vec<f64>> {
        self.rows_at(conditions, sky, component, MaxBounces::All)
    }

    fn rows_at(
        &self,
        conditions: &[Condition],
        sky: SkyModel,
        component: Component,
        depth: MaxBounces,
    ) -> BTreeMap<String, Vec<f64>> {
        let settings = ReplaySettings { sky, paths: depth.into(), ..ReplaySettings::default() };
        let replay =
            Replay::new(&OpenSite::open(&self.archive).expect("a site"), conditions, settings).expect("a replay");
        let mut rows = BTreeMap::new();
        for tile in replay.results(0..replay.tiles()) {
            let (ids, values) = tile.expect("a tile");
            for (i, id) in ids.into_iter().enumerate() {
                let row = values.row(component, i).iter().map(|&v| f64::from(v)).collect();
                rows.insert(id, row);
            }
        }
        rows
    }

    /// Returns a component under a uniform sky of 100 W/m2, as a share of it.
    fn sky_share(&self, id: &str, component: Component) -> f64 {
        self.rows(&[sky_only()], SkyModel::Uniform, component)[id][0] / 100.0
    }
}

/// Returns 2,000 suns all over the sky, DNI 1000 W/m2.
fn suns() -> Vec<(DVec3, Condition)> {
    (0..2000)
        .map(|i| {
            let sun = direction_of(jitter(7, i));
            (sun, Condition::new(format!("{i}"), &[sun], sun, 1000.0, 0.0))
        })
        .collect()
}

/// Returns how far inside a rectangle a ray meets it, radians from its edge as seen from the start;
/// below 0 outside.
fn inside(from: DVec3, direction: DVec3, at: DVec3, a: DVec3, b: DVec3) -> f64 {
    let normal = a.cross(b).normalize();
    let t = (at - from).dot(normal) / direction.dot(normal);
    if t.is_nan() || t <= 0.0 {
        return -1.0;
    }
    let p = from + direction * t - at;
    let (x, y) = (p.dot(a) / a.length(), p.dot(b) / b.length());
    let edge = x.min(a.length() - x).min(y).min(b.length() - y);
    // The foreshortening is the strongest possible.
    edge * direction.dot(normal).abs() / t
}

/// Half a texel's diagonal of the finest sky and half the sun's disc, radians.
const EDGE: f64 = 1.8e-3 + 4.7e-3;

/// With one mirror of 0.8 and 2,000 suns, receivers tilted four ways in front of it get 0.8 DNI n .
/// d of the mirrored sun to 1e-4 wherever that is more than half a texel and the sun's radius from
/// an edge (and between nothing and that near it), and so does one that only sees it far to the
/// side. Receivers behind it, and those that look away, get nothing.
#[test]
fn one_mirror_reflects_its_share_of_the_sun() {
    let (at, a, b) = (v(-6.0, 10.0, -1.0), v(12.0, 0.0, 0.0), v(0.0, 0.0, 9.0));
    let mut triangles = quad(at, a, b, 0);
    // A black back wall hides the mirror from behind.
    triangles.extend(quad(v(-6.0, 10.01, -1.0), a, b, 1));
    let fronts = [("south", v(0.0, 0.0, 1.0), DVec3::Y), ("up", v(1.0, 2.0, 0.0), DVec3::Z)];
    let more = [("tilted", v(-3.0, 4.0, 2.0), v(0.3, 0.6, 0.7)), ("side", v(30.0, -5.0, 3.0), v(-0.5, 0.8, 0.2))];
    let none = [("away", v(0.0, 0.0, 1.0), -DVec3::Y), ("behind", v(0.0, 20.0, 1.0), DVec3::NEG_Y)];
    let all: Vec<(&str, DVec3, DVec3)> = fronts.into_iter().chain(more).chain(none).collect();
    let receivers: Vec<Receiver> = all.iter().map(|(id, p, n)| receiver(id, *p, *n)).collect();
    let site = built(&triangles, vec![mirror("mirror", 0.0, 0.8), matt("wall", 0.0)], &receivers);
    let suns = suns();
    let conditions: Vec<Condition> = suns.iter().map(|s| s.1.clone()).collect();
    let rows = site.rows(&conditions, SkyModel::Perez, SunMirrored);
    let (mut lit, mut near_edges, mut worst) = (0, 0, 0.0_f64);
    for (id, position, normal) in &all {
        let normal = normal.normalize();
        for ((sun, _), got) in suns.iter().zip(&rows[*id]) {
            let seen = *sun - DVec3::Y * (2.0 * sun.y);
            let cos = normal.dot(seen);
            let edge = if ["away", "behind"].contains(id) { -1.0 } else { inside(*position, seen, at, a, b) };
            let whole = 800.0 * cos.max(0.0);
            if edge.abs() < EDGE {
                near_edges += 1;
                assert!((-0.1..=whole + 0.1).contains(got), "{id}: {got} of {whole}");
                continue;
            }
            let expected = if edge > 0.0 { whole } else { 0.0 };
            lit += usize::from(expected > 0.0);
            worst = worst.max((got - expected).abs());
            // Within a texel of the receiver's horizon the error of the cosine counts.
            assert!((got - expected).abs() < 0.1 + 2.0 * f64::from(cos.abs() < 5e-3), "{id} {sun}: {got} {expected}");
        }
    }
    println!("one mirror: {lit} lit, {near_edges} near edges, worst {worst:.4} W/m2 of 800");
    assert!(lit > 800 && near_edges < 300, "{lit} {near_edges}");
    // For patches of the sky, the image's view factor of the mirror's opening counts.
    let back = site.sky_share("behind", SkyMirrored);
    assert_eq!(back, 0.0);
    assert!(site.sky_share("south", SkyMirrored) > 0.05);
}

/// Between two facing mirrors of 0.9, 6 m apart and 8 m high, receivers get by 1, 2 and 3
/// reflections the light of the image method, for 2,000 suns, to 1e-4 away from edges. Paths by
/// more mirrors are left out, and are less than the reported loss.
#[test]
fn facing_mirrors_give_the_light_of_the_image_method() {
    let (length, height) = (4000.0, 8.0);
    let wall = |x: f64| quad(v(x, -length / 2.0, -1.0), v(0.0, length, 0.0), v(0.0, 0.0, height + 1.0), 0);
    let triangles = [wall(0.0), wall(6.0)].concat();
    let places = [
        ("up", v(2.0, 0.0, 0.0), DVec3::Z),
        ("left", v(4.5, 1.0, 3.0), -DVec3::X),
        ("tilted", v(3.0, 0.0, 1.0), v(0.5, 0.2, 0.6)),
    ];
    let receivers: Vec<Receiver> = places.iter().map(|(id, p, n)| receiver(id, *p, *n)).collect();
    let site = built(&triangles, vec![mirror("mirror", 0.0, 0.9)], &receivers);
    let suns = suns();
    let conditions: Vec<Condition> = suns.iter().map(|s| s.1.clone()).collect();
    let rows = site.rows(&conditions, SkyModel::Perez, SunMirrored);
    let (mut of_chain, mut skipped, mut worst) = ([0; 4], 0, 0.0_f64);
    for (id, p, normal) in &places {
        let normal = normal.normalize();
        for ((sun, _), got) in suns.iter().zip(&rows[*id]) {
            let mut expected = 0.0;
            let mut doubtful = false;
            for seen in [*sun, v(-sun.x, sun.y, sun.z)] {
                // The street is unfolded: the ray goes straight on through its images.
                let t = (height - p.z) / seen.z;
                let street = (p.x + seen.x * t) / 6.0;
                let mirrors = street.floor().abs() as usize;
                let odd_fits = (mirrors % 2 == 1) == (seen.x != sun.x);
                doubtful |= (street - street.round()).abs() * 6.0 < EDGE * t / seen.z.max(0.02)
                    || seen.z < 0.02
                    || normal.dot(seen).abs() < 5e-3
                    || (p.y + seen.y * t).abs() > length / 2.0 - 20.0;
                if (1..=3).contains(&mirrors) && odd_fits && normal.dot(seen) > 0.0 {
                    expected += 1000.0 * 0.9_f64.powi(mirrors as i32) * normal.dot(seen);
                    of_chain[mirrors] += 1;
                }
            }
            if doubtful {
                skipped += 1;
                continue;
            }
            worst = worst.max((got - expected).abs());
            assert!((got - expected).abs() < 0.1, "{id} {sun}: {got} {expected}");
        }
    }
    println!("facing mirrors: chains {of_chain:?}, {skipped} near edges, worst {worst:.4} W/m2");
    assert!(of_chain[1..].iter().all(|&count| count > 200) && skipped < 2000, "{of_chain:?} {skipped}");
    // Each direction of the upper hemisphere leaves to the sky in the end: the missing light is
    // lost behind the third mirror.
    let seen = site.sky_share("up", SkyDirect) + site.sky_share("up", SkyMirrored);
    let lost = site.report.lost_in_mirrors[0];
    println!("facing mirrors: {seen:.4} of the sky is seen, {lost:.4} is lost");
    assert!(seen < 1.0 && 1.0 - seen < lost + 0.01 && lost < 0.3, "{seen} {lost}");
}

/// A lake of glass-like water lies before a facade: at sun altitudes of 3 to 40 degrees
/// sun_mirrored on the facade is DNI n . s times Fresnel's reflectance at that angle, to 1e-3 of it
/// (0.85 of DNI n . s at 3 degrees and 0.11 at 40). A receiver that looks up gets none.
#[test]
fn a_lake_reflects_by_fresnel_at_low_sun() {
    let lake = quad(v(-3000.0, -6000.0, 0.0), v(6000.0, 0.0, 0.0), v(0.0, 5990.0, 0.0), 0);
    let water = Material { glass: Some(Glass::Single), ..Material::matt("water", 0.03, Class::Ground) };
    let receivers = [receiver("facade", v(0.0, 0.0, 12.0), -DVec3::Y), receiver("up", v(0.0, 0.0, 12.0), DVec3::Z)];
    let site = built(&lake, vec![water], &receivers);
    let altitudes = [3.0, 5.0, 10.0, 20.0, 30.0, 40.0];
    let conditions: Vec<Condition> = altitudes.iter().map(|&a| sun(185.0, a, 1000.0, 0.0)).collect();
    let rows = site.rows(&conditions, SkyModel::Perez, SunMirrored);
    for ((altitude, condition), got) in altitudes.iter().zip(&conditions).zip(&rows["facade"]) {
        let s = condition.suns[0].sun;
        let share = fresnel::panes(1, s.z);
        let expected = 1000.0 * share * -s.y;
        println!("lake at {altitude}: {got:.2} W/m2, share {share:.3}");
        assert!((got - expected).abs() < 1e-3 * expected, "{altitude}: {got} {expected}");
    }
    assert!(rows["up"].iter().all(|&v| v == 0.0));
    assert!(
        fresnel::panes(1, 3.0_f64.to_radians().sin()) > 0.75 && fresnel::panes(1, 40.0_f64.to_radians().sin()) < 0.2
    );
}

/// Before a boundless mirror wall of 0.8 a vertical receiver sees 0.4 of the open sky in it and
/// none besides. Ground of 0.3, which gets the sky and the sun twice, once by the mirror (0.8),
/// fills the lower half, half of it in the mirror: sky_reflected and sun_reflected are 0.3 x (1 +
/// 0.8) / 2 x (the share seen directly + 0.8 x the share seen in the mirror), all within 1.5 %. One
/// and all bounces are alike.
#[test]
fn ground_before_a_mirror_is_lit_twice() {
    let wall = quad(v(-4000.0, 0.0, 0.0), v(8000.0, 0.0, 0.0), v(0.0, 0.0, 4000.0), 0);
    let floor = quad(v(-4000.0, -8000.0, 0.0), v(8000.0, 0.0, 0.0), v(0.0, 8000.0, 0.0), 1);
    let triangles = [wall, floor].concat();
    // The receiver is so far from the wall, relative to its height, that half of the lower quarter
    // sphere is the floor in front, half its image.
    let receivers = [receiver("at wall", v(0.0, -0.5, 20.0), DVec3::Y), receiver("out", v(0.0, -0.5, 20.0), -DVec3::Y)];
    let site = built(&triangles, vec![mirror("mirror", 0.0, 0.8), matt("floor", 0.3)], &receivers);
    let near = |what: &str, got: f64, expected: f64| {
        println!("{what}: {got:.4}, expected {expected:.4}");
        assert!((got - expected).abs() < 0.015 * expected.max(0.05), "{what}: {got} {expected}");
    };
    near("sky in the mirror", site.sky_share("at wall", SkyMirrored), 0.4);
    assert!(site.sky_share("at wall", SkyDirect) < 2e-3);
    let floor_gets = (1.0 + 0.8) / 2.0;
    // The part of the lower half between the receiver and the foot of the wall is seen directly: (1
    // - sin atan(20 / 0.5)) / 2 of it.
    let direct = 0.5 * (1.0 - 20.0 / 20.0_f64.hypot(0.5));
    let floor_seen = direct + 0.8 * (0.5 - direct);
    let all =
        |depth| site.rows_at(&[sky_only()], SkyModel::Uniform, Component::SkyReflected, depth)["at wall"][0] / 100.0;
    near("floor, sky, all bounces", all(MaxBounces::All), 0.3 * floor_gets * floor_seen);
    near("floor, sky, one bounce", all(MaxBounces::Count(1)), 0.3 * floor_gets * floor_seen);
    let sunny = [sun(180.0, 40.0, 1000.0, 0.0)];
    let horizontal = 1000.0 * 40.0_f64.to_radians().sin();
    let of = |id: &str, component| site.rows(&sunny, SkyModel::Perez, component)[id][0];
    near("floor, sun", of("at wall", SunReflected) / horizontal, 0.3 * 1.8 * floor_seen);
    near("floor, sun, seen from the wall", of("out", SunReflected) / horizontal, 0.3 * 1.8 * 0.5);
    near("sun in the mirror", of("at wall", SunMirrored), 800.0 * 40.0_f64.to_radians().cos());
    assert!(of("at wall", SunDirect) == 0.0);
}

/// A wall reflects 0.3 diffusely and 0.5 like a mirror: a receiver that sees nothing else gets 0.25
/// of the open sky by the mirror and 0.15 diffusely, within 1 %; a `--reflectance` would change the
/// diffuse part alone.
#[test]
fn a_wall_reflects_diffusely_and_like_a_mirror() {
    let wall = quad(v(-4000.0, 0.0, -4000.0), v(8000.0, 0.0, 0.0), v(0.0, 0.0, 8000.0), 0);
    let site = built(&wall, vec![mirror("wall", 0.3, 0.5)], &[receiver("r", v(0.0, -3.0, 0.0), DVec3::Y)]);
    let (specular, diffuse) = (site.sky_share("r", SkyMirrored), site.sky_share("r", Component::SkyReflected));
    assert!((specular - 0.25).abs() < 0.0025 && (diffuse - 0.15).abs() < 0.0015, "{specular} {diffuse}");
}

/// A room is open to the sky through a part of its roof; two facing walls are 0.85 mirror and 0.05
/// diffuse, all else is white (0.8). The light that its surfaces absorb and that leaves is the
/// light that enters, within 2 % and the loss that the build reports (at most 16 %), and never more
/// than 1 % above, wherever cells cut the room: at three places.
#[test]
fn a_room_of_mirrors_conserves_energy() {
    for corner in [v(-3.0, -3.0, -1.5), DVec3::ZERO, v(64.3, 33.7, 20.4)] {
        room_at(corner);
    }
}

/// Checks the room with its lowest corner at a place.
fn room_at(corner: DVec3) {
    let (a, h) = (6.0, 3.0);
    let (x, y, z) = (v(a, 0.0, 0.0), v(0.0, a, 0.0), v(0.0, 0.0, h));
    let mut triangles = Triangles::new();
    triangles.extend(quad(corner, x, y, 1));
    triangles.extend([quad(corner, y, z, 0), quad(corner + x, z, y, 0)].concat());
    triangles.extend([quad(corner, z, x, 1), quad(corner + y, x, z, 1)].concat());
    triangles.extend(quad(corner + z, y, x / 2.0, 1));
    let n = 5;
    let mut receivers = Vec::new();
    let mut grid = |name: &str, at: DVec3, u: DVec3, w: DVec3, normal: DVec3| {
        for i in 0..n * n {
            let place =
                at + u * ((f64::from(i % n) + 0.5) / f64::from(n)) + w * ((f64::from(i / n) + 0.5) / f64::from(n));
            receivers.push(receiver(&format!("{name} {i}"), place + normal * 1e-3, normal));
        }
    };
    grid("floor", corner, x, y, DVec3::Z);
    grid("mirror west", corner, y, z, DVec3::X);
    grid("mirror east", corner + x, y, z, -DVec3::X);
    grid("south", corner, x, z, DVec3::Y);
    grid("north", corner + y, x, z, -DVec3::Y);
    grid("roof", corner + z, x / 2.0, y, -DVec3::Z);
    grid("out", corner + z + x / 2.0, x / 2.0, y, -DVec3::Z);
    let site = built(&triangles, vec![mirror("mirror", 0.05, 0.85), matt("white", 0.8)], &receivers);
    let rows = site.rows(&[sky_only()], SkyModel::Uniform, Component::Total);
    let mean = |name: &str| (0..n * n).map(|i| rows[&format!("{name} {i}")][0]).sum::<f64>() / f64::from(n * n);
    let absorbed = [
        (mean("floor"), a * a, 0.2),
        (mean("mirror west"), a * h, 0.1),
        (mean("mirror east"), a * h, 0.1),
        (mean("south"), a * h, 0.2),
        (mean("north"), a * h, 0.2),
        (mean("roof"), a * a / 2.0, 0.2),
    ];
    let absorbed: f64 = absorbed.iter().map(|(e, area, share)| e * area * share).sum();
    let (left, came) = (mean("out") * a * a / 2.0, 100.0 * a * a / 2.0);
    let found = (absorbed + left) / came;
    println!("room of mirrors: {found:.4} of what comes in is found, lost {:.4?}", site.report.lost_in_mirrors);
    let lost = site.report.lost_in_mirrors.into_iter().fold(0.0, f64::max);
    assert!(found < 1.01 && found > 1.0 - 0.02 - lost && lost < 0.16, "{corner}: {found} {lost}");
}

/// If no surface is a mirror, or no receiver and no cell can see one, no ray is cast for mirrors
/// beyond looking for them, and no block of mirrors is written: 0 of 3 kinds.
#[test]
fn unseen_mirrors_cost_no_rays_and_no_blocks() {
    let receivers = [receiver("up", v(0.0, 0.0, 0.1), DVec3::Z)];
    let kinds = [format::MIRROR, format::PROBE_MIRROR, format::BOUNCE_MIRROR];
    let blocks = |site: &Built| kinds.iter().filter(|&&kind| !site.archive.entries_of(kind).is_empty()).count();
    let plain = built(&town(), vec![matt("a", 0.2), matt("b", 0.3)], &receivers);
    assert_eq!((blocks(&plain), plain.report.rays.mirror), (0, 0));
    assert!(
        !plain.archive.has(format::OPTICS, TileNumber::FIRST) && !plain.archive.has(format::MIRRORS, TileNumber::FIRST)
    );
    // A mirror below the ground.
    let mut triangles = town();
    triangles.extend(quad(v(-5.0, -5.0, -9.0), v(10.0, 0.0, 0.0), v(0.0, 10.0, 0.0), 2));
    let hidden = built(&triangles, vec![matt("a", 0.2), matt("b", 0.3), mirror("m", 0.0, 0.9)], &receivers);
    assert_eq!(blocks(&hidden), 0);
    let seen = built(&town(), vec![matt("a", 0.2), mirror("b", 0.3, 0.4)], &receivers);
    assert!(blocks(&seen) == 3 && seen.report.rays.mirror > 0);
}

/// Settings for tests of bytes, not of accuracy.
fn coarse() -> BuildSettings {
    BuildSettings {
        sky_base: 16,
        sky_fine: 64,
        hit: 8,
        cell_floor_m: 4.0,
        probe: 8,
        probe_hits: 8,
        bounce_sky: 8,
        bounce_hits: 16,
        ..BuildSettings::default()
    }
}

/// A town with mirrors and glass built on one and two threads, with receivers in another order and
/// with faces in another order has one root and the same bytes, 3 of 3. So has a build that finds
/// the first archive in its store, and that one casts 0 rays. One that finds an archive without the
/// blocks of mirrors casts all of them.
#[test]
fn bytes_depend_on_content_only() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let path = |name: &str| folder.path().join(name);
    let with = |name: &str, threads: usize, [receivers_too, faces_too]: [bool; 2], earlier: Option<&Archive>| {
        let mut receivers = many()[..80].to_vec();
        let mut triangles = mirror_triangles();
        if receivers_too {
            receivers.reverse();
        }
        if faces_too {
            triangles.reverse();
        }
        let scene = Scene::from_triangles(&triangles, mirror_materials()).expect("a valid scene");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let build = || {
            build_with(
                &scene,
                &mut tiles(&receivers, &scene),
                &plan(&coarse(), &path(name)),
                &ReusedArchives { earlier, before: None },
            )
        };
        let report = pool.install(build).expect("a build");
        (report.root, std::fs::read(path(name)).expect("the archive"), report.rays)
    };
    let first = with("a.helio", 1, [false; 2], None);
    assert!(first.2.mirror > 10_000, "{:?}", first.2);
    for (name, threads, reversed) in [("b", 2, [false; 2]), ("c", 2, [true, false]), ("d", 1, [false, true])] {
        let other = with(name, threads, reversed, None);
        assert_eq!(first.0, other.0, "{name}");
        assert!(first.1 == other.1, "{name} has other bytes");
    }
    let known = with("e", 2, [false; 2], Some(&Archive::open(&path("a.helio")).expect("an archive")));
    assert_eq!(known.2.total(), 0);
    assert!(known.1 == first.1);
    let archive = Archive::open(&path("a.helio")).expect("an archive");
    let job = Job { scene: [0; 32], receivers: [0; 32], settings: [0; 32] };
    let mut writer = Writer::create(&path("bare.helio"), &job).expect("a writer");
    let of_mirrors = [format::MIRROR, format::PROBE_MIRROR, format::BOUNCE_MIRROR, format::MIRRORS, format::OPTICS];
    for entry in archive.entries().iter().filter(|entry| !of_mirrors.contains(&entry.kind)) {
        writer.append(archive.copy(entry).expect("a block")).expect("appended");
    }
    let mut manifest = archive.manifest().clone();
    manifest.layers = writer.layers();
    writer.finish(&manifest).expect("an archive");
    let bare = with("f", 2, [false; 2], Some(&Archive::open(&path("bare.helio")).expect("an archive")));
    assert!(bare.1 == first.1 && bare.2.total() == first.2.total());
}

/// A build with mirrors that is resumed after any whole tile or chunk ends with the bytes of an
/// undisturbed one, more than 5 times.
#[test]
fn resumed_builds_have_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let (whole, path) = (folder.path().join("whole.helio"), folder.path().join("site.helio"));
    let (scene, receivers) = (mirror_town(), &many()[..80]);
    build(&scene, &mut tiles(receivers, &scene), &plan(&coarse(), &whole)).expect("a build");
    let expected = std::fs::read(&whole).expect("an archive");
    let archive = Archive::open(&whole).expect("an archive");
    let job = Job {
        scene: scene.named_hash(),
        receivers: tiles(receivers, &scene).content_hash(),
        settings: coarse().stated().hash().expect("a hash"),
    };
    let mut entries: Vec<Entry> = archive.entries().to_vec();
    entries.sort_by_key(|entry| entry.offset);
    // Checkpoints are made between tiles, between chunks and after all tables.
    let starts =
        [format::RECEIVERS, format::PROBES, format::BOUNCE, format::INDEX, format::MATERIALS, format::RESPONSE];
    let cuts: Vec<usize> = (1..entries.len()).filter(|&cut| starts.contains(&entries[cut].kind)).collect();
    assert!(cuts.len() > 5, "{} blocks", entries.len());
    for cut in cuts {
        let mut writer = Writer::create(&path, &job).expect("a writer");
        for entry in &entries[..cut] {
            writer.append(archive.copy(entry).expect("a block")).expect("appended");
        }
        writer.keep().expect("a checkpoint");
        let (what, output) = plan(&coarse(), &path);
        let plan = (what, Output { start: Start::Resume, ..output });
        build(&scene, &mut tiles(receivers, &scene), &plan).expect("a build");
        assert!(std::fs::read(&path).expect("an archive") == expected, "after {cut} blocks: other bytes");
        std::fs::remove_file(&path).expect("removed");
    }
}
