//! Rays per second of one core: heliotile's packets at every CPU level, its single rays and obvhs' own, on three scenes.
//! Prints one table; `--rays FOLDER` writes scenes and rays for the Embree program, `--quick` leaves the largest scene out,
//! `--textures` compares adaptive and flat sky textures instead, `--replay WEATHER SITE...` tells what replay costs, `--archive SITE
//! CONDITIONS` what trust costs, `--readers [SCENE...]` how fast scene files are read.

mod archives;
mod readers;
mod replays;
mod scenes;
mod textures;

use std::io::Write;
use std::time::Instant;

use glam::{DVec2, DVec3, Vec3A};
use heliotile_builder::trace::kernel::lanes::Level;
use heliotile_builder::trace::{Ray, Tracer};
use heliotile_core::hemisphere::{Frame, texel_direction, texels_in_blocks};
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::triangle::Triangle;
use scenes::Site;

/// Rays of the n x n texture of each receiver's own hemisphere, block by block.
fn hemispheres(site: &Site, tracer: &Tracer, n: usize, receivers: usize) -> Vec<Vec<Ray>> {
    let step = site.receivers.len() / receivers;
    let one = |&(p, normal): &(DVec3, DVec3)| {
        let origin = (p + normal * tracer.offset_m(p)).as_vec3().to_array();
        let frame = Frame::new(normal);
        let ray = |(c, r)| {
            let d = frame.to_world(texel_direction(c, r, n, DVec2::splat(0.5)));
            Ray { origin, direction: d.as_vec3().to_array() }
        };
        texels_in_blocks(n).map(ray).collect()
    };
    site.receivers.iter().step_by(step).take(receivers).map(one).collect()
}

/// Mray per second, median of five runs, and the share of rays that met something.
fn rate(sets: &[Vec<Ray>], mut run: impl FnMut(&[Ray]) -> usize) -> (f64, f64) {
    let rays: usize = sets.iter().map(Vec::len).sum();
    let mut rates = Vec::new();
    let mut met = 0;
    for _ in 0..5 {
        let start = Instant::now();
        met = sets.iter().map(|set| run(set)).sum();
        rates.push(rays as f64 / 1e6 / start.elapsed().as_secs_f64());
    }
    rates.sort_by(f64::total_cmp);
    (rates[2], met as f64 / rays as f64)
}

/// obvhs as it comes: its tree, its walk, its triangle test.
struct Stock {
    bvh: obvhs::bvh2::Bvh2,
    triangles: Vec<Triangle>,
}

impl Stock {
    fn new(site: &Site) -> Self {
        let mesh = &site.scene.mesh;
        let triangle = |i| {
            let [v0, v1, v2] = mesh.triangle_points(i).map(|p| Vec3A::from(p.as_vec3()));
            Triangle { v0, v1, v2 }
        };
        let triangles: Vec<Triangle> = (0..mesh.triangles.len()).map(triangle).collect();
        let bvh = build_bvh2_from_tris(&triangles, BvhBuildParams::slow_build(), &mut Default::default());
        let triangles = bvh.primitive_indices.iter().map(|&i| triangles[i as usize]).collect();
        Stock { bvh, triangles }
    }

    fn ray(ray: &Ray) -> ObvhsRay {
        ObvhsRay::new_inf(Vec3A::from(ray.origin), Vec3A::from(ray.direction))
    }

    fn any(&self, rays: &[Ray]) -> usize {
        let met = |ray: &&Ray| {
            let ray = Stock::ray(ray);
            !self.bvh.ray_traverse_miss(ray, |ray, id| self.triangles[id].intersect(ray))
        };
        rays.iter().filter(met).count()
    }

    fn closest(&self, rays: &[Ray]) -> usize {
        let met = |ray: &&Ray| {
            let mut hit = RayHit::none();
            self.bvh.ray_traverse(Stock::ray(ray), &mut hit, |ray, id| self.triangles[id].intersect(ray))
        };
        rays.iter().filter(met).count()
    }
}

/// Triangles and rays as plain little-endian numbers.
fn export(path: &str, site: &Site, sets: &[&[Vec<Ray>]]) -> std::io::Result<()> {
    let mut out = std::io::BufWriter::new(std::fs::File::create(path)?);
    let mesh = &site.scene.mesh;
    out.write_all(&(mesh.triangles.len() as u32).to_le_bytes())?;
    for i in 0..mesh.triangles.len() {
        for x in mesh.triangle_points(i).iter().flat_map(|p| p.as_vec3().to_array()) {
            out.write_all(&x.to_le_bytes())?;
        }
    }
    for set in sets {
        let rays: Vec<&Ray> = set.iter().flatten().collect();
        out.write_all(&(rays.len() as u32).to_le_bytes())?;
        for x in rays.iter().flat_map(|r| [r.origin, r.direction]).flatten() {
            out.write_all(&x.to_le_bytes())?;
        }
    }
    Ok(())
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = arguments.iter().position(|a| a == "--rays").map(|i| arguments[i + 1].clone());
    let quick = arguments.iter().any(|a| a == "--quick");
    if arguments.iter().any(|a| a == "--textures") {
        println!("| scene | sky texture | rays a receiver | ms a receiver | bits unlike flat 1024 |");
        println!("|---|---|---|---|---|");
        textures::table(&scenes::town(), 32);
        textures::table(&scenes::city(), 32);
        return;
    }
    if let Some(at) = arguments.iter().position(|a| a == "--replay") {
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
        let weather = arguments[at + 1].as_ref();
        return one.install(|| arguments[at + 2..].iter().for_each(|site| replays::run(site.as_ref(), weather)));
    }
    if let Some(at) = arguments.iter().position(|a| a == "--readers") {
        return readers::run(&arguments[at + 1..]);
    }
    if let Some(at) = arguments.iter().position(|a| a == "--archive") {
        archives::open(100_000);
        archives::query(arguments[at + 1].as_ref(), arguments[at + 2].as_ref());
        return;
    }
    println!("| scene | engine | 32^2 any | 32^2 closest | 256^2 any | 256^2 closest | hits |");
    println!("|---|---|---|---|---|---|---|");
    let sites: [fn() -> Site; 3] = [scenes::town, scenes::city, scenes::big];
    for make in sites.into_iter().take(if quick { 2 } else { 3 }) {
        let site = make();
        let name = format!("{} {}", site.name, site.scene.mesh.triangles.len());
        let reference = Tracer::new(&site.scene.mesh).expect("a tree");
        let small = hemispheres(&site, &reference, 32, 192);
        let large = hemispheres(&site, &reference, 256, 12);
        let row = |engine: String, any: &dyn Fn(&[Ray]) -> usize, closest: &dyn Fn(&[Ray]) -> usize, all: bool| {
            let (a, hits) = rate(&small, any);
            let (c, _) = rate(&small, closest);
            let [fine_any, fine_closest] = if all {
                [rate(&large, any).0, rate(&large, closest).0].map(|r| format!("{r:.1}"))
            } else {
                ["-".to_string(), "-".to_string()]
            };
            println!("| {name} | {engine} | {a:.1} | {c:.1} | {fine_any} | {fine_closest} | {:.4} % |", hits * 100.0);
        };
        for level in Level::available() {
            let tracer = Tracer::at_level(&site.scene.mesh, level).expect("a tree");
            let any = |rays: &[Ray]| tracer.occluded_many(rays).into_iter().filter(|m| *m).count();
            let closest = |rays: &[Ray]| tracer.closest_many(rays).iter().flatten().count();
            row(format!("packets {level:?}"), &any, &closest, true);
        }
        let any = |rays: &[Ray]| rays.iter().filter(|r| reference.occluded(**r)).count();
        let closest = |rays: &[Ray]| rays.iter().filter(|r| reference.closest(**r).is_some()).count();
        row("single rays".into(), &any, &closest, false);
        let stock = Stock::new(&site);
        row("obvhs single".into(), &|r| stock.any(r), &|r| stock.closest(r), true);
        if let Some(folder) = &folder {
            export(&format!("{folder}/{}.bin", site.name), &site, &[&small, &large]).expect("a writable folder");
        }
    }
}
