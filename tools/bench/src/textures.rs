//! What adaptive sky textures save: rays, seconds and wrong bits beside flat ones.

use std::time::Instant;

use glam::{DVec2, DVec3};
use heliotile_builder::trace::Tracer;
use heliotile_builder::trace::viewpoint::Viewpoint;
use heliotile_builder::trace::sky_fans::SkyFans;
use heliotile_core::hemisphere::texel_direction;
use heliotile_core::layers::bits::BitSquare;

use crate::scenes::Site;

/// One row for adaptive 128 to 1024, flat 256 and flat 1024: per receiver, one core.
pub fn table(site: &Site, receivers: usize) {
    let tracer = Tracer::new(&site.scene.mesh).expect("a tree");
    let step = (site.receivers.len() / receivers).max(1);
    let views: Vec<Viewpoint> = site
        .receivers
        .iter()
        .step_by(step)
        .take(receivers)
        .map(|&(position, normal)| Viewpoint { position: position + site.scene.mesh.origin, normal })
        .collect();
    let trace = |base: usize, fine: usize| -> (Vec<BitSquare>, f64, f64) {
        let fans = SkyFans::new(base, fine);
        let (mut rays, start) = (0, Instant::now());
        let sky = |view: &Viewpoint| {
            let traced = view.sky(&fans, &tracer);
            rays += traced.rays;
            traced.bits
        };
        let squares: Vec<BitSquare> = views.iter().map(sky).collect();
        let count = views.len() as f64;
        (squares, rays as f64 / count, start.elapsed().as_secs_f64() * 1e3 / count)
    };
    let flat = trace(1024, 1024);
    let name = format!("{} {}", site.name, site.scene.mesh.triangles.len());
    for (what, traced) in [("adaptive 128 to 1024", trace(128, 1024)), ("flat 256", trace(256, 256))] {
        let wrong: usize =
            flat.0.iter().zip(&traced.0).zip(&views).map(|((a, b), view)| different(a, b, view.normal)).sum();
        let share = 100.0 * wrong as f64 / (flat.0.len() * 1024 * 1024) as f64;
        println!("| {name} | {what} | {:.0} | {:.2} | {share:.4} % |", traced.1, traced.2);
    }
    println!("| {name} | flat 1024 | {:.0} | {:.2} | |", flat.1, flat.2);
}

/// Texels of the finer square, in front of the surface, whose bit another (coarser) one does not have.
fn different(fine: &BitSquare, other: &BitSquare, normal: DVec3) -> usize {
    let scale = fine.side() / other.side();
    (0..fine.side())
        .flat_map(|row| (0..fine.side()).map(move |column| (column, row)))
        .filter(|&(c, r)| fine.get(c, r) != other.get(c / scale, r / scale))
        .filter(|&(c, r)| normal.dot(texel_direction(c, r, fine.side(), DVec2::splat(0.5))) > 0.0)
        .count()
}
