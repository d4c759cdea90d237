//! Terrain against an independent program: the sky view factor of a mountain basin.

use std::path::Path;

use glam::DVec3;
use heliotile_builder::trace::{Ray, Tracer};
use heliotile_scene::Scene;

const COLUMNS: usize = 156;
const ROWS: usize = 168;

/// Reads the samples of the reference, a float32 TIFF of whole strips, little-endian: its heights
/// begin after the directory, one after the other.
fn reference() -> Vec<f32> {
    let bytes = std::fs::read(Path::new(crate::ROOT).join("tests/data/terrain/lakes_basin_sky_view.tif"))
        .expect("the reference");
    let first = 483;
    bytes[first..first + 4 * COLUMNS * ROWS]
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes(b.try_into().expect("4")))
        .collect()
}

/// At 290 pixels of the Lakes Basin (156 x 168 cells of 50 m) the sky view of the tilted surface
/// (Dozier and Frew 1990) by 2,048 rays a pixel is in the mean within 0.005 of the independent
/// raster, and 95 % of pixels are within 0.02.
#[test]
fn a_basin_has_the_sky_view_of_its_raster() {
    let scene = Scene::load(&Path::new(crate::ROOT).join("tests/data/terrain/lakes_basin.tif"), None).expect("a scene");
    assert_eq!(scene.mesh.triangles.len(), 2 * 155 * 167);
    let tracer = Tracer::new(&scene.mesh).expect("a tracer");
    let reference = reference();
    let mut height = vec![0.0; COLUMNS * ROWS];
    for vertex in &scene.mesh.vertices {
        let place = *vertex + scene.mesh.origin;
        let (column, row) = ((place.x - 320_000.0) / 50.0, (4_166_650.0 - place.y) / 50.0);
        height[row.round() as usize * COLUMNS + column.round() as usize] = vertex.z;
    }
    let (mut differences, mut sum) = (Vec::new(), 0.0);
    for i in (0..COLUMNS * ROWS).step_by(83) {
        let (column, row) = (i % COLUMNS, i / COLUMNS);
        if column < 2 || row < 2 || column > COLUMNS - 3 || row > ROWS - 3 {
            continue;
        }
        let slope = |a: usize, b: usize| (height[i + a] - height[i - b]) / 100.0;
        let normal = DVec3::new(-slope(1, 1), slope(COLUMNS, COLUMNS), 1.0).normalize();
        let place =
            DVec3::new(320_000.0 + 50.0 * column as f64, 4_166_650.0 - 50.0 * row as f64, 0.0) - scene.mesh.origin;
        let from = DVec3::new(place.x, place.y, height[i] + 0.05);
        let (side, along) = (normal.any_orthonormal_vector(), normal);
        let other = along.cross(side);
        let rays: Vec<Ray> = (0..2048)
            .map(|k| {
                // Directions are cosine-weighted, on a spiral of the golden angle.
                let (r, phi) = (((f64::from(k) + 0.5) / 2048.0).sqrt(), f64::from(k) * 2.399_963_229_728_653);
                let direction = side * (r * phi.cos()) + other * (r * phi.sin()) + along * (1.0 - r * r).sqrt();
                Ray { origin: from.as_vec3().to_array(), direction: direction.as_vec3().to_array() }
            })
            .collect();
        let met = tracer.occluded_many(&rays);
        let open = rays.iter().zip(met).filter(|(ray, met)| !met && ray.direction[2] > 0.0).count();
        let difference = open as f64 / 2048.0 - f64::from(reference[i]);
        sum += difference;
        differences.push(difference.abs());
    }
    differences.sort_by(f64::total_cmp);
    let count = differences.len();
    let (mean, most) = (sum / count as f64, differences[count * 95 / 100]);
    println!("{count} pixels: mean difference {mean:.4}, 95 % within {most:.4}, worst {:.4}", differences[count - 1]);
    assert!(count > 280 && mean.abs() < 0.005 && most < 0.02, "{count} {mean} {most}");
}
