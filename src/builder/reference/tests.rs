use super::*;
use crate::pipeline::PreparedScene;
use crate::settings::Effects;
use glam::DVec3;
use heliotile_core::hemisphere::mix;
use heliotile_core::replay::components::Component;
use heliotile_core::site::material::{Class, Material};
use heliotile_core::sky::model::{CieType, SkyModel};
use heliotile_core::units::{SUN_RADIUS_RAD, direction_from_degrees};
use heliotile_core::weather::conditions::Condition;
use heliotile_scene::Scene;
use std::f64::consts::PI;

type Triangles = Vec<([DVec3; 3], u16)>;

fn quad(triangles: &mut Triangles, material: u16, corner: DVec3, a: DVec3, b: DVec3) {
    triangles.push(([corner, corner + a, corner + a + b], material));
    triangles.push(([corner, corner + a + b, corner + b], material));
}

fn condition(azimuth_deg: f64, altitude_deg: f64, dni: f64, dhi: f64) -> Condition {
    let sun = direction_from_degrees(azimuth_deg, altitude_deg);
    Condition::new("c".into(), &[sun], sun, dni, dhi)
}

fn matt(diffuse: f64) -> Material {
    Material::matt(format!("m{diffuse}"), diffuse, Class::Obstruction)
}

/// Receiver, its normal and its components by closed forms.
type ClosedForm = (DVec3, DVec3, [f64; 6]);

/// Number of comparisons, those of them that are off by more than 3 standard errors, the sum of
/// differences in standard errors, and the largest difference relative to the total.
struct Count {
    all: usize,
    beyond: usize,
    sum: f64,
    largest: f64,
}

impl Count {
    fn new() -> Self {
        Count { all: 0, beyond: 0, sum: 0.0, largest: 0.0 }
    }

    fn compare(
        &mut self,
        triangles: &Triangles,
        materials: Vec<Material>,
        condition: &Condition,
        known: &[ClosedForm],
        seeds: u64,
    ) {
        let scene = Scene::from_triangles(triangles, materials).expect("a scene");
        let prepared = PreparedScene::new(&scene).expect("a tree");
        let tracer = PathTracer::new(&prepared, Effects::NONE);
        let sky = ReferenceSky::new(condition, SkyModel::Uniform).expect("a sky");
        for (place, (position, normal, expected)) in known.iter().enumerate() {
            let total: f64 = expected.iter().sum();
            for seed in 0..seeds {
                let reference = tracer.irradiance(*position, *normal, &[&sky], 2048, mix(seed, place as u64))[0];
                for (part, expected) in expected.iter().chain([&total]).enumerate() {
                    // Parts that are known exactly have no error but rounding.
                    let error = reference.error[part].max(1e-4 * total);
                    let off = (reference.mean[part] - expected) / error;
                    if reference.mean[part] > 0.0 || *expected > 0.0 {
                        self.all += 1;
                        self.beyond += usize::from(off.abs() > 3.0);
                        self.sum += off;
                        self.largest = self.largest.max((reference.mean[part] - expected).abs() / total);
                    }
                }
            }
        }
    }
}

/// On ground of 40 km, tilted receivers match the isotropic closed form (Liu and Jordan 1963)
/// within 3 standard errors in 97.5 % of 840 comparisons.
#[test]
fn tilted_receivers_on_open_ground_are_isotropic() {
    let mut triangles = Triangles::new();
    quad(&mut triangles, 0, DVec3::new(-2e4, -2e4, 0.0), DVec3::X * 4e4, DVec3::Y * 4e4);
    let (dni, dhi, albedo) = (800.0, 150.0, 0.3);
    let condition = condition(150.0, 35.0, dni, dhi);
    let sun = condition.sky_sun;
    let known = |tilt_deg: f64| {
        let normal = direction_from_degrees(190.0, 90.0 - tilt_deg);
        let (up, down) = ((1.0 + normal.z) / 2.0, (1.0 - normal.z) / 2.0);
        let expected =
            [dni * normal.dot(sun).max(0.0), dhi * up, albedo * dni * sun.z * down, albedo * dhi * down, 0.0, 0.0];
        (DVec3::new(3.0, 4.0, 1.0), normal, ordered(expected))
    };
    let mut count = Count::new();
    count.compare(&triangles, vec![matt(albedo)], &condition, &[20.0, 60.0, 90.0, 140.0].map(known), 48);
    assert!(count.all >= 840 && count.beyond * 40 <= count.all, "{} of {}", count.beyond, count.all);
    assert!((count.sum / count.all as f64).abs() < 0.15 && count.largest < 0.02, "{} {}", count.sum, count.largest);
}

/// Puts components in the order of light paths used here into that of results.
fn ordered([sun_direct, sky_direct, sun_reflected, sky_reflected, sun_mirrored, sky_mirrored]: [f64; 6]) -> [f64; 6] {
    let mut out = [0.0; 6];
    for (component, value) in [
        (Component::SunDirect, sun_direct),
        (Component::SkyDirect, sky_direct),
        (Component::SunReflected, sun_reflected),
        (Component::SkyReflected, sky_reflected),
        (Component::SunMirrored, sun_mirrored),
        (Component::SkyMirrored, sky_mirrored),
    ] {
        out[component as usize] = value;
    }
    out
}

/// Endless leaves that let 0.4 through and scatter 0.5, half to each side, lie between ground of
/// 0.3 and the open sky. By the theory of two layers (Kubelka 1954, "New contributions to the
/// optics of intensely light-scattering materials, part II") a level receiver below them gets T /
/// (1 - R rho) of the light from above, and one that looks down from above gets R + T^2 rho / (1 -
/// R rho), with R = 0.25 and T = 0.65: within 3 standard errors in 97.5 % of 240 comparisons.
#[test]
fn light_through_leaves_is_that_of_two_layers() {
    let mut triangles = Triangles::new();
    for (material, z) in [(0, 0.0), (1, 2.0)] {
        quad(&mut triangles, material, DVec3::new(-2e4, -2e4, z), DVec3::X * 4e4, DVec3::Y * 4e4);
    }
    let (dni, dhi, albedo, straight, scattered) = (800.0, 150.0, 0.3, 0.4, 0.5);
    let condition = condition(150.0, 35.0, dni, dhi);
    let from_sun = dni * condition.sky_sun.z;
    let leaf = Material { transmittance: Some(straight), ..Material::matt("z leaf", scattered, Class::Obstruction) };
    let (r, t) = (scattered / 2.0, straight + scattered / 2.0);
    let (below, above) = (t / (1.0 - r * albedo), r + t * t * albedo / (1.0 - r * albedo));
    let parts = |[sun, sky]: [f64; 2], share: f64| {
        let diffuse = |direct: f64| share - direct;
        ordered([sun * from_sun, sky * dhi, diffuse(sun) * from_sun, diffuse(sky) * dhi, 0.0, 0.0])
    };
    let known = [
        (DVec3::new(3.0, 4.0, 1.0), DVec3::Z, parts([straight; 2], below)),
        (DVec3::new(3.0, 4.0, 3.0), DVec3::NEG_Z, parts([0.0; 2], above)),
    ];
    let mut count = Count::new();
    count.compare(&triangles, vec![matt(albedo), leaf], &condition, &known, 48);
    assert!(count.all >= 240 && count.beyond * 40 <= count.all, "{} of {}", count.beyond, count.all);
    assert!((count.sum / count.all as f64).abs() < 0.2 && count.largest < 0.03, "{} {}", count.sum, count.largest);
}

/// A level receiver stands in front of a long black-backed wall of 10 m without ground, which the
/// sun lights straight on, wholly or above a shadow's edge at 4 m. It gets the view factor of the
/// lit strip, (cos a - cos b) / 2 by the altitudes of its edges, times the light that the wall
/// reflects: within 3 standard errors in 97.5 % of 480 comparisons.
#[test]
fn a_lit_wall_gives_its_view_factor() {
    let (dni, albedo, altitude) = (700.0, 0.6, 30.0_f64.to_radians());
    let condition = condition(90.0, 30.0, dni, 0.0);
    let wall_w_m2 = albedo * dni * altitude.cos();
    let mut count = Count::new();
    for shaded_m in [0.0, 4.0] {
        let mut triangles = Triangles::new();
        quad(&mut triangles, 0, DVec3::new(0.0, -4e3, 0.0), DVec3::Y * 8e3, DVec3::Z * 10.0);
        // A black blade whose upper edge casts the shadow.
        let top = shaded_m + 60.0 * altitude.tan();
        let blade = if shaded_m > 0.0 { top } else { -1.0 };
        quad(&mut triangles, 1, DVec3::new(60.0, -4e3, -2.0), DVec3::Y * 8e3, DVec3::Z * (blade + 2.0));
        let known = |x: f64| {
            let cos = |z: f64| x / x.hypot(z);
            let receiver_lit = shaded_m == 0.0 || (60.0 - x) * altitude.tan() > top;
            let direct = if receiver_lit { dni * altitude.sin() } else { 0.0 };
            let expected = [direct, 0.0, wall_w_m2 * (cos(shaded_m) - cos(10.0)) / 2.0, 0.0, 0.0, 0.0];
            (DVec3::new(x, 0.0, 0.0), DVec3::Z, ordered(expected))
        };
        count.compare(&triangles, vec![matt(albedo), matt(0.0)], &condition, &[0.5, 3.0, 12.0, 40.0].map(known), 24);
    }
    assert!(count.all >= 480 && count.beyond * 40 <= count.all, "{} of {}", count.beyond, count.all);
    assert!((count.sum / count.all as f64).abs() < 0.2, "{}", count.sum);
}

/// Below a blade whose level edge leaves 10, 50 and 90 % of the sun's disc open, receivers get that
/// share of it (a segment of a circle), by 256 and by 1,024 points of the disc. Over 400 seeds the
/// mean is right within 3 of its standard errors, and the squared standard error equals the squared
/// difference within a quarter.
#[test]
fn an_edge_hides_its_share_of_the_sun() {
    let (dni, altitude) = (800.0, 30.0_f64.to_radians());
    let condition = condition(90.0, 30.0, dni, 100.0);
    let sky = ReferenceSky::new(&condition, SkyModel::Uniform).expect("a sky");
    // Height of the edge above the centre of the disc, in radii, and the open share.
    for t in [-0.687_f64, 0.0, 0.687] {
        let open = (t.acos() - t * (1.0 - t * t).sqrt()) / PI;
        // The open part is higher than the centre.
        let higher = SUN_RADIUS_RAD * 2.0 / 3.0 * (1.0 - t * t).powf(1.5) / PI;
        let expected = dni * (altitude.sin() * open + altitude.cos() * higher);
        let top = 400.0 * (altitude + t * SUN_RADIUS_RAD).tan();
        let mut triangles = Triangles::new();
        quad(&mut triangles, 0, DVec3::new(400.0, -400.0, -2.0), DVec3::Y * 800.0, DVec3::Z * (top + 2.0));
        let scene = Scene::from_triangles(&triangles, vec![matt(0.0)]).expect("a scene");
        let prepared = PreparedScene::new(&scene).expect("a tree");
        let tracer = PathTracer::new(&prepared, Effects::NONE);
        for paths in [4096, 16384] {
            let (mut sum, mut square, mut noise) = (0.0, 0.0, 0.0);
            for seed in 0..400 {
                let reference = tracer.sun(DVec3::ZERO, DVec3::Z, &[&sky], paths, seed)[0];
                let [mean, error] = [reference.mean, reference.error].map(|of| of[Component::SunDirect as usize]);
                let off = mean - expected;
                (sum, square, noise) = (sum + off / 400.0, square + off * off / 400.0, noise + error * error / 400.0);
                assert_eq!((reference.mean[6], reference.mean[Component::SkyDirect as usize]), (mean, 0.0));
            }
            assert!(sum.abs() < 3.0 * (noise / 400.0).sqrt() + 0.2, "{t} {paths}: {sum} {noise}");
            assert!((square / noise - 1.0).abs() < 0.25, "{t} {paths}: {square} {noise}");
        }
    }
}

/// A court 12 m deep of surfaces that absorb nothing, matt or half mirrors, is as bright everywhere
/// as the uniform sky above. Receivers on floor and walls get all of DHI, within 3 standard errors
/// in 97 % of 150 totals and within 0.6 % in their mean.
#[test]
fn a_white_court_is_as_bright_as_the_sky() {
    for specular in [0.0, 0.5] {
        let mut triangles = Triangles::new();
        let (a, b, up) = (DVec3::X * 8.0, DVec3::Y * 5.0, DVec3::Z * 12.0);
        quad(&mut triangles, 0, DVec3::ZERO, a, b);
        for (corner, along) in [(DVec3::ZERO, a), (b, a), (DVec3::ZERO, b), (a, b)] {
            quad(&mut triangles, 0, corner, along, up);
        }
        let white = Material { specular, ..matt(1.0 - specular) };
        let scene = Scene::from_triangles(&triangles, vec![white]).expect("a scene");
        let prepared = PreparedScene::new(&scene).expect("a tree");
        let sky = ReferenceSky::new(&condition(90.0, 45.0, 0.0, 200.0), SkyModel::Uniform).expect("a sky");
        let (mut beyond, mut sum) = (0, 0.0);
        for (position, normal) in [
            (DVec3::new(2.0, 2.0, 0.0), DVec3::Z),
            (DVec3::new(0.0, 2.0, 1.0), DVec3::X),
            (DVec3::new(4.0, 5.0, 9.0), DVec3::NEG_Y),
        ] {
            for seed in 0..50 {
                let reference =
                    PathTracer::new(&prepared, Effects::NONE).irradiance(position, normal, &[&sky], 2048, seed)[0];
                sum += reference.mean[6] / 150.0;
                beyond += usize::from((reference.mean[6] - 200.0).abs() > 3.0 * reference.error[6]);
            }
        }
        assert!(beyond <= 4 && (sum / 200.0 - 1.0).abs() < 0.006, "{beyond} {sum}");
    }
}

/// In front of one mirror, and of two mirrors at right angles, receivers get the light of the
/// images of sun and sky, 1 and 3 images, within 3 standard errors in 97.5 % of 480 comparisons. A
/// screen that lets 0.4 through leaves 0.4.
#[test]
fn mirrors_give_the_light_of_their_images() {
    let (dni, dhi, share) = (600.0, 120.0, 0.7);
    let condition = condition(50.0, 40.0, dni, dhi);
    let sun = condition.sky_sun;
    let mirror = Material { specular: share, ..Material::matt("mirror", 0.0, Class::Obstruction) };
    let screen = Material { transmittance: Some(0.4), ..matt(0.0) };
    let (x, y) = (
        (DVec3::new(0.0, -2e4, -2e4), DVec3::Y * 4e4, DVec3::Z * 4e4),
        (DVec3::new(-2e4, 0.0, -2e4), DVec3::X * 4e4, DVec3::Z * 4e4),
    );
    let mut count = Count::new();
    for (both, through) in [(false, 1.0), (true, 1.0), (false, 0.4)] {
        let mut triangles = Triangles::new();
        quad(&mut triangles, 0, x.0, x.1, x.2);
        if both {
            quad(&mut triangles, 0, y.0, y.1, y.2);
        }
        if through < 1.0 {
            quad(&mut triangles, 1, DVec3::new(-2e4, -2e4, 3.0), DVec3::X * 4e4, DVec3::Y * 4e4);
        }
        let flip = |d: DVec3, x: f64, y: f64| DVec3::new(d.x * x, d.y * y, d.z);
        let images: &[(f64, f64, f64)] = if both {
            &[(-1.0, 1.0, share), (1.0, -1.0, share), (-1.0, -1.0, share * share)]
        } else {
            &[(-1.0, 1.0, share)]
        };
        let known = |normal: DVec3| {
            let sun_mirrored: f64 =
                images.iter().map(|(x, y, share)| share * dni * normal.dot(flip(sun, *x, *y)).max(0.0)).sum();
            // Each mirror hides a part of a level receiver's sky, which its image gives back: half,
            // or a quarter.
            let parts = if both { 4.0 } else { 2.0 };
            let sky_mirrored: f64 = images.iter().map(|image| image.2).sum::<f64>() * dhi / parts;
            let expected = [dni * normal.dot(sun).max(0.0), dhi / parts, 0.0, 0.0, sun_mirrored, sky_mirrored]
                .map(|v| v * through);
            (DVec3::new(5.0, 7.0, 0.0), normal, ordered(expected))
        };
        count.compare(&triangles, vec![mirror.clone(), screen.clone()], &condition, &[known(DVec3::Z)], 32);
        // Only suns: the closed form of the sky does not hold for upright receivers.
        let dark = Condition { dhi_w_m2: 0.0, ..condition.clone() };
        let upright = [DVec3::NEG_X, DVec3::X].map(|normal| {
            let (position, normal, mut expected) = known(normal);
            expected[Component::SkyDirect as usize] = 0.0;
            expected[Component::SkyMirrored as usize] = 0.0;
            (position, normal, expected)
        });
        count.compare(&triangles, vec![mirror.clone(), screen.clone()], &dark, &upright, 16);
    }
    assert!(count.all >= 480 && count.beyond * 40 <= count.all, "{} of {}", count.beyond, count.all);
    assert!((count.sum / count.all as f64).abs() < 0.15 && count.largest < 0.02, "{} {}", count.sum, count.largest);
}

/// An open level receiver gets DHI of the 16 CIE skies and of Perez' sky, within 3 standard errors
/// and 0.5 %: 17 of 17.
#[test]
fn a_level_receiver_gets_dhi_of_every_sky() {
    let scene = Scene::from_triangles(&[([DVec3::ZERO, DVec3::X, DVec3::Y], 0)], vec![matt(0.2)]).expect("a scene");
    let prepared = PreparedScene::new(&scene).expect("a tree");
    let models = CieType::all().map(SkyModel::Cie).chain([SkyModel::Perez]);
    let mut seen = 0;
    for model in models {
        let sky = ReferenceSky::new(&condition(200.0, 50.0, 600.0, 180.0), model).expect("a sky");
        let reference = PathTracer::new(&prepared, Effects::NONE).irradiance(
            DVec3::new(9.0, 9.0, 1.0),
            DVec3::Z,
            &[&sky],
            1 << 14,
            3,
        )[0];
        let off = (reference.mean[Component::SkyDirect as usize] - 180.0).abs();
        assert!(
            off < (3.0 * reference.error[Component::SkyDirect as usize]).max(0.05) && off < 0.9,
            "{model:?} {reference:?}"
        );
        seen += 1;
    }
    assert_eq!(seen, 17);
}
