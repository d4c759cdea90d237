//! `heliotile info` of scene files. In: scene files. Out: counts, sizes, materials, and warnings of
//! oddities.

use std::fmt::Write;

use super::console::terminal::Terminal;
use super::{Outcome, say, warn};
use heliotile::covering::{SurfaceKind, Surfaces, doubts};
use heliotile::text::counted;
use heliotile::{Result, Scene, SceneFiles};

/// `heliotile info` of scene files.
pub fn info(site: &SceneFiles) -> Result<Outcome> {
    let (scene, soup) = Scene::load_with_objects(site)?;
    scene.report.tell(&Terminal::default());
    let surfaces = Surfaces::find(&soup, &scene.materials);
    doubts(&soup, &surfaces).iter().for_each(warn);
    let report = &scene.report;
    let mut out = String::new();
    for part in &site.parts {
        line!(out, "{}", part.file.display());
    }
    line!(out, "  objects     {}, {} closed", surfaces.objects.len(), surfaces.closed_objects);
    line!(
        out,
        "  faces       {}: {} triangles; dropped: {} without area, {} repeated",
        report.faces_read,
        report.triangles,
        report.degenerate_dropped,
        report.duplicates_dropped
    );
    let (low, high) = soup.bounds();
    let size = high - low;
    line!(
        out,
        "  bounds      {:.2} {:.2} {:.2} to {:.2} {:.2} {:.2} m: {:.1} x {:.1} x {:.1} m",
        low.x,
        low.y,
        low.z,
        high.x,
        high.y,
        high.z,
        size.x,
        size.y,
        size.z
    );
    let unknown = || "not known, y is taken for north: give --crs, or --latitude and --longitude".to_owned();
    line!(out, "  place       {}", scene.place.map_or_else(unknown, |place| place.to_string()));
    if let Some(turn) = site.frame.rotate_deg {
        line!(out, "  rotation    {turn} degrees clockwise, included in the direction of y");
    }
    materials(&mut out, &scene);
    for kind in SurfaceKind::ALL {
        let of_kind = || surfaces.list.iter().filter(|surface| surface.kind == kind);
        if of_kind().next().is_some() {
            let area: f64 = of_kind().map(|surface| surface.area_m2).sum();
            line!(out, "  {:11} {}, {area:.1} m2", kind.name(), counted(of_kind().count() as u64, "surface"));
        }
    }
    say(&out)?;
    Ok(Outcome::Fine)
}

fn materials(out: &mut String, scene: &Scene) {
    let mut area = vec![0.0; scene.materials.len()];
    for (i, &material) in scene.mesh.triangle_material.iter().enumerate() {
        let [a, b, c] = scene.mesh.triangle_points(i);
        area[usize::from(material)] += 0.5 * (b - a).cross(c - a).length();
    }
    let width = scene.materials.iter().map(|material| material.name.chars().count()).max().unwrap_or(0).clamp(8, 40);
    line!(out, "  {:width$}   triangles      area m2   light", "material");
    for ((material, used), area) in scene.materials.iter().zip(&scene.report.materials).zip(area) {
        let assumed = if scene.report.assumed.contains(&material.name) { " (assumed)" } else { "" };
        line!(out, "  {:width$} {:>11} {area:>12.1}   {}{assumed}", material.name, used.triangles, material.optics());
    }
}
