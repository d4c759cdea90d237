//! The endless ground of `materials.toml` against closed forms.

use heliotile_builder::settings::BuildSettings;
use heliotile_core::light::radiosity::Depth;
use heliotile_core::sky::model::SkyModel;
use heliotile_scene::Scene;

use crate::scenes::*;

/// Open receivers at seven tilts, 300 m from a small black box and 2 m above an endless ground of albedo 0.2 at 31.5 m: the light of the
/// ground is 0.2 x (1 - cos)/2 of a uniform sky's and of the sun's horizontal irradiance, the sky (1 + cos)/2, all within 0.3 % of
/// the open sky's and of the sun's.
#[test]
fn tilted_over_endless_ground() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("written");
        path
    };
    let corners = "v 300 0 32\nv 301 0 32\nv 301 1 32\nv 300 1 32\nv 300 0 33\nv 301 0 33\nv 301 1 33\nv 300 1 33\n";
    let faces = "usemtl box\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let obj = write("s.obj", &format!("{corners}{faces}"));
    let toml = write("m.toml", "[box]\ndiffuse = 0\n[endless_ground]\nelevation = 31.5\ndiffuse = 0.2\n");
    let scene = Scene::load(&obj, Some(&toml)).expect("a scene");
    let tilts = [0.0, 20.0, 37.0, 60.0, 90.0, 135.0, 180.0];
    let receivers: Vec<_> =
        tilts.iter().map(|&t| receiver(&format!("{t}"), v(3.3, 1.7, 33.5), tilted(t, 140.0))).collect();
    let site = site(&scene, &receivers, &BuildSettings::default());
    let (dhi, dni, altitude) = (100.0, 800.0, 35.0_f64);
    let rows = site.replay(&[sun(200.0, altitude, dni, dhi)], SkyModel::Uniform, Depth::All);
    let direct = dni * altitude.to_radians().sin();
    for tilt in tilts {
        let (row, cos) = (rows[&format!("{tilt}")][0], tilt.to_radians().cos());
        let ground = 0.2 * (1.0 - cos) / 2.0;
        let errors = [
            (row.sky_direct / dhi - (1.0 + cos) / 2.0).abs(),
            (row.sky_diffuse / dhi - ground).abs(),
            (row.sun_diffuse / direct - ground).abs(),
        ];
        println!("tilt {tilt}: sky, its ground, the sun's ground off by {errors:.4?}");
        assert!(errors.iter().all(|error| *error < 0.003), "{tilt}: {errors:?}");
    }
}
