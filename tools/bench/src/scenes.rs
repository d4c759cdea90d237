//! Generated scenes of three sizes, always the same, and receivers on their buildings.

use glam::DVec3;
use heliotile_core::hemisphere::{mix, unit};
use heliotile_core::site::material::{Class, Material};
use heliotile_scene::Scene;

pub type Triangles = Vec<([DVec3; 3], u16)>;

pub struct Site {
    pub name: &'static str,
    pub scene: Scene,
    /// Point and unit normal, relative to the scene's origin.
    pub receivers: Vec<(DVec3, DVec3)>,
}

struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = mix(self.0, 0x6265_6e63);
        unit(self.0)
    }
}

/// A wall or roof cut into `cells` x `cells` quads.
fn facet(out: &mut Triangles, at: DVec3, a: DVec3, b: DVec3, cells: usize, material: u16) {
    let n = cells as f64;
    for i in 0..cells {
        for j in 0..cells {
            let p = at + a * (i as f64 / n) + b * (j as f64 / n);
            let (a, b) = (a / n, b / n);
            out.push(([p, p + a, p + a + b], material));
            out.push(([p, p + a + b, p + b], material));
        }
    }
}

/// Walls and a flat or gabled roof; receivers on the four walls.
fn house(out: &mut Triangles, places: &mut Vec<(DVec3, DVec3)>, low: DVec3, size: DVec3, cells: usize, gable: bool) {
    let (x, y, z) = (DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z);
    let walls =
        [(low, x, DVec3::NEG_Y), (low + x, y, DVec3::X), (low + x + y, -x, DVec3::Y), (low + y, -y, DVec3::NEG_X)];
    for (at, side, normal) in walls {
        facet(out, at, side, z, cells, 1);
        places.push((at + side * 0.37 + z * 0.41 + normal * 1e-3, normal));
    }
    if gable {
        let ridge = low + z + x * 0.5 + DVec3::Z * size.x * 0.4;
        let (a, b) = (low + z, low + z + x);
        out.push(([a, b, ridge], 1));
        out.push(([b + y, a + y, ridge + y], 1));
        facet(out, b, y, ridge - b, 1, 2);
        facet(out, a + y, -y, ridge - a, 1, 2);
    } else {
        facet(out, low + z, x, y, cells, 2);
        places.push((low + z + x * 0.3 + y * 0.6 + DVec3::Z * 1e-3, DVec3::Z));
    }
}

fn finish(name: &'static str, triangles: Triangles, places: Vec<(DVec3, DVec3)>, count: usize) -> Site {
    let material = |name: &str, diffuse| Material::matt(name, diffuse, Class::Obstruction);
    let materials = vec![material("ground", 0.2), material("wall", 0.4), material("roof", 0.2)];
    let scene = Scene::from_triangles(&triangles, materials).expect("a valid scene");
    let step = (places.len() / count).max(1);
    let receivers = places.into_iter().step_by(step).take(count).map(|(p, n)| (p - scene.mesh.origin, n)).collect();
    Site { name, scene, receivers }
}

/// 256 gabled houses, about 4,400 triangles.
pub fn town() -> Site {
    let mut random = Random(1);
    let (mut triangles, mut places) = (Vec::new(), Vec::new());
    facet(&mut triangles, DVec3::new(-50.0, -50.0, 0.0), DVec3::X * 420.0, DVec3::Y * 420.0, 8, 0);
    for i in 0..256 {
        let at = DVec3::new((i % 16) as f64 * 20.0, (i / 16) as f64 * 20.0, 0.0);
        let size = DVec3::new(7.0 + 5.0 * random.next(), 8.0 + 6.0 * random.next(), 4.0 + 5.0 * random.next());
        house(&mut triangles, &mut places, at, size, 1, true);
    }
    finish("town", triangles, places, 192)
}

/// 2,500 blocks of 120 triangles.
pub fn city() -> Site {
    let (mut triangles, mut places) = (Vec::new(), Vec::new());
    facet(&mut triangles, DVec3::new(-100.0, -100.0, 0.0), DVec3::X * 1700.0, DVec3::Y * 1700.0, 30, 0);
    blocks(&mut triangles, &mut places, |_, _| 0.0);
    finish("city", triangles, places, 192)
}

/// The city on hills of 4.7 million triangles.
pub fn big() -> Site {
    let (mut triangles, mut places) = (Vec::new(), Vec::new());
    let height = |x: f64, y: f64| 12.0 * (x * 0.004).sin() * (y * 0.0053).cos() + 2.0 * (x * 0.031 + y * 0.027).sin();
    let (n, low, step) = (1530, -700.0, 2.0);
    let at = |i: usize, j: usize| {
        let (x, y) = (low + i as f64 * step, low + j as f64 * step);
        DVec3::new(x, y, height(x, y))
    };
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.push(([a, b, c], 0));
            triangles.push(([a, c, d], 0));
        }
    }
    blocks(&mut triangles, &mut places, height);
    finish("big", triangles, places, 192)
}

fn blocks(triangles: &mut Triangles, places: &mut Vec<(DVec3, DVec3)>, ground: impl Fn(f64, f64) -> f64) {
    let mut random = Random(2);
    for i in 0..2500 {
        let (x, y) = ((i % 50) as f64 * 30.0, (i / 50) as f64 * 30.0);
        let size =
            DVec3::new(10.0 + 12.0 * random.next(), 10.0 + 12.0 * random.next(), 6.0 + 30.0 * random.next().powi(2));
        let low = DVec3::new(x, y, ground(x, y) - 2.0);
        // 5 facets of 12 quads, nearly: 4 x 3 is not square, so 3 x 3 and 4 x 4 in turn.
        house(triangles, places, low, size, if i % 2 == 0 { 3 } else { 4 }, false);
    }
}
