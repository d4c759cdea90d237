//! Traces and replays geometry that a program makes: a white wall on a ground under a clear and an
//! overcast sky.
//!
//! `cargo run --release --example geometry`

use std::path::Path;

use glam::DVec3;
use heliotile::{
    AccuracyRequest, Class, Component, ComponentSet, Condition, Material, Output, Quality, QueryRequest, Receiver,
    Resources, Scene, Silent, Site, SiteBuild, direction_from_degrees,
};

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
    let accuracy = AccuracyRequest { quality: Quality::Draft, ..AccuracyRequest::default() };
    let path = folder.join("site.helio");
    SiteBuild::new(&scene, &receivers[..], &accuracy).build(&Output::new(&path), &Silent)?;

    // The sun in the south at 40 degrees, and an overcast sky. Degrees, W/m2.
    let sun = direction_from_degrees(180.0, 40.0);
    let condition = |label: &str, dni, dhi| Condition::new(label.into(), &[sun], sun, dni, dhi);
    let conditions = [condition("clear", 800.0, 80.0), condition("overcast", 0.0, 150.0)];
    let (site, under) = (Site::open(path)?, QueryRequest::new(conditions.to_vec()).into());
    let columns = [Component::SunDirect, Component::SunReflected];
    site.under(&under, Path::new("-"), &Resources::usual())?.each(ComponentSet::new(&columns), |tile| {
        for (row, id) in tile.ids.iter().enumerate() {
            let [direct, reflected] = columns.map(|column| tile.values.row(column, row)[0]);
            each(id, direct, reflected);
        }
        Ok(true)
    })?;
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
