//! Tests of rasters as scenes and beside other files.

use std::fmt::Write;

use glam::DVec3;

use crate::Scene;
use crate::placing::frame::UpAxis;
use crate::site::{Part, SceneFiles};
use crate::test_files::TestFolder;

/// Returns hills of `columns` x `rows` cells of 500 m from (400,000, 5,000,000), with one height
/// missing.
fn grid(columns: usize, rows: usize) -> String {
    let mut text = format!(
        "ncols {columns}\nnrows {rows}\nxllcorner 400000\nyllcorner 5000000\ncellsize 500\nNODATA_value -9999\n"
    );
    for i in 0..columns * rows {
        let (x, y) = ((i % columns) as f64, (i / columns) as f64);
        let height = 900.0 + 300.0 * (x * 0.3).sin() * (y * 0.2).cos();
        let height = if i == 7 * columns + 7 { -9999.0 } else { height };
        writeln!(text, "{height:.2}").expect("a string");
    }
    text
}

/// Returns a house of 10 m whose corners have millimetres, at the south-west end of the grid, and
/// its corners.
fn house() -> (String, [[f64; 3]; 4]) {
    let corners = [
        [402_000.125, 5_002_000.033, 950.017],
        [402_010.126, 5_002_000.033, 950.017],
        [402_010.126, 5_002_009.871, 953.401],
        [402_000.125, 5_002_009.871, 953.401],
    ];
    let vertices: String = corners.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    (format!("{vertices}usemtl roof\nf 1 2 3 4\n"), corners)
}

fn parts(files: &[(&str, String)]) -> (TestFolder, Vec<Part>) {
    let folder = TestFolder::new();
    let parts = files.iter().map(|(name, text)| Part::plain(&folder.write(name, text), None)).collect();
    (folder, parts)
}

fn load(parts: &[Part]) -> Scene {
    Scene::load_site(&SceneFiles { parts: parts.to_vec(), ..SceneFiles::default() }).expect("a scene")
}

/// A raster alone is 2 x 79 x 59 triangles less the 8 at nodata, all facing up, under material
/// `terrain`, without a note.
#[test]
fn a_raster_alone_is_not_thinned() {
    let (_folder, parts) = parts(&[("t.asc", grid(80, 60))]);
    let scene = load(&parts);
    assert_eq!(scene.mesh.triangles.len(), 2 * 79 * 59 - 8);
    assert!((0..scene.mesh.triangles.len()).all(|i| scene.mesh.normal(i).z > 0.5));
    assert_eq!((scene.materials[0].name.as_str(), scene.report.notes.len()), ("terrain", 0));
    assert!(scene.report.warnings.iter().any(|w| w.contains("8 left out at nodata")), "{:?}", scene.report.warnings);
    let (low, high) = scene.mesh.bounds();
    let size = high - low;
    assert_eq!([size.x, size.y], [39_500.0, 29_500.0]);
}

/// Beside a house at its corner, terrain of 40 km leaves the house's corners within 0.1 mm. It is
/// thinned with a note of an error below 0.2 degrees, and its far corner, 46.8 km away, is lowered
/// by 149.4 m. The order of the files changes nothing.
#[test]
fn terrain_keeps_the_corners_of_a_house() {
    let (text, corners) = house();
    let (_folder, mut parts) = parts(&[("t.asc", grid(80, 60)), ("h.obj", text)]);
    let scene = load(&parts);
    let mesh = &scene.mesh;
    for corner in corners.map(DVec3::from) {
        let nearest = mesh.vertices.iter().map(|&v| (v + mesh.origin - corner).length()).fold(f64::MAX, f64::min);
        assert!(nearest < 1e-4, "{corner}: {nearest} m");
    }
    let [note] = scene.report.notes.as_slice() else { panic!("{:?}", scene.report.notes) };
    assert!(note.contains("(limit 0.2)") && note.contains("46.8 km") && note.contains("refraction 0.13"), "{note:?}");
    assert!(mesh.triangles.len() < 2 * 79 * 59, "{note:?}");
    // The sample in the north-east, (439,750, 5,029,750), is column 79 of row 0.
    let far = mesh
        .vertices
        .iter()
        .map(|&v| v + mesh.origin)
        .find(|p| (p.x - 439_750.0).abs() < 1.0 && (p.y - 5_029_750.0).abs() < 1.0);
    let level = 900.0 + 300.0 * (79.0_f64 * 0.3).sin();
    let (dx, dy) = (439_750.0 - 402_060.126, 5_029_750.0 - 5_002_059.871);
    let drop = 0.87 * (dx * dx + dy * dy) / (2.0 * 6_371_000.0);
    assert!((level - drop - far.expect("a corner").z).abs() < 0.02, "{drop} {level} {far:?}");
    parts.reverse();
    assert_eq!(load(&parts).content_hash(), scene.content_hash());
}

/// A limit of 0 degrees keeps all triangles beside a house; 0.2 degrees leave fewer than 0.02 do; y
/// up is refused.
#[test]
fn a_horizon_of_0_degrees_keeps_all_triangles() {
    let (text, _) = house();
    let (_folder, parts) = parts(&[("t.asc", grid(80, 60)), ("h.obj", text)]);
    let [terrain, house] = parts.as_slice() else { panic!("two parts") };
    let count = |angle: f64| {
        let terrain = Part { horizon_deg: Some(angle), ..terrain.clone() };
        load(&[terrain, house.clone()]).mesh.triangles.len()
    };
    let found = [0.0, 0.02, 0.2].map(count);
    assert_eq!(found[0], 2 * 79 * 59 - 8 + 2);
    assert!(found[0] > found[1] && found[1] > found[2], "{found:?}");
    let turned = Part { up: Some(UpAxis::Y), ..terrain.clone() };
    let message = Scene::load_site(&SceneFiles { parts: vec![turned], ..SceneFiles::default() })
        .expect_err("no y up")
        .to_string();
    assert!(message.contains("y up cannot be used for a raster"), "{message}");
}
