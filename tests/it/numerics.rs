//! Hard cases of tracing, each with a number: leaks, self-hits, exact edges, needles, far
//! coordinates, exact angles.

use glam::{DQuat, DVec3};
use heliotile_builder::settings::BuildSettings;
use heliotile_builder::trace::kernel::lanes::Level;
use heliotile_builder::trace::{Ray, Tracer};
use heliotile_core::hemisphere::{direction_of, jitter, mix, texel_direction, texels_in_blocks, unit};
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::Condition;
use heliotile_scene::Scene;

use crate::scenes::*;

/// Returns a unit vector of the whole sphere.
fn anywhere(seed: u64, i: u64) -> DVec3 {
    let d = direction_of(jitter(seed, i));
    if mix(seed ^ 77, i) & 1 == 0 { d } else { -d }
}

fn ray(origin: DVec3, direction: DVec3) -> Ray {
    Ray { origin: origin.as_vec3().to_array(), direction: direction.normalize().as_vec3().to_array() }
}

/// Returns a closed sphere of about `2 n^2` triangles around `centre`.
fn sphere(centre: DVec3, radius: f64, n: usize) -> Triangles {
    let at = |i: usize, j: usize| {
        let (a, b) =
            (std::f64::consts::PI * i as f64 / n as f64, 2.0 * std::f64::consts::PI * (j % n) as f64 / n as f64);
        let z = if i == 0 || i == n { (if i == 0 { 1.0 } else { -1.0 }, 0.0) } else { (a.cos(), a.sin()) };
        centre + radius * v(z.1 * b.cos(), z.1 * b.sin(), z.0)
    };
    (0..n)
        .flat_map(|i| (0..n).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [([a, b, c], 0), ([a, c, d], 0)]
        })
        .collect()
}

/// Counts rays from inside a closed mesh that escape, of three kinds: random ones, ones aimed at
/// edges, ones aimed at vertices.
fn escapes(scene: &Scene, counts: [u64; 3]) -> [usize; 3] {
    let tracer = Tracer::new(&scene.mesh).expect("a tree");
    let mesh = &scene.mesh;
    let (low, high) = mesh.bounds();
    let inside = |i: u64| {
        let j = jitter(5, i);
        (low + high) / 2.0 + (high - low) * 0.2 * v(j.x - 0.5, j.y - 0.5, unit(mix(6, i)) - 0.5)
    };
    let count = mesh.triangles.len() as u64;
    let target = |kind: usize, i: u64, from: DVec3| match kind {
        0 => anywhere(11, i),
        _ => {
            let corners = mesh.triangle_points((mix(12, i) % count) as usize);
            let (a, b) = (corners[(i % 3) as usize], corners[((i + 1) % 3) as usize]);
            // Corners in the tracer's precision.
            let (a, b) = (DVec3::from(a.as_vec3()), DVec3::from(b.as_vec3()));
            let along = if kind == 1 { unit(mix(13, i)) } else { 0.0 };
            a + (b - a) * along - from
        }
    };
    [0, 1, 2].map(|kind| {
        // Sixteen rays share an origin, as a texture's do; batches bound the memory.
        let batches = counts[kind].div_ceil(65_536);
        (0..batches)
            .map(|batch| {
                let rays: Vec<Ray> = (batch * 65_536..(batch + 1) * 65_536)
                    .map(|i| {
                        let from = DVec3::from(inside(i / 16).as_vec3());
                        ray(from, target(kind, i, from))
                    })
                    .collect();
                tracer.occluded_many(&rays).into_iter().filter(|met| !met).count()
            })
            .sum()
    })
}

fn rotated(triangles: Triangles, turn: DQuat, shift: DVec3) -> Triangles {
    triangles.into_iter().map(|(c, m)| (c.map(|p| turn * p + shift), m)).collect()
}

/// From inside a rotated closed box 10 million random rays, 1 million aimed at edges and 1 million
/// aimed at vertices are cast: 0 escape.
#[test]
fn closed_box_does_not_leak() {
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, 1.1);
    let triangles = rotated(block(v(-4.0, -3.0, -2.0), v(5.0, 6.0, 7.0), 0), turn, DVec3::ZERO);
    assert_eq!(escapes(&scene(&triangles, &[0.2]), [10_000_000, 1_000_000, 1_000_000]), [0, 0, 0]);
}

/// From inside a closed sphere of 160,000 triangles, 0 of 10 million random, 1 million edge-aimed
/// and 1 million vertex-aimed rays escape.
#[test]
fn closed_sphere_does_not_leak() {
    let triangles = sphere(v(0.3, -0.2, 0.1), 30.0, 283);
    assert!(triangles.len() > 160_000);
    assert_eq!(escapes(&scene(&triangles, &[0.2]), [10_000_000, 1_000_000, 1_000_000]), [0, 0, 0]);
}

/// First hits do not depend on how a large scene is cut into blocks: 20,000 rays through shells of
/// 150,000 triangles, far more than one block of the tree holds, meet the same triangles at the
/// same distances, to the bit, as the nearest hits of 5 trees of a fifth each.
#[test]
fn blocks_of_the_tree_change_nothing() {
    let shells = (0..5).map(|i| sphere(v(2.0 * f64::from(i), 0.5, 0.0), 3.0 + f64::from(i), 123));
    let scene = scene(&shells.collect::<Vec<_>>().concat(), &[0.2]);
    let count = scene.mesh.triangles.len() as u32;
    assert!(count > 150_000);
    let whole = Tracer::new(&scene.mesh).expect("a tree");
    let every_fifth = |i: u32| (i..count).step_by(5).collect::<Vec<u32>>();
    let parts: Vec<Tracer> = (0..5).map(|i| Tracer::of_triangles(&scene.mesh, &every_fifth(i))).collect();
    let rays: Vec<Ray> =
        (0..20_000).map(|i| ray(12.0 * (jitter(8, i / 16) - 0.5).extend(0.1), anywhere(9, i))).collect();
    let apart: Vec<_> = parts.iter().map(|part| part.closest_many(&rays)).collect();
    let (mut same, mut met) = (0, 0);
    for (i, found) in whole.closest_many(&rays).into_iter().enumerate() {
        let hits = apart.iter().filter_map(|part| part[i]);
        let nearest = hits.min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
        same += usize::from(found == nearest);
        met += usize::from(found.is_some());
    }
    assert!(same == rays.len() && met > rays.len() / 2, "{same} {met}");
}

/// From inside closed spheres at 1,000 m from the origin of the scene and far off-centre (148376,
/// 1234, -223423), 0 of 3 x 300,000 rays escape, twice.
#[test]
fn far_away_does_not_leak() {
    let off = v(148_376.0, 1234.0, -223_423.0);
    for triangles in [
        // A twin on the other side puts the scene's origin 1,000 m from each.
        [sphere(v(1000.0, 0.0, 0.0), 30.0, 60), sphere(v(-1000.0, 0.0, 0.0), 30.0, 60)].concat(),
        sphere(off, 30.0, 200),
    ] {
        let scene = scene(&triangles, &[0.2]);
        if scene.mesh.bounds().1.x > 500.0 {
            // Rays start in the middle of one sphere.
            let tracer = Tracer::new(&scene.mesh).expect("a tree");
            let centre = v(1000.0, 0.0, 0.0) - scene.mesh.origin;
            let rays: Vec<Ray> = (0..300_000)
                .map(|i| match i % 3 {
                    0 => ray(centre, anywhere(3, i)),
                    k => {
                        let near = scene.mesh.vertices.len() as u64;
                        let a = scene.mesh.vertices[(mix(4, i) % near) as usize];
                        let a = if a.x < 0.0 { v(-a.x, a.y, a.z) } else { a };
                        ray(centre, DVec3::from(a.as_vec3()) - centre + DVec3::Z * if k == 1 { 1e-9 } else { 0.0 })
                    }
                })
                .collect();
            assert_eq!(tracer.occluded_many(&rays).iter().filter(|met| !**met).count(), 0);
        } else {
            assert_eq!(escapes(&scene, [300_000; 3]), [0, 0, 0]);
        }
    }
}

/// Packets at every level that this machine has and single rays agree, bit for bit: 300,000 rays in
/// a town and a sphere, with shared and with own origins, to any distance and to three.
#[test]
fn levels_and_single_rays_agree() {
    let mut triangles = sphere(v(0.0, 0.0, 0.0), 60.0, 40);
    for i in 0..40 {
        let at = v(f64::from(i % 8) * 9.0 - 36.0, f64::from(i / 8) * 9.0 - 22.0, -20.0);
        triangles.extend(block(at, at + v(5.0, 4.0, 3.0 + f64::from(i % 7)), 1));
    }
    let scene = scene(&triangles, &[0.2, 0.3]);
    let tracers: Vec<Tracer> =
        Level::available().into_iter().map(|level| Tracer::at_level(&scene.mesh, level).expect("a tree")).collect();
    for own_origins in [false, true] {
        let rays: Vec<Ray> = (0..150_000_u64)
            .map(|i| {
                let j = jitter(1, if own_origins { i } else { i / 16 }) - 0.5;
                ray(v(j.x * 60.0, j.y * 50.0, -5.0 + j.x * 10.0), anywhere(2, i))
            })
            .collect();
        let closest: Vec<_> = rays.iter().map(|r| tracers[0].closest(*r)).collect();
        let occluded: Vec<_> = rays.iter().map(|r| tracers[0].occluded(*r)).collect();
        assert!(closest.iter().flatten().count() > 100_000);
        for tracer in &tracers {
            assert!(tracer.closest_many(&rays) == closest);
            assert!(tracer.occluded_many(&rays) == occluded);
            for reach_m in [0.5, 5.0, 50.0] {
                let near: Vec<bool> = closest.iter().map(|hit| hit.is_some_and(|hit| hit.t < reach_m)).collect();
                assert!(tracer.blocked_within(&rays, reach_m) == near);
            }
        }
    }
}

/// A square canopy above a receiver covers exactly the texels whose centre lies under it, at five
/// texture sizes from 16 to 256, with its diagonal, on which texel centres lie exactly.
#[test]
fn canopy_counts_are_exact() {
    let (half, height) = (2.0, 3.0);
    let canopy = quad(v(-half, -half, height), v(2.0 * half, 0.0, 0.0), v(0.0, 2.0 * half, 0.0), 0);
    let scene = scene(&canopy, &[0.0]);
    let tracer = Tracer::new(&scene.mesh).expect("a tree");
    let eye = DVec3::ZERO - scene.mesh.origin;
    for n in [16, 32, 64, 128, 256] {
        let rays: Vec<(Ray, bool)> = texels_in_blocks(n)
            .map(|(c, r)| {
                let d = texel_direction(c, r, n, glam::DVec2::splat(0.5));
                let p = d * (height / d.z);
                (ray(eye, d), p.x.abs().max(p.y.abs()) <= half)
            })
            .collect();
        let cast: Vec<Ray> = rays.iter().map(|r| r.0).collect();
        let covered = tracer.occluded_many(&cast).into_iter().filter(|met| *met).count();
        assert_eq!(covered, rays.iter().filter(|r| r.1).count(), "{n}");
    }
}

/// 200,000 rays straight onto the diagonals of the faces of an axis-aligned box all meet it.
#[test]
fn axis_rays_meet_diagonals() {
    let scene = scene(&block(v(-8.0, -8.0, 0.0), v(8.0, 8.0, 10.0), 0), &[0.0]);
    let tracer = Tracer::new(&scene.mesh).expect("a tree");
    let rays: Vec<Ray> = (0..200_000_u64)
        .map(|i| {
            // Multiples of 1/4096: exact in f32, so the ray lies exactly on the diagonal.
            let a = (mix(1, i) % 65_000) as f64 / 4096.0 - 7.9;
            let a = (a * 4096.0).round() / 4096.0;
            let way = [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y][(i % 4) as usize];
            ray(v(a, if i % 8 < 4 { a } else { -a }, 5.0) - scene.mesh.origin, way)
        })
        .collect();
    assert_eq!(tracer.occluded_many(&rays).iter().filter(|met| !**met).count(), 0);
}

/// Receivers on a facade, a roof and a ground of 800 m, exactly on it, 1 um and 1 mm off it: 0 of
/// 3,000 meet a surface within a centimetre.
#[test]
fn no_false_self_hits() {
    let mut triangles = ground(400.0, 0.0, 0);
    for i in 0..25 {
        let at = v(f64::from(i % 5) * 150.0 - 311.3, f64::from(i / 5) * 140.0 - 307.7, 0.0);
        triangles.extend(block(at, at + v(23.1, 17.7, 11.3 + f64::from(i)), 1));
    }
    let turn = DQuat::from_rotation_z(0.4321);
    let scene = scene(&rotated(triangles, turn, DVec3::ZERO), &[0.2, 0.3]);
    let tracer = Tracer::new(&scene.mesh).expect("a tree");
    let mut blind = 0;
    for i in 0..3000_u64 {
        let triangle = (mix(9, i / 3) % scene.mesh.triangles.len() as u64) as usize;
        let [a, b, c] = scene.mesh.triangle_points(triangle);
        let j = jitter(10, i / 3) * 0.5;
        let off = [0.0, 1e-6, 1e-3][(i % 3) as usize];
        let normal = scene.mesh.normal(triangle);
        // Points within a centimetre of an edge are avoided, where the neighbour is met rightly.
        let p = a + (b - a) * (0.02 + 0.9 * j.x) + (c - a) * (0.02 + 0.9 * j.y) + normal * off;
        let eye = p + normal * tracer.offset_m(p);
        let frame = heliotile_core::hemisphere::Frame::new(normal);
        let rays: Vec<Ray> = texels_in_blocks(32)
            .map(|(c, r)| ray(eye, frame.to_world(texel_direction(c, r, 32, glam::DVec2::splat(0.5)))))
            .collect();
        blind += u32::from(tracer.closest_many(&rays).iter().flatten().any(|hit| hit.t < 0.01));
    }
    // A point next to a wall may meet it at less than a centimetre; on this scene none does.
    assert_eq!(blind, 0);
}

/// Returns the irradiance (DHI 100 W/m2, DNI 800 W/m2) of a site turned and shifted; a uniform and
/// a sun part.
fn totals(triangles: &Triangles, turn: f64, shift: DVec3, settings: &BuildSettings) -> Vec<[f64; 3]> {
    let q = DQuat::from_rotation_z(turn);
    let places = [
        (v(-3.0, 0.0, 1.0), DVec3::Z),
        (v(3.999, 1.0, 2.0), DVec3::NEG_X),
        (v(-9.999, 3.0, 9.0), DVec3::X),
        (v(10.0, 0.0, 11.001), DVec3::Z),
        (v(-3.0, 20.0, 1.5), tilted(35.0, 200.0)),
        (v(-3.0, 10.0, 4.0), DVec3::NEG_Z),
    ];
    let receivers: Vec<_> =
        places.iter().enumerate().map(|(i, &(p, n))| receiver(&format!("{i}"), q * p + shift, q * n)).collect();
    let scene = scene(&rotated(triangles.clone(), q, shift), &[0.25, 0.4]);
    let suns = [(120.0, 50.0), (200.0, 25.0)].map(|(azimuth, altitude)| {
        let s = q * heliotile_core::units::direction_from_degrees(azimuth, altitude);
        Condition::new("c".into(), &[s], s, 800.0, 0.0)
    });
    let conditions = [sky_only(), suns[0].clone(), suns[1].clone()];
    let rows = site(&scene, &receivers, settings).replay(&conditions, SkyModel::Uniform, MaxBounces::All);
    rows.values().map(|r| [r[0].total, r[1].total, r[2].total]).collect()
}

fn three_blocks() -> Triangles {
    let mut triangles = ground(300.0, 0.0, 0);
    triangles.extend(block(v(-30.0, -10.0, 0.0), v(-10.0, 25.0, 18.0), 1));
    triangles.extend(block(v(4.0, -12.0, 0.0), v(17.0, 9.0, 11.0), 1));
    triangles.extend(block(v(-6.0, 30.0, 0.0), v(20.0, 42.0, 25.0), 1));
    triangles
}

fn worst_difference(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// A site 4194 km (2^22 m, where numbers of voxels repeat) away on two axes gives the irradiance of
/// the unshifted one within 1e-4 of the open-sky value.
#[test]
fn shift_changes_nothing() {
    let settings = BuildSettings::default();
    let here = totals(&three_blocks(), 0.0, DVec3::ZERO, &settings);
    let there = totals(&three_blocks(), 0.0, v(4_194_304.0, -4_194_304.0, 0.0), &settings);
    let worst = worst_difference(&here, &there);
    assert!(worst < 1e-4 * 100.0, "{worst} W/m2");
}

/// At UTM coordinates (5e5, 4.6e6) other cells and other random numbers give the same irradiance
/// within 1 % of the open-sky value (100 W/m2 of sky, 800 W/m2 of sun), as for a site that is
/// turned.
#[test]
fn other_coordinates_change_little() {
    let here = totals(&three_blocks(), 0.0, DVec3::ZERO, &fine());
    let there = totals(&three_blocks(), 0.0, v(5e5, 4.6e6, 312.5), &fine());
    for (a, b) in here.iter().zip(&there) {
        assert!((a[0] - b[0]).abs() < 0.01 * 100.0, "sky: {a:?} {b:?}");
        assert!((a[1] - b[1]).abs().max((a[2] - b[2]).abs()) < 0.01 * 800.0, "sun: {a:?} {b:?}");
    }
}

/// A site turned by odd angles, receivers and suns with it, gives the same irradiance but for the
/// places of texels and cells: within 1 % of the open-sky value (100 W/m2 of sky, 800 W/m2 of sun).
#[test]
fn rotation_changes_little() {
    let settings = fine();
    let here = totals(&three_blocks(), 0.0, DVec3::ZERO, &settings);
    for angle in [0.1234, 1.0, 2.71] {
        let there = totals(&three_blocks(), angle, v(12.3, -45.6, 7.8), &settings);
        for (a, b) in here.iter().zip(&there) {
            assert!((a[0] - b[0]).abs() < 0.01 * 100.0, "sky at {angle}: {a:?} {b:?}");
            assert!((a[1] - b[1]).abs().max((a[2] - b[2]).abs()) < 0.01 * 800.0, "sun at {angle}: {a:?} {b:?}");
        }
    }
}

/// Every quad split into 64 gives the same irradiance within 1e-4 of the open-sky value: cells are
/// sampled by surface, not by triangle.
#[test]
fn subdivision_changes_nothing() {
    let fine: Triangles = three_blocks()
        .chunks(2)
        .flat_map(|pair| {
            let ([a, b, _], material) = pair[0];
            let d = pair[1].0[2];
            let (x, y) = ((b - a) / 8.0, (d - a) / 8.0);
            (0..64).flat_map(move |i| quad(a + x * f64::from(i % 8) + y * f64::from(i / 8), x, y, material))
        })
        .collect();
    assert_eq!(fine.len(), three_blocks().len() * 64);
    let settings = BuildSettings::default();
    let worst = worst_difference(
        &totals(&three_blocks(), 0.0, DVec3::ZERO, &settings),
        &totals(&fine, 0.0, DVec3::ZERO, &settings),
    );
    assert!(worst < 1e-4 * 100.0, "{worst} W/m2");
}

/// With the sun at altitude 0, at exactly 90 degrees, behind the receiver or exactly on a texel
/// border, and for a receiver that faces straight down, direct sun is DNI x cosine to 1e-6 where it
/// is up, 0 elsewhere, and every component is finite.
#[test]
fn exact_angles_give_exact_direct_sun() {
    let scene = scene(&ground(500.0, -3.0, 0), &[0.2]);
    let receivers = [
        receiver("up", DVec3::ZERO, DVec3::Z),
        receiver("south", DVec3::ZERO, DVec3::NEG_Y),
        receiver("down", DVec3::ZERO, DVec3::NEG_Z),
    ];
    let border = heliotile_core::hemisphere::direction_of(glam::DVec2::new(0.5, 0.25));
    let mut suns: Vec<DVec3> = [(180.0, 0.0), (180.0, 90.0), (0.0, 30.0), (180.0, 1e-9), (180.0, 45.0)]
        .map(|(azimuth, altitude)| heliotile_core::units::direction_from_degrees(azimuth, altitude))
        .to_vec();
    suns.push(border);
    let conditions: Vec<_> = suns.iter().map(|&s| Condition::new("c".into(), &[s], s, 900.0, 80.0)).collect();
    let rows =
        site(&scene, &receivers, &BuildSettings::default()).replay(&conditions, SkyModel::Perez, MaxBounces::All);
    for (id, normal) in [("up", DVec3::Z), ("south", DVec3::NEG_Y), ("down", DVec3::NEG_Z)] {
        for (row, s) in rows[id].iter().zip(&suns) {
            let expected = if s.z > 1e-12 { 900.0 * normal.dot(*s).max(0.0) } else { 0.0 };
            assert!((row.sun_direct - expected).abs() < 1e-3, "{id} {s}: {} for {expected}", row.sun_direct);
            assert!(
                [row.sky_direct, row.sun_reflected, row.sky_reflected, row.total]
                    .iter()
                    .all(|x| x.is_finite() && *x >= 0.0)
            );
        }
    }
}

/// With needles (aspect 1e6), faces 1 mm apart, coplanar and doubled faces, and details of 1 mm on
/// a ground of 10 km, a receiver under them gets the sky that the plates leave, within 0.3 % of the
/// open sky.
#[test]
fn awkward_geometry_hides_no_more_sky_than_plates() {
    let mut triangles = ground(10_000.0, -2.0, 0);
    // A plate of 1 m at 0.5 m, twice in its plane (of another material) and once 1 mm above.
    for (z, material) in [(0.5, 1), (0.5, 0), (0.501, 1)] {
        triangles.extend(quad(v(-0.5, -0.5, z), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), material));
    }
    // Needles 100 m long and 0.1 mm wide, and crumbs of 1 mm.
    for i in 0..50 {
        let at = v(f64::from(i) * 0.37 - 9.0, -50.0, 3.0);
        triangles.push(([at, at + v(0.0, 100.0, 0.0), at + v(1e-4, 50.0, 0.0)], 1));
        let crumb = v(f64::from(i) * 0.01, 0.7, 0.2);
        triangles.push(([crumb, crumb + v(1e-3, 0.0, 0.0), crumb + v(0.0, 1e-3, 0.0)], 1));
    }
    let rows =
        site(&scene(&triangles, &[0.0, 0.0]), &[receiver("r", DVec3::ZERO, DVec3::Z)], &BuildSettings::default())
            .uniform();
    let (x, p) = (1.0_f64, 2.0_f64.sqrt());
    let plate = 4.0 / (2.0 * std::f64::consts::PI) * 2.0 * (x / p * (x / p).atan());
    assert!((rows["r"].sky_direct - 100.0 * (1.0 - plate)).abs() < 0.3, "{} {}", rows["r"].sky_direct, plate);
}

/// A million coincident triangles are built and replayed in time: 1 of 1 receivers sees half the
/// sky.
#[test]
fn a_million_coincident_triangles_are_traced_in_time() {
    // The numbers differ, but not for the f32 rays: these triangles count as duplicates.
    let triangles: Triangles = (0..1_000_000)
        .map(|i| {
            let e = f64::from(i) * 1e-13;
            ([v(0.0, -9e3 + e, -9e3), v(0.0, 9e3, -9e3 + e), v(0.0, 100.0 + e, 9e3)], 0)
        })
        .collect();
    let scene = scene(&triangles, &[0.0]);
    let settings = BuildSettings { sky_fine: 128, hit: 16, probe: 16, ..BuildSettings::default() };
    let rows = site(&scene, &[receiver("r", v(-0.05, 0.0, 0.0), DVec3::Z)], &settings).uniform();
    assert!((rows["r"].sky_direct - 50.0).abs() < 1.0, "{}", rows["r"].sky_direct);
}
