//! Traces and replays geometry that a program makes: a white wall on a ground under a clear and an
//! overcast sky, with the crates below the requests.
//!
//! `cargo run --release --example geometry`

use glam::DVec3;
use heliotile_builder::pipeline::{Build, Output, Plan, PreparedScene, ReusedArchives, Workspace};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::settings::{Quality, Rungs};
use heliotile_core::archive::Archive;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Silent;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::material::{Class, Material};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::units::direction_from_degrees;
use heliotile_core::weather::conditions::Condition;
use heliotile_scene::Scene;

fn main() -> heliotile::Result<()> {
    let folder = tempfile::tempdir().map_err(heliotile::Error::io(&std::env::temp_dir(), "make a folder in"))?;
    wall_in_the_sun(folder.path(), |id, direct, reflected| {
        println!("{id}: {direct:.0} W/m2 from the sun, {reflected:.0} reflected by ground and wall");
    })
}

/// Calls `each` for each receiver with its direct and its reflected sun in the first condition,
/// W/m2.
fn wall_in_the_sun(folder: &std::path::Path, mut each: impl FnMut(&str, f32, f32)) -> heliotile::Result<()> {
    // A ground of 100 m x 100 m with a white wall on it, 10 m wide and high; metres, x east, y
    // north, z up.
    let quad = |a: DVec3, u: DVec3, v: DVec3, material: u16| {
        [([a, a + u, a + u + v], material), ([a, a + u + v, a + v], material)]
    };
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let ground = quad(-50.0 * x - 50.0 * y, 100.0 * x, 100.0 * y, 0);
    let wall = quad(-5.0 * x + 5.0 * y, 10.0 * x, 10.0 * z, 1);
    let materials = vec![Material::matt("ground", 0.2, Class::Ground), Material::matt("wall", 0.8, Class::Obstruction)];
    let scene = Scene::from_triangles(&[ground, wall].concat(), materials)?;

    // One receiver that looks up and one that looks at the wall.
    let receiver = |id: &str, normal: DVec3| Receiver::new(id.into(), z, normal);
    let receivers = [receiver("up", z), receiver("north", y)];
    let workspace = Workspace { folder: folder.into(), memory: MemoryBudget::DEFAULT };
    let mut tiles = ReceiverTiles::from_receivers(&receivers, scene.mesh.origin, folder, 1 << 20)?;
    let prepared = PreparedScene::new(&scene)?;
    let mut build = Build { scene: &prepared, receivers: &mut tiles, workspace: &workspace, observer: &Silent };
    let path = folder.join("site.helio");
    build.write(&Plan::of(Rungs::of(Quality::Draft).settings()), &Output::new(&path), &ReusedArchives::default())?;

    // The sun in the south at 40 degrees, and an overcast sky. Degrees, W/m2.
    let sun = direction_from_degrees(180.0, 40.0);
    let condition = |label: &str, dni, dhi| Condition::new(label.into(), &[sun], sun, dni, dhi);
    let conditions = [condition("clear", 800.0, 80.0), condition("overcast", 0.0, 150.0)];
    let archive = Archive::open(&path)?;
    let replay = Replay::new(&OpenSite::of(&archive)?, &conditions, ReplaySettings::default())?;
    for tile in replay.results(0..replay.tiles()) {
        let (ids, values) = tile?;
        for (row, id) in ids.iter().enumerate() {
            let [direct, reflected] = [Component::SunDirect, Component::SunDiffuse].map(|c| values.row(c, row)[0]);
            each(id, direct, reflected);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    /// The wall stands in the sun: the receiver that looks up gets 800 sin(40) W/m2 of it within 2,
    /// the one before the wall none, but more than 100 W/m2 from ground and wall.
    #[test]
    fn a_wall_reflects() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut count = 0;
        super::wall_in_the_sun(folder.path(), |id, direct, reflected| {
            count += 1;
            match id {
                "north" => assert!(direct == 0.0 && reflected > 100.0, "{direct} {reflected}"),
                _ => assert!((direct - 800.0 * 40_f32.to_radians().sin()).abs() < 2.0, "{direct}"),
            }
        })
        .expect("a wall");
        assert_eq!(count, 2);
    }
}
