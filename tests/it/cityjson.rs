//! Published city models: the scene that is read from a tile, from a sequence of features and from
//! templates.

use std::path::{Path, PathBuf};

use heliotile_core::site::material::Class;
use heliotile_scene::Scene;
use heliotile_scene::site::{Part, SceneFiles};

fn file(name: &str) -> PathBuf {
    Path::new(crate::ROOT).join("tests/data/cityjson").join(name)
}

fn load(name: &str) -> Scene {
    Scene::load(&file(name), None).expect(name)
}

/// Returns the number of triangles and the area in m2 of a material.
fn share(scene: &Scene, material: &str) -> (usize, f64) {
    let number = scene.materials.iter().position(|known| known.name == material).expect(material);
    let own = (0..scene.mesh.triangles.len()).filter(|i| usize::from(scene.mesh.triangle_material[*i]) == number);
    let areas = own.map(|i| {
        let [a, b, c] = scene.mesh.triangle_points(i);
        0.5 * (b - a).cross(c - a).length()
    });
    areas.fold((0, 0.0), |(count, sum), area| (count + 1, sum + area))
}

/// A tile of The Hague keeps its 490 faces and, within 0.1 %, the areas of their outlines by
/// Newell's formula, by semantic type.
#[test]
fn the_hague_keeps_its_faces_and_areas() {
    let scene = load("hague.city.json");
    assert_eq!(scene.report.faces_read, 490);
    for (material, area, class) in [
        ("RoofSurface", 1470.686, Class::Obstruction),
        ("WallSurface", 6190.375, Class::Obstruction),
        ("GroundSurface", 1415.838, Class::Ground),
        ("TINRelief", 4905.345, Class::Ground),
    ] {
        let (_, found) = share(&scene, material);
        assert!((found / area - 1.0).abs() < 1e-3, "{material}: {found}");
        assert_eq!(scene.materials.iter().find(|known| known.name == material).map(|known| known.class), Some(class));
    }
    let (low, high) = scene.mesh.bounds();
    let middle = scene.mesh.origin + 0.5 * (low + high);
    assert!((middle.x - 78_739.0).abs() < 50.0 && (middle.y - 457_953.0).abs() < 50.0, "{middle}");
}

/// Three buildings of 3DBAG are read in LoD 2.2 without the 3 footprints, or in LoD 1.2 on request,
/// where each is a prism with one flat roof.
#[test]
fn a_sequence_is_read_in_the_requested_lod() {
    let fine = load("small.city.jsonl");
    assert_eq!(fine.report.faces_read, 6 + 6 + 21);
    let left_out: Vec<_> = fine.report.warnings.iter().filter(|warning| warning.contains("left out")).collect();
    assert_eq!(left_out.len(), 2, "{left_out:?}");
    assert!(left_out.iter().any(|warning| warning.contains("6 left out as geometry in another level of detail")));
    assert!(left_out.iter().any(|warning| warning.contains("3 left out as coarser geometry")));
    let coarse = Part { lod: Some("1.2".into()), ..Part::plain(&file("small.city.jsonl"), None) };
    let coarse = Scene::load_site(&SceneFiles { parts: vec![coarse], ..SceneFiles::default() }).expect("readable");
    assert_eq!(coarse.report.faces_read, 6 + 6 + 10);
    let (roof, ground) = (share(&coarse, "RoofSurface").1, share(&coarse, "GroundSurface").1);
    assert!((roof / ground - 1.0).abs() < 1e-9 && (110.0..125.0).contains(&roof), "{roof} {ground}");
    assert!(share(&fine, "RoofSurface").1 > roof);
}

/// Fifteen trees of 3 templates have, within 0.1 %, the areas of their templates in all, beside a
/// bridge.
#[test]
fn trees_have_the_areas_of_their_templates() {
    let scene = load("vegetation_templates.city.jsonl");
    let (_, trees) = share(&scene, "SolitaryVegetationObject");
    assert!((trees - TREES_M2).abs() < 1e-3 * TREES_M2, "{trees}");
    assert!(scene.materials.iter().any(|material| material.name == "Bridge"));
    let tree = scene.materials.iter().find(|material| material.name == "SolitaryVegetationObject").expect("trees");
    // Leaves scatter 0.425 of the light that a face stops.
    assert!((tree.diffuse - 0.425 * 0.83).abs() < 1e-9 && tree.transmittance == Some(0.17));
}

/// Sum of the areas of all outlines of 15 trees by Newell's formula, computed from the file, m2.
const TREES_M2: f64 = 3.162006;
